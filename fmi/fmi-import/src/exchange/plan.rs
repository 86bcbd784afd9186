//! [`ExchangePlan`]: what an importer must know of an FMU for Model Exchange to integrate it, from
//! its description; the master makes it once, and `exchange` integrates by it.

use std::collections::HashMap;

use anyhow::{Result, bail, ensure};
use fmi_description::{
    Access, Capabilities, Causality, Description, Interface, Kind, Unknown, Variability, Variable,
};
use fmu_solver::{Choice, SparsityPattern};

use crate::batch::{Batch, Layout};

/// Most states of a model whose Jacobian may be full: 3 n² numbers would be stored.
const MOST_FULL: usize = 4096;

/// Most event indicators.
const MOST_INDICATORS: usize = 1_000_000;

/// Inputs whose derivatives are inputs, too, as the attribute `derivative` says: within a
/// communication step they follow these.
#[derive(Clone, Debug)]
pub(super) struct FollowedInputs {
    pub batch: Batch,
    /// The derivative of each, by index.
    pub sources: Vec<usize>,
    /// Start values and rates.
    pub start: [Vec<f64>; 2],
}

/// The states of an FMU and their derivatives, and how its variables may be set.
#[derive(Clone, Debug)]
pub struct ExchangePlan {
    /// The method of integration.
    pub choice: Choice,
    /// Number of states, all elements of arrays counted, and of event indicators.
    pub(super) states: usize,
    pub(super) indicators: usize,
    /// Names of the states, for messages.
    pub(super) names: Vec<String>,
    /// References of the states and of their derivatives.
    pub(super) known: Vec<u32>,
    pub(super) unknown: Vec<u32>,
    /// States that each derivative reads, all if that is not declared; None if the Jacobian would be
    /// too large.
    pub(super) pattern: Option<SparsityPattern>,
    pub(super) has_directional: bool,
    pub(super) completes_steps: bool,
    /// For each variable: it may be set between events.
    pub(super) is_continuous: Vec<bool>,
    pub(super) has_inputs: bool,
    pub(super) followed: Option<FollowedInputs>,
    /// Outputs that are integrated, and for each the variable that gets its mean over a step.
    pub(super) means: Option<(Batch, Vec<usize>)>,
    /// A twentieth of the experiment that the FMU proposes, s.
    pub(super) longest: Option<f64>,
}

impl ExchangePlan {
    /// From a description that has its variables [by element](Description::by_element).
    ///
    /// # Errors
    /// The description does not say what the states are.
    pub fn new(description: &Description, layout: &Layout) -> Result<Self> {
        check(description)?;
        let variables = &description.variables;
        let derivatives: Vec<&Unknown> = description.derivatives.iter().collect();
        // In FMI 3.0 the elements of an array follow each other, as in the file.
        let state = |u: &Unknown| {
            let first = description.state_of(u.variable)?;
            Some(first + variables[u.variable].element.unwrap_or(0))
        };
        let states: Vec<Option<usize>> = derivatives.iter().map(|u| state(u)).collect();
        let places: HashMap<usize, usize> = (states.iter().enumerate())
            .filter_map(|(place, state)| Some(((*state)?, place)))
            .collect();
        let reads = |(i, u): (usize, &&Unknown)| -> Option<Vec<(usize, usize)>> {
            let known = u.dependencies.as_ref()?.iter();
            let places = known.filter_map(|k| places.get(k));
            Some(places.map(|j| (i, *j)).collect())
        };
        let pairs: Option<Vec<_>> = derivatives.iter().enumerate().map(reads).collect();
        let n = states.len();
        let references = |variables: &mut dyn Iterator<Item = &Variable>| {
            let firsts = variables.filter(|v| v.element.unwrap_or(0) == 0);
            firsts.map(|v| v.reference).collect::<Vec<u32>>()
        };
        let known = states.iter().flatten().map(|k| &variables[*k]);
        let known = references(&mut known.into_iter());
        let unknown = references(&mut derivatives.iter().map(|u| &variables[u.variable]));
        let is_settable = |v: &Variable| {
            let is_number = matches!(v.access(), Access::Real | Access::Float32);
            v.is_input() && is_number && v.variability == Variability::Continuous
        };
        let e = &description.default_experiment;
        let length = e.stop.map(|stop| stop - e.start.unwrap_or(0.0));
        let follows = |source: usize| {
            let of = state(&Unknown {
                variable: source,
                dependencies: None,
            })?;
            let both = [of, source].map(|k| variables.get(k));
            let fits = |v: Option<&Variable>| {
                v.is_some_and(|v| is_settable(v) && v.access() == Access::Real)
            };
            both.into_iter().all(fits).then_some((of, source))
        };
        let (followed, sources): (Vec<usize>, Vec<usize>) =
            (0..variables.len()).filter_map(follows).unzip();
        let start = |all: &[usize]| {
            let numbers = all.iter().map(|k| variables[*k].start_number_of(0));
            numbers.map(|start| start.unwrap_or(0.0)).collect()
        };
        let followed = (!followed.is_empty()).then(|| FollowedInputs {
            start: [start(&followed), start(&sources)],
            batch: Batch::new(description, layout, followed),
            sources,
        });
        Ok(Self {
            choice: Choice::Automatic,
            followed,
            means: None,
            states: n,
            indicators: description.event_indicators,
            names: (states.iter().zip(&derivatives))
                .map(|(state, u)| variables[state.unwrap_or(u.variable)].name.clone())
                .collect(),
            has_directional: description.capabilities.directional_derivatives
                && states.iter().all(Option::is_some),
            known,
            unknown,
            pattern: match pairs {
                Some(pairs) => Some(SparsityPattern::new(n, pairs.into_iter().flatten())),
                None => (n <= MOST_FULL).then(|| SparsityPattern::full(n)),
            },
            completes_steps: description.capabilities.completes_steps,
            is_continuous: variables.iter().map(is_settable).collect(),
            has_inputs: variables.iter().any(Variable::is_input),
            longest: length
                .filter(|l| l.is_finite() && *l > 0.0)
                .map(|l| l / 20.0),
        })
    }

    /// Gives variables the means over a step of outputs, which the FMU does not know: pairs of an
    /// output and of the variable that gets its mean, by index.
    pub fn take_means(&mut self, description: &Description, layout: &Layout, of: &[[usize; 2]]) {
        let outputs = of.iter().map(|[output, _]| *output).collect();
        let means = of.iter().map(|[_, mean]| *mean).collect();
        self.means = Some((Batch::new(description, layout, outputs), means));
    }

    /// The pairs of which means are taken.
    pub fn means(&self) -> Vec<[usize; 2]> {
        let pair = |(output, mean): (&usize, &usize)| [*output, *mean];
        self.means
            .iter()
            .flat_map(|(outputs, means)| outputs.variables.iter().zip(means).map(pair))
            .collect()
    }

    /// Whether the stiff method can be used.
    pub fn can_be_stiff(&self) -> bool {
        self.pattern.is_some()
    }
}

/// Whether a description, by element, says what the states are.
fn check(description: &Description) -> Result<()> {
    let variables = &description.variables;
    let is_kept = |v: &Variable| matches!(v.causality, Causality::Output | Causality::Local);
    ensure!(
        description.event_indicators <= MOST_INDICATORS,
        "it has {} event indicators; {MOST_INDICATORS} are possible",
        description.event_indicators
    );
    let mut derivative_of: HashMap<usize, usize> = HashMap::new();
    for unknown in &description.derivatives {
        let v = &variables[unknown.variable];
        let name = &v.name;
        ensure!(
            v.kind == Kind::Real,
            "`{name}` is listed as a derivative (ModelStructure), but is no Real"
        );
        ensure!(
            v.derivative.is_some(),
            "`{name}` is listed as a derivative (ModelStructure), but its attribute `derivative` does not say of which state"
        );
        let Some(first) = description.state_of(unknown.variable) else {
            bail!("`{name}` is the derivative of a variable that is not there");
        };
        let place = first + v.element.unwrap_or(0);
        let of = variables
            .get(place)
            .filter(|x| x.reference == variables[first].reference);
        let Some(state) = of else {
            let state = variables[first].name.trim_end_matches("[1]");
            bail!("`{name}` is the derivative of an element that `{state}` does not have");
        };
        ensure!(
            state.kind == Kind::Real
                && state.variability == Variability::Continuous
                && is_kept(state),
            "`{name}` is the derivative of `{}`, which is no state: a state is a continuous Real, local or an output",
            state.name
        );
        if let Some(other) = derivative_of.insert(place, unknown.variable) {
            let other = &variables[other].name;
            bail!(
                "`{name}` and `{other}` are both the derivative of `{}`",
                state.name
            );
        }
    }
    if description.derivatives.is_empty() {
        let mut all = variables
            .iter()
            .enumerate()
            .filter(|(_, v)| v.causality == Causality::Local);
        let of = |(k, v): (usize, &Variable)| Some((v.name.clone(), description.state_of(k)?));
        let is_state = |(_, state): &(String, usize)| is_kept(&variables[*state]);
        if let Some((name, state)) = all.find_map(|v| of(v).filter(is_state)) {
            let state = &variables[state].name;
            bail!(
                "`{name}` is the derivative of `{state}`, but ModelStructure lists no derivatives: it would have no states"
            );
        }
    }
    Ok(())
}

/// A description by element, with the capabilities that an instance has for the master.
pub fn as_component(description: &Description) -> Description {
    let mut by_element = description.clone().by_element();
    let own = &mut by_element.capabilities;
    match by_element.interface {
        Interface::CoSimulation => {}
        Interface::ModelExchange => *own = component_capabilities(*own),
        // Whoever schedules decides when what is computed.
        Interface::ScheduledExecution => (own.event_mode, own.variable_step) = (true, true),
    }
    by_element
}

/// The capabilities of an FMU for Model Exchange that is integrated here, as a component.
fn component_capabilities(own: Capabilities) -> Capabilities {
    Capabilities {
        variable_step: true,
        interpolates_inputs: true,
        event_mode: true,
        output_derivative_order: 0,
        internal_step: None,
        ..own
    }
}
