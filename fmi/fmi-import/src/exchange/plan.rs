//! [`ExchangePlan`]: what an importer must know of an FMU for Model Exchange to integrate it, from
//! its description; the master makes it once, and `exchange` integrates by it.

use std::collections::HashMap;

use fmi_description::{
    Access, Capabilities, Description, Interface, Unknown, Variability, Variable,
};
use fmu_solver::SparsityPattern;

/// Most states of a model whose Jacobian may be full: 3 n² numbers would be stored.
const MOST_FULL: usize = 4096;

/// The states of an FMU and their derivatives, and how its variables may be set.
#[derive(Debug)]
pub struct ExchangePlan {
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
    /// A twentieth of the experiment that the FMU proposes, s.
    pub(super) longest: Option<f64>,
}

impl ExchangePlan {
    /// From a description that has its variables [by element](Description::by_element).
    pub fn new(description: &Description) -> Self {
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
        Self {
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
        }
    }
}

/// A description by element, with the capabilities that an instance has for the master.
pub fn as_component(description: &Description) -> Description {
    let mut by_element = description.clone().by_element();
    if by_element.interface == Interface::ModelExchange {
        by_element.capabilities = component_capabilities(by_element.capabilities);
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
