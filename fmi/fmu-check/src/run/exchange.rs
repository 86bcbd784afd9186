//! Probes of Model Exchange, for `supervision`, with an importer that integrates the states itself.

use anyhow::{Result, bail, ensure};

use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, InstanceOptions, start_time};
use fmi_import::raw::{Array, ContinuousValues, InstanceKind, RawInstance, Update};
use fmi_import::standard::Mode;

/// Heading of the probes of Model Exchange.
pub(super) const AREA: &str = "model exchange";
/// Steps of the integrator.
const STEPS: usize = 200;

probes! {
    "model exchange" {
        opened integrate:
            "an importer integrates it, handles its events, and finds derivatives and states as variables too",
            "tools with a solver of their own take this interface";
        opened go_back.if_claimed(|c| c.saves_state):
            "a state that is set again leads to the same future in Model Exchange, bit for bit",
            "solvers repeat steps, and expect that equations depend on the state alone";
    }
}

/// An instance with the state of its integrator.
struct IntegratedInstance<'a> {
    instance: Instance<'a>,
    x: Vec<f64>,
    next: f64,
    events: usize,
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
        };
        new.handle_events()?;
        let nominals = new.read(ContinuousValues::Nominals, n)?;
        ensure!(
            nominals.iter().all(|x| *x > 0.0),
            "nominal values {nominals:?} must be positive"
        );
        Ok(new)
    }

    fn handle_events(&mut self) -> Result<()> {
        let (time, mut update) = (self.instance.time, Update::default());
        let handle = |raw: &RawInstance| raw.handle_events(&mut update);
        self.instance.done("events", handle)?;
        self.next = update.next;
        ensure!(
            !update.terminates,
            "the model ends the simulation at {time} s"
        );
        self.x = self.read(ContinuousValues::States, self.x.len())?;
        Ok(())
    }

    fn read(&self, which: ContinuousValues, n: usize) -> Result<Vec<f64>> {
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
        let set = |raw: &RawInstance| raw.set_continuous_states(Array::Elements(x));
        self.instance.done("fmi2SetContinuousStates", set)?;
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
    for step in 0..STEPS {
        model.step(step_length(fmu))?;
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
