//! A run of the machine with what is measured in every run: how far the tip is from its reference,
//! and what went beyond limits and ratings. [`RecordedRun`] keeps signals of it for what is
//! measured afterwards.

use std::fmt;

use anyhow::{Error, Result, anyhow};
use cosim::run::simulate;
use cosim::{Experiment, Master, Port, Recording, Signals, System, Verdict, matching, start_value};

use super::limits::{LimitWatch, reference};
use crate::setup::machine_choice::MachineFile;

/// The controller's output of which the tip error is made.
const TIP_ERROR: &str = "tip_error_norm";
/// The controller's parameter that says when the reference begins to move.
const MOTION_START: &str = "settle_time";
/// The controller's output that says when the reference has come to its end.
const MOTION_END: &str = "motion_end";

/// The controller's output of which the tip error is made.
///
/// # Errors
/// The system has no such controller.
pub fn tip_error_port(system: &System) -> Result<Port> {
    system.port(TIP_ERROR)
}

/// When the reference begins to move under the start values of `experiment`, s; 0 for a controller
/// that does not say it.
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

/// When the reference comes to its end, s; nothing for a controller that does not say it, or whose
/// reference goes on.
pub fn motion_end(system: &System, master: &Master) -> Option<f64> {
    let controller = tip_error_port(system).ok()?.component;
    let end = master.number(system.port_of(controller, MOTION_END).ok()?);
    end.ok().filter(|end| *end > master.time())
}

/// When a run ends, s: at the stop time asked for, else at the end of the motion, else at that of the
/// default experiment.
pub fn end(system: &System, experiment: &Experiment, master: &Master) -> Result<f64> {
    match (experiment.stop, motion_end(system, master)) {
        (None, Some(end)) => Ok(end),
        _ => experiment.stop(system),
    }
}

/// Root mean square and maximum of a distance, both m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    sum_of_squares: f64,
    count: u32,
    /// Largest distance, m.
    pub max: f64,
}

impl Distance {
    /// Add a sample, m.
    pub fn add(&mut self, distance: f64) {
        self.sum_of_squares += distance * distance;
        self.count += 1;
        self.max = self.max.max(distance);
    }

    /// Root mean square over the samples, m; 0 without any.
    pub fn rms(&self) -> f64 {
        if self.count == 0 {
            0.0
        } else {
            (self.sum_of_squares / f64::from(self.count)).sqrt()
        }
    }
}

impl fmt::Display for Distance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "RMSE {:.4} mm, max {:.4} mm",
            1e3 * self.rms(),
            1e3 * self.max
        )
    }
}

/// Tip error over the whole run and over the motion alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipError {
    /// From here on the reference moves, s.
    pub motion_start: f64,
    /// Samples from `motion_start` on: what the paper calls tracking.
    pub motion: Distance,
    /// All samples, with the time in which the machine settles.
    pub whole: Distance,
}

impl TipError {
    /// No samples yet.
    pub fn new(motion_start: f64) -> Self {
        Self {
            motion_start,
            motion: Distance::default(),
            whole: Distance::default(),
        }
    }

    /// As text for people, of two lines.
    pub fn text(&self) -> String {
        format!(
            "tip error, motion from {} s on: {}\ntip error, whole run:           {}\n",
            self.motion_start, self.motion, self.whole
        )
    }

    /// Add the error at time `t`.
    pub fn add(&mut self, t: f64, distance: f64) {
        self.whole.add(distance);
        if t >= self.motion_start {
            self.motion.add(distance);
        }
    }

    /// What the bound that the user has set on the error over the motion, m, says of it.
    pub fn verdict(&self, max_error: Option<f64>) -> Verdict {
        let mut verdict = Verdict::default();
        if let Some(bound) = max_error
            && self.motion.max > bound
        {
            let (max, bound) = (1e3 * self.motion.max, 1e3 * bound);
            verdict.object(format!(
                "tip error: up to {max:.4} mm, more than {bound} mm"
            ));
        }
        verdict
    }
}

/// What came out of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Residuals, times and messages.
    pub run: simulate::Outcome,
    /// Tip error.
    pub tip: TipError,
    /// What the machine's limits and ratings and its reference say of the run.
    pub limits: Verdict,
}

/// A run that failed after something had gone beyond its limits.
#[derive(Debug)]
pub struct FailedRun {
    error: Error,
    /// What was beyond its limits until then.
    pub limits: Verdict,
}

/// Run to the stop time asked for, else to the end of the motion, else to that of the default
/// experiment; `observe` sees every communication point, `progress` is told the numbers of finished
/// and of all steps from time to time.
///
/// # Errors
/// The run failed; a [`FailedRun`] where something was beyond its limits until then.
pub fn run(
    system: &System,
    experiment: &Experiment,
    progress: &dyn Fn(u64, u64),
    mut observe: impl FnMut(&Master) -> Result<()>,
) -> Result<Outcome> {
    let file = MachineFile::from_plant(system, &experiment.settings)?;
    let master = experiment.start(system).map_err(refused_path)?;
    let parameter = |port| master.number(port);
    let tip_error = tip_error_port(system)?;
    let of_controller = |name| parameter(system.port_of(tip_error.component, name)?);
    let mut tip = TipError::new(of_controller(MOTION_START).unwrap_or(0.0));
    let stop = end(system, experiment, &master)?;
    let mut watch = LimitWatch::new(system, &parameter, file.as_ref())?;
    let mut limits = reference(system, &parameter)?;
    let mut signals = Signals::new(system, &[&[tip_error], watch.ports()].concat())?;
    let done = simulate::run(system, master, stop, progress, |master| {
        let [distance, watched @ ..] = signals.read(master)? else {
            unreachable!("the tip error is read first");
        };
        tip.add(master.time(), *distance);
        watch.add(master.time(), watched);
        observe(master)
    });
    limits.extend(watch.verdict());
    match done {
        Ok(run) => Ok(Outcome { run, tip, limits }),
        Err(error) if limits.is_bad() => Err(FailedRun { error, limits }.into()),
        Err(error) => Err(error),
    }
}

/// Where a path is refused, the path and a line for each reason, without the functions in which the
/// controller said it.
fn refused_path(error: Error) -> Error {
    let text = format!("{error:#}");
    let Some((_, refusal)) = text.split_once(": path `") else {
        return error;
    };
    anyhow!("path `{}", refusal.replace("; ", "\n  "))
}

/// A run with signals kept in memory.
pub struct RecordedRun {
    /// The signals.
    pub recording: Recording,
    /// What else came out.
    pub outcome: Outcome,
}

impl RecordedRun {
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

    /// All that was found.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = self.run.verdict.clone();
        verdict.extend(self.limits.clone());
        verdict
    }
}

impl FailedRun {
    /// What was beyond its limits before a run failed with `error`.
    pub fn limits_before(error: &Error) -> Verdict {
        let failed = error.downcast_ref::<Self>();
        failed.map(|f| f.limits.clone()).unwrap_or_default()
    }

    /// `error` with what was beyond its limits before, in the text.
    pub fn explain(error: Error) -> Error {
        match error.downcast_ref::<Self>() {
            Some(failed) => anyhow!("{error:#}\n{}", failed.limits),
            None => error,
        }
    }
}

impl fmt::Display for FailedRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#}", self.error)
    }
}

impl std::error::Error for FailedRun {}

/// Signals that are recorded where none are named.
const USEFUL: [&str; 13] = [
    "*.tip_error_norm",
    "*.tip_error[*]",
    "*.desired.position[*]",
    "*.tip.position[*]",
    "hdrm.zeta[*]",
    "hdrm.x[*]",
    "hdrm.x_dot[*]",
    "emla_*.F",
    "emla_*.i_d",
    "emla_*.i_q",
    "controller.v_d[*]",
    "controller.v_q[*]",
    "controller.tau_wrist[*]",
];

/// The signals that are recorded where none are named, as far as the system has them.
pub fn default_signals(system: &System) -> Result<Vec<Port>> {
    let ports = |pattern: &str| matching(system, &[pattern.into()]).unwrap_or_default();
    Ok(USEFUL.into_iter().flat_map(ports).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_path_is_told_without_the_functions_that_refused_it() {
        let told = "controller: fmi2GetReal of v_d[1] returned fmi2Error: fmi2GetReal: path `/a/far.json`: the machine cannot do this path: \
                    waypoint 1 is out of reach; and 2 more";
        assert_eq!(
            refused_path(anyhow!(told)).to_string(),
            "path `/a/far.json`: the machine cannot do this path: waypoint 1 is out of reach\n  and 2 more"
        );
        let other = refused_path(anyhow!("emla_1: burnt; twice"));
        assert_eq!(other.to_string(), "emla_1: burnt; twice");
    }

    #[test]
    fn the_time_before_the_motion_counts_only_for_the_whole() {
        let mut e = TipError::new(2.0);
        for (t, d) in [(1.0, 5.0), (2.0, 3.0), (3.0, 4.0)] {
            e.add(t, d);
        }
        assert_eq!((e.motion.max, e.whole.max), (4.0, 5.0));
        assert!(
            (e.motion.rms() - 12.5f64.sqrt()).abs() < 1e-15,
            "(9 + 16)/2"
        );
        assert!((e.whole.rms() - (50.0f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(TipError::new(0.0).whole.rms(), 0.0);
    }

    #[test]
    fn the_largest_tip_error_is_compared_with_the_bound() {
        let mut tip = TipError::new(0.0);
        tip.add(1.0, 2e-3);
        assert!(!tip.verdict(None).is_bad() && !tip.verdict(Some(2e-3)).is_bad());
        assert!(tip.verdict(Some(1.9e-3)).is_bad());
    }
}
