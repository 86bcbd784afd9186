//! A run of the machine together with what its controller says of it: when the reference moves, and how far the tip is from it.

use anyhow::{Result, bail};
use cosim::master::{Master, Schedule, start_value};
use cosim::recording::Recording;
use cosim::run::{self, Experiment};
use cosim::signals::Signals;
use cosim::system::{Setting, System};
use cosim::wiring::Port;

use crate::tip::TipError;

/// The controller's output of which the tip error is made.
const TIP_ERROR: &str = "tip_error_norm";
/// The controller's parameter that says when the reference begins to move.
const MOTION_START: &str = "settle_time";
/// The controller's output that says when the reference has come to its end.
const MOTION_END: &str = "motion_end";

/// The parameter of controller and actuators that says how many steps late their outputs act.
const DELAY: &str = "delay";

/// Tell all components that have such a parameter that with the schedule `standard` their outputs act one step late. All of them: a
/// controller that predicts over the step needs actuators that do too.
pub fn tell_delay(system: &System, base: &mut Experiment) -> Result<()> {
    if base.stepping.schedule != Schedule::Standard {
        return Ok(());
    }
    for component in 0..system.structure.components.len() {
        let Ok(delay) = system.port_of(component, DELAY) else {
            continue;
        };
        if !base.settings.iter().any(|s| s.port == delay) {
            base.settings.push(system.setting(&system.name(delay), 1)?);
        }
    }
    Ok(())
}

/// The controller's output of which the tip error is made.
///
/// # Errors
/// The system has no such controller.
pub fn tip_error_port(system: &System) -> Result<Port> {
    system.port(TIP_ERROR)
}

/// When the reference begins to move under the start values of `experiment`, s; 0 for a controller that does not say it.
///
/// # Errors
/// The system has no such controller, or it refuses the start values.
pub fn motion_start(system: &System, experiment: &Experiment) -> Result<f64> {
    let controller = tip_error_port(system)?.component;
    match system.port_of(controller, MOTION_START) {
        Ok(port) => start_value(system, &experiment.settings, port),
        Err(_) => Ok(0.0),
    }
}

/// What came out of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Residuals, times and messages.
    pub run: run::Outcome,
    /// Tip error.
    pub tip: TipError,
}

/// `base` with the start values that a study varies.
///
/// # Errors
/// One of them is set in `base` or bound by the system, so that what was set would not count.
pub fn vary(
    system: &System,
    base: &Experiment,
    values: &[(&str, &dyn std::fmt::Display)],
) -> Result<Experiment> {
    let settings = values
        .iter()
        .map(|(name, value)| system.setting(name, value));
    with(system, base, settings.collect::<Result<_>>()?)
}

/// As [`vary`].
pub fn with(system: &System, base: &Experiment, settings: Vec<Setting>) -> Result<Experiment> {
    for Setting { port, .. } in &settings {
        let variable = &system.variable(*port).name;
        let component = &system.structure.components[port.component];
        if let Some(bound) = component.parameters.iter().find(|p| p.name == *variable) {
            bail!(is_varied(system, *port, &bound.origin));
        }
    }
    over(system, base, settings)
}

/// As [`with`], of what the system may bind too.
pub fn over(system: &System, base: &Experiment, settings: Vec<Setting>) -> Result<Experiment> {
    for Setting { port, .. } in &settings {
        if base.settings.iter().any(|s| s.port == *port) {
            bail!(is_varied(system, *port, "--set"));
        }
    }
    let mut experiment = base.clone();
    experiment.settings.extend(settings);
    Ok(experiment)
}

fn is_varied(system: &System, port: Port, origin: &str) -> String {
    let name = system.name(port);
    format!("`{name}` is set ({origin}), but this command varies it itself, so it must not be set")
}

/// Run to the stop time asked for, else to the end of the motion, else to that of the default experiment; `observe` sees every
/// communication point, `progress` is told the numbers of finished and of all steps from time to time.
pub fn run(
    system: &System,
    experiment: &Experiment,
    progress: &dyn Fn(u64, u64),
    mut observe: impl FnMut(&Master) -> Result<()>,
) -> Result<Outcome> {
    let master = experiment.start(system)?;
    let tip_error = tip_error_port(system)?;
    let of_controller = |name| {
        let port = system.port_of(tip_error.component, name);
        port.and_then(|port| master.number(port))
    };
    let mut tip = TipError::new(of_controller(MOTION_START).unwrap_or(0.0));
    let end = of_controller(MOTION_END)
        .ok()
        .filter(|end| *end > master.time());
    let stop = match (experiment.stop, end) {
        (None, Some(end)) => end,
        _ => experiment.stop(system)?,
    };
    let mut signal = Signals::new(system, &[tip_error])?;
    let run = run::run(system, master, stop, progress, |master| {
        tip.add(master.time(), signal.read(master)?[0]);
        observe(master)
    })?;
    Ok(Outcome { run, tip })
}

/// A run with signals kept in memory.
pub struct Recorded {
    /// The signals.
    pub recording: Recording,
    /// What else came out.
    pub outcome: Outcome,
}

impl Recorded {
    /// Run and keep the variables `ports`.
    pub fn of(system: &System, experiment: &Experiment, ports: &[Port]) -> Result<Self> {
        let mut recording = Recording::new(system, ports)?;
        let outcome = run(system, experiment, &|_, _| (), |master| {
            recording.add(master)
        })?;
        Ok(Self { recording, outcome })
    }

    /// Values of a variable over the motion: from the time on at which the reference moves.
    pub fn motion(&self, port: Port) -> Result<&[f64]> {
        Ok(&self.recording.column(port)?[self.motion_start()..])
    }

    /// Index of the first communication point of the motion.
    pub fn motion_start(&self) -> usize {
        self.recording.first_from(self.outcome.tip.motion_start)
    }
}

impl Outcome {
    /// The outcome as text for people.
    pub fn summary(&self) -> String {
        self.tip.text() + &self.run.summary()
    }
}
