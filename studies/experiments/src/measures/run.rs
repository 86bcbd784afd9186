//! Runs the machine once ([`run`]) and measures the tip's distance from its reference, and limits
//! and ratings that were exceeded: for the commands, the analyses, the report and Python.
//! [`RecordedRun`] also keeps signals, for measurements after the run.

use std::fmt;

use anyhow::{Error, Result, anyhow};
use cosim::run::interrupt::Interrupted;
use cosim::run::observer::{Function, Observer, Observers};
use cosim::run::simulate::{self, Plan, run_plan};
use cosim::{Experiment, Master, Port, Recording, Signals, System, Verdict, matching, start_value};

use super::limits::{LimitWatch, check_reference};
use crate::setup::machine_choice::MachineFile;

/// The controller's parameter for the time at which the reference starts to move.
const MOTION_START: &str = "settle_time";

/// The controller's output from which the tip error is taken.
pub fn tip_error_port(system: &System) -> Result<Port> {
    system.port("tip_error_norm")
}

/// When the reference starts to move under the start values of `experiment`, s; 0 if the controller
/// does not have that parameter.
pub fn motion_start(system: &System, experiment: &Experiment) -> Result<f64> {
    let controller = tip_error_port(system)?.component;
    match system.port_of(controller, MOTION_START) {
        Ok(port) => start_value(system, &experiment.settings, port),
        Err(_) => Ok(0.0),
    }
}

/// When the reference ends, s; `None` if it never ends or the controller has no `motion_end`.
pub fn motion_end(system: &System, master: &Master) -> Option<f64> {
    let controller = tip_error_port(system).ok()?.component;
    let end = master.number(system.port_of(controller, "motion_end").ok()?);
    end.ok().filter(|end| *end > master.time())
}

/// When a run ends, s: at the experiment's stop time, else at the end of the motion, else at the
/// stop time of the default experiment.
pub fn end_time(system: &System, experiment: &Experiment, master: &Master) -> Result<f64> {
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
    /// Adds a sample, m.
    pub fn add(&mut self, distance: f64) {
        self.sum_of_squares += distance * distance;
        self.count += 1;
        self.max = self.max.max(distance);
    }

    /// Root mean square over the samples, m; 0 without any.
    pub fn rms(&self) -> f64 {
        (self.sum_of_squares / f64::from(self.count.max(1))).sqrt()
    }
}

impl fmt::Display for Distance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rms, max) = (1e3 * self.rms(), 1e3 * self.max);
        write!(f, "RMSE {rms:.4} mm, max {max:.4} mm")
    }
}

/// Tip error over the whole run and over the motion alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipError {
    /// When the reference starts to move, s.
    pub motion_start: f64,
    /// Samples from `motion_start` on: what the paper calls tracking.
    pub motion: Distance,
    /// All samples, with the time in which the machine settles.
    pub whole: Distance,
}

impl TipError {
    /// Without samples yet.
    pub fn new(motion_start: f64) -> Self {
        Self {
            motion_start,
            ..Self::default()
        }
    }

    /// Two lines of text for people.
    pub fn text(&self) -> String {
        format!(
            "tip error, motion from {} s on: {}\ntip error, whole run:           {}\n",
            self.motion_start, self.motion, self.whole
        )
    }

    /// Adds the error, m, at time `t`, s.
    pub fn add(&mut self, t: f64, distance: f64) {
        self.whole.add(distance);
        if t >= self.motion_start {
            self.motion.add(distance);
        }
    }

    /// Bad if the error over the motion exceeds the user's bound `max_error`, m.
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

/// Watches a run of the machine: its tip error, its limits and ratings.
#[derive(Clone)]
pub struct MachineWatch {
    /// Tip error so far.
    pub tip: TipError,
    watch: LimitWatch,
    /// Findings on the reference.
    pub reference: Verdict,
    signals: Signals,
}

impl MachineWatch {
    /// For a run of `experiment` that begins; the limits are those of the manipulator's `file`.
    pub fn new(
        system: &System,
        experiment: &Experiment,
        master: &Master,
        file: Option<&MachineFile>,
    ) -> Result<Self> {
        let parameter = |port| master.number(port);
        let tip_error = tip_error_port(system)?;
        let of_controller = |name| parameter(system.port_of(tip_error.component, name)?);
        let tip = TipError::new(of_controller(MOTION_START).unwrap_or(0.0));
        let watch = LimitWatch::new(system, &parameter, file)?;
        let reference = check_reference(system, experiment, &parameter)?;
        let signals = Signals::new(system, &[&[tip_error], watch.ports()].concat())?;
        Ok(Self {
            tip,
            watch,
            reference,
            signals,
        })
    }

    /// Adds the present communication point.
    pub fn add(&mut self, master: &Master) -> Result<()> {
        let [distance, watched @ ..] = self.signals.read(master)? else {
            unreachable!("the tip error is read first");
        };
        self.tip.add(master.time(), *distance);
        self.watch.add(master.time(), watched);
        Ok(())
    }

    /// Findings on limits, ratings and the reference; a run that failed tells no alarm.
    pub fn verdict(&self, system: &System, is_whole: bool) -> Verdict {
        let mut limits = self.reference.clone();
        limits.extend((self.watch).verdict(|port| is_whole && system.has_alarm(port)));
        limits
    }
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Residuals, times and messages.
    pub run: simulate::Outcome,
    /// Tip error.
    pub tip: TipError,
    /// Findings on limits, ratings and the reference.
    pub limits: Verdict,
}

/// Error of a run that failed after a limit had been exceeded.
#[derive(Debug)]
pub struct FailedRun {
    error: Error,
    limits: Verdict,
}

/// Runs to [`end_time`]. The `observer` sees every communication point, `progress` from time to time
/// the numbers of finished and of all steps. The error of a run that fails is a [`FailedRun`] if a
/// limit was exceeded before.
pub fn run(
    system: &System,
    experiment: &Experiment,
    progress: &dyn Fn(u64, u64),
    observer: &mut dyn Observer,
) -> Result<Outcome> {
    let file = MachineFile::from_plant(system, &experiment.settings)?;
    let started = experiment.start_until(system, experiment.stop);
    let master = started.map_err(refused_path)?;
    let stop = end_time(system, experiment, &master)?;
    let mut watch = MachineWatch::new(system, experiment, &master, file.as_ref())?;
    let own = &mut Function(|master: &Master| watch.add(master));
    let observers = &mut Observers(vec![own, observer]);
    let done = run_plan(system, master, &Plan::to(stop), progress, observers);
    let (limits, tip) = (watch.verdict(system, done.is_ok()), watch.tip);
    match done {
        Ok(run) => Ok(Outcome { run, tip, limits }),
        Err(error) if limits.is_bad() && !error.is::<Interrupted>() => {
            Err(FailedRun { error, limits }.into())
        }
        Err(error) => Err(error),
    }
}

/// If the controller refuses the path: the path and a line for each reason, without the FMI
/// function that reported it.
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
    /// The result.
    pub outcome: Outcome,
}

impl RecordedRun {
    /// Runs and records the variables `ports`.
    pub fn record(system: &System, experiment: &Experiment, ports: &[Port]) -> Result<Self> {
        let mut recording = Recording::new(system, ports)?;
        let outcome = run(system, experiment, &|_, _| (), &mut recording)?;
        Ok(Self { recording, outcome })
    }

    /// Values of a variable from the start of the motion on.
    pub fn motion(&self, port: Port) -> Result<&[f64]> {
        Ok(&self.recording.column(port)?[self.motion_start()..])
    }

    /// Index of the first communication point of the motion.
    pub fn motion_start(&self) -> usize {
        self.recording.first_from(self.outcome.tip.motion_start)
    }
}

impl Outcome {
    /// Text for people.
    pub fn summary(&self) -> String {
        self.tip.text() + &self.run.summary()
    }

    /// All findings.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = self.run.verdict.clone();
        verdict.extend(self.limits.clone());
        verdict
    }
}

impl FailedRun {
    /// The limits exceeded before a run failed with `error`.
    pub fn limits_before(error: &Error) -> Verdict {
        let failed = error.downcast_ref::<Self>();
        failed.map(|f| f.limits.clone()).unwrap_or_default()
    }

    /// `error` with the limits exceeded before it in the text.
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

/// Signals that are recorded by default.
const DEFAULT_SIGNALS: [&str; 13] = [
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

/// The signals that are recorded if the user names none, as far as the system has them.
pub fn default_signals(system: &System) -> Result<Vec<Port>> {
    let ports = |pattern: &str| matching(system, &[pattern.into()]).unwrap_or_default();
    Ok(DEFAULT_SIGNALS.into_iter().flat_map(ports).collect())
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
