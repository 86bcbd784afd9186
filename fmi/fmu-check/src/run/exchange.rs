//! Probes of Model Exchange, for `supervision`, with an importer that integrates the states itself.

use anyhow::{Result, bail};
use fmi_description::{Access, Causality, Variability, Variable};

use super::dependence::{self, Computed};
use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, InstanceOptions, references, start_time};
use fmi_import::raw::{Array, ContinuousValues, InstanceKind, RawInstance, Update};
use fmi_import::standard::Mode;

/// Heading of the probes of Model Exchange.
pub(super) const AREA: &str = "model exchange";
/// Steps of the integrator.
const STEPS: usize = 200;
/// How many states and how many inputs are moved at most.
const MOST: usize = 500;

probes! {
    "model exchange" {
        opened integrate:
            "an importer integrates it, handles its events, and finds derivatives and states as variables too",
            "tools with a solver of their own take this interface [FMI 2.0, 3.2; FMI 3.0, 3.2]";
        opened go_back.if_claimed(|c| c.saves_state):
            "a state that is set again leads to the same future in Model Exchange, bit for bit",
            "solvers repeat steps, and expect that equations depend on the state alone [FMI 2.0, 2.1.8; FMI 3.0, 2.2.7.4]";
        opened moving:
            "derivatives and outputs move at once only with states and inputs that they list in their dependencies",
            "solvers leave what is not listed out of their Jacobians, and importers read outputs too early [FMI 2.0, 2.2.8; FMI 3.0, 2.4.8]";
    }
}

/// An instance with the state of its integrator.
struct IntegratedInstance<'a> {
    instance: Instance<'a>,
    x: Vec<f64>,
    next: f64,
    events: usize,
    /// The model has asked to end the simulation.
    ends: bool,
}

impl<'a> IntegratedInstance<'a> {
    fn started(fmu: &'a Fmu, name: &str) -> Result<Self> {
        let options = InstanceOptions {
            kind: InstanceKind::ModelExchange,
            ..InstanceOptions::USUAL
        };
        let mut instance = Instance::with_options(fmu, name, options)?;
        instance.setup(start_time(fmu), None)?;
        instance.enter(Mode::Initialization)?;
        let exit = RawInstance::exit_initialization_mode;
        instance.done("fmi2ExitInitializationMode", exit)?;
        let derivatives = fmu.description.derivatives.iter();
        let sizes = derivatives.map(|u| fmu.description.variables[u.variable].size());
        let n = sizes.sum();
        let mut new = Self {
            instance,
            x: vec![0.0; n],
            next: f64::INFINITY,
            events: 0,
            ends: false,
        };
        new.handle_events()?;
        Ok(new)
    }

    fn handle_events(&mut self) -> Result<()> {
        let mut update = Update::default();
        let handle = |raw: &RawInstance| raw.handle_events(&mut update);
        self.instance.done("events", handle)?;
        self.next = update.next;
        self.ends |= update.terminates;
        self.x = self.read(ContinuousValues::States, self.x.len())?;
        Ok(())
    }

    fn read(&self, which: ContinuousValues, n: usize) -> Result<Vec<f64>> {
        if n == 0 {
            return Ok(Vec::new()); // not every FMU takes an array of length 0
        }
        let mut values = vec![f64::NAN; n];
        let name = format!("{} at t = {} s", which.function(), self.instance.time);
        let read = |raw: &RawInstance| raw.get_continuous(which, Some(&mut values), n);
        self.instance.done(&name, read)?;
        match values.iter().position(|x| !x.is_finite()) {
            Some(k) => bail!("{name}: number {k} is {}", values[k]),
            None => Ok(values),
        }
    }

    /// Sets the time and the states, and gets the derivatives.
    fn derivatives(&mut self, t: f64, x: &[f64]) -> Result<Vec<f64>> {
        self.instance.time = t;
        (self.instance).done("fmi2SetTime", |raw| raw.set_time(t))?;
        if !x.is_empty() {
            let set = |raw: &RawInstance| raw.set_continuous_states(Array::Elements(x));
            self.instance.done("fmi2SetContinuousStates", set)?;
        }
        self.read(ContinuousValues::Derivatives, x.len())
    }

    fn indicators(&self) -> Result<Vec<f64>> {
        let n = self.instance.fmu.description.event_indicators;
        self.read(ContinuousValues::Indicators, n)
    }

    /// Makes a step by Heun's method, and handles the events at its end.
    fn step(&mut self, h: f64) -> Result<()> {
        let (t, x, before) = (self.instance.time, self.x.clone(), self.indicators()?);
        let h = h.min(self.next - t);
        let along = |h: f64, dx: &[f64]| -> Vec<f64> {
            x.iter().zip(dx).map(|(x, dx)| x + h * dx).collect()
        };
        let a = self.derivatives(t, &x)?;
        let b = self.derivatives(t + h, &along(h, &a))?;
        self.x = along(0.5 * h, &a)
            .iter()
            .zip(&b)
            .map(|(x, b)| x + 0.5 * h * b)
            .collect();
        let end = self.x.clone();
        self.derivatives(t + h, &end)?;
        let mut requests = [false; 2];
        let complete = |raw: &RawInstance| raw.completed_integrator_step(&mut requests);
        self.instance
            .done("fmi2CompletedIntegratorStep", complete)?;
        self.ends |= requests[1];
        let after = self.indicators()?;
        let passed = before
            .iter()
            .zip(&after)
            .any(|(a, b)| (*a > 0.0) != (*b > 0.0));
        if passed || requests[0] || t + h >= self.next {
            let enter = "fmi2EnterEventMode";
            self.instance.done(enter, RawInstance::enter_event_mode)?;
            self.events += 1;
            self.handle_events()?;
        }
        Ok(())
    }
}

impl IntegratedInstance<'_> {
    /// The derivatives and Real outputs in a state, as bits.
    fn computed(&mut self, x: &[f64]) -> Result<Computed<u64>> {
        let rates = self.derivatives(self.instance.time, x)?;
        let description = &self.instance.fmu.description;
        let (variables, unknowns) = (&description.variables, &description.derivatives);
        let outputs = self
            .instance
            .must_read(&references(variables, is_real_output))?;
        let of = |k: usize| vec![k; variables[k].size()];
        let all = (0..variables.len()).filter(|k| is_real_output(&variables[*k]));
        let owners = unknowns.iter().map(|u| u.variable).chain(all).flat_map(of);
        let values = rates.iter().chain(&outputs).map(|value| value.to_bits());
        Ok(owners.zip(values).collect())
    }

    /// Moves one state or continuous input at a time by a `part` of its size, and compares what
    /// moves with what is declared. Returns the number of pairs.
    fn compare(&mut self, part: f64, outcome: &mut Outcome) -> Result<usize> {
        let (description, x) = (&self.instance.fmu.description, self.x.clone());
        let (variables, mut acting) = (&description.variables, 0);
        let states = description.derivatives.iter();
        let states = states.filter_map(|u| description.state_of(u.variable));
        let states = states
            .flat_map(|k| vec![k; variables[k].size()])
            .enumerate();
        let inputs = (0..variables.len()).filter(|k| {
            let v = &variables[*k];
            let is_real = v.access() == Access::Real && v.size() == 1;
            is_real && v.is_input() && v.variability == Variability::Continuous
        });
        let states = states.map(|(place, k)| (Some(place), k)).take(MOST);
        for (place, known) in states.chain(inputs.map(|k| (None, k)).take(MOST)) {
            let v = &variables[known];
            let old = match place {
                Some(place) => x[place],
                None => self.instance.read(v)?[0],
            };
            let by = part * v.nominal.unwrap_or(1.0).abs().max(old.abs());
            let [min, max] = v.bounds();
            let fits = |to: &f64| (min..=max).contains(to);
            let Some(new) = [old + by, old - by].into_iter().find(fits) else {
                continue;
            };
            let mut at = |value: f64| {
                let mut x = x.clone();
                match place {
                    Some(place) => x[place] = value,
                    None => {
                        let status = self.instance.set_reals(&[v.reference], &[value]);
                        self.instance.must("fmi2SetReal", status)?;
                    }
                }
                self.computed(&x)
            };
            if let [Ok(before), Ok(after), Ok(again)] = [old, new, old].map(&mut at) {
                let values = [&before, &after, &again];
                acting += dependence::compare(description, known, values, false, outcome);
            }
        }
        Ok(acting)
    }
}

fn is_real_output(v: &Variable) -> bool {
    v.causality == Causality::Output && v.access() == Access::Real
}

fn moving(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut model = IntegratedInstance::started(fmu, "moving")?;
    let mut acting = 0;
    for part in [1e-3, 0.2] {
        acting = acting.max(model.compare(part, outcome)?);
        let mut steps = 0..5;
        steps.try_for_each(|_| model.step(step_length(fmu)))?;
    }
    outcome.note(format!("{acting} pairs move at once"));
    Ok(())
}

/// Step of the integrator, s: that of the default experiment or a two-hundredth of the experiment,
/// at most 1 ms.
fn step_length(fmu: &Fmu) -> f64 {
    let experiment = &fmu.description.default_experiment;
    let whole = experiment.stop.unwrap_or(1.0) - experiment.start.unwrap_or(0.0);
    let usual = whole / STEPS as f64;
    experiment
        .step
        .map_or(usual, |step| step.min(usual))
        .min(1e-3)
}

fn integrate(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut model = IntegratedInstance::started(fmu, "integrated")?;
    let described = |k: usize| &fmu.description.variables[k];
    let nominals = model.read(ContinuousValues::Nominals, model.x.len())?;
    if !nominals.iter().all(|x| *x > 0.0) {
        outcome.fail(format!("nominal values {nominals:?} must be positive"));
    }
    for step in 0..STEPS {
        model.step(step_length(fmu))?;
        if model.ends {
            break;
        }
        if step % 50 != 0 {
            continue;
        }
        let x = model.x.clone();
        let rates = model.derivatives(model.instance.time, &x)?;
        let mut from = 0;
        for unknown in &fmu.description.derivatives {
            let derivative = described(unknown.variable);
            let n = derivative.size();
            let Some(state) = fmu.description.state_of(unknown.variable).map(described) else {
                bail!("`{}` is the derivative of no variable", derivative.name);
            };
            for (variable, numbers) in [(state, &x), (derivative, &rates)] {
                let read = model.instance.read(variable)?;
                if read != numbers[from..from + n] {
                    outcome.fail(format!(
                        "`{}` is {read:?}, and {:?} among all",
                        variable.name,
                        &numbers[from..from + n]
                    ));
                }
            }
            from += n;
        }
    }
    outcome.note(format!(
        "{} states, {} indicators, {} events",
        model.x.len(),
        fmu.description.event_indicators,
        model.events
    ));
    Ok(())
}

fn go_back(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut model = IntegratedInstance::started(fmu, "repeated")?;
    let h = step_length(fmu);
    model.step(h)?;
    let (saved, time, x, next) = (
        model.instance.save()?,
        model.instance.time,
        model.x.clone(),
        model.next,
    );
    let mut futures = Vec::new();
    for _ in 0..2 {
        for _ in 0..20 {
            model.step(h)?;
        }
        futures.push(std::mem::replace(&mut model.x, x.clone()));
        model.instance.go_back(saved, time)?;
        model.next = next;
    }
    if futures[0] != futures[1] {
        outcome.fail(format!(
            "back at t = {time} s, the steps that follow give other numbers than before"
        ));
    }
    model.instance.free(saved)
}
