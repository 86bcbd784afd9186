//! Simulates: steps a system from its start to a stop time, with an observer at every communication
//! point, and returns the outcome. `cosim`, Python and the studies call it.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::exchange::bond::Residual;
use crate::instance::Ended;
use crate::master::Master;
use crate::run::interrupt::{self, Interrupted};
use crate::run::observer::{Function, Observer};
use crate::run::snapshot::RunState;
use crate::run::supervision::Supervision;
use crate::run::thread_choice;
use crate::run::verdict::Verdict;
use crate::stepping::StepCount;
use crate::structure::system::System;
use fmi_import::digits::short;

pub use crate::run::experiment::Experiment;
pub use crate::run::plan::Plan;

/// What came out of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Power residual of each bond.
    pub residuals: Vec<Residual>,
    /// Simulated time, s.
    pub simulated: f64,
    /// Numbers and lengths of steps, if lengths were chosen.
    pub steps: Option<StepCount>,
    /// Computing time, without loading and initialization.
    pub elapsed: Duration,
    /// Findings on the result: divergence, energy that the coupling created, warnings of the FMUs.
    pub verdict: Verdict,
}

/// As [`run_plan`], with steps of one length to `stop`, s, and a function as the observer.
pub fn run(
    system: &System,
    master: Master,
    stop: f64,
    progress: &dyn Fn(u64, u64),
    observe: impl FnMut(&Master) -> Result<()>,
) -> Result<Outcome> {
    let plan = Plan::to(stop);
    run_plan(system, master, &plan, progress, &mut Function(observe))
}

/// Steps `master`, which runs `system`, by a plan; the last step is shortened if necessary. The
/// `observer` sees every communication point from the first on, or from where the run is resumed,
/// and may end the run. `progress` receives the numbers of finished and of all steps from time to
/// time.
///
/// # Errors
/// A failed step, with the divergence that preceded it; [`Interrupted`]; a plan that this system
/// cannot follow; a snapshot of another run.
pub fn run_plan(
    system: &System,
    master: Master,
    plan: &Plan,
    progress: &dyn Fn(u64, u64),
    observer: &mut dyn Observer,
) -> Result<Outcome> {
    let stop = plan.stop;
    let (steps, lacks_rest) = plan.steps(system, &master)?;
    let mut verdict = Verdict::default();
    if let Some(fixed) = system.fixed_step().filter(|_| lacks_rest) {
        verdict.note(format!(
            "the last step is not shortened to end at {} s, because `{fixed}` cannot vary its step",
            short(stop)
        ));
    }
    let mut state = RunState {
        supervision: Supervision::new(system, &master, verdict)?,
        key: plan.key.as_ref(),
        master,
        steps,
    };
    if let Some(file) = &plan.resume {
        let resumed = (fs::read(file).map_err(Into::into)).and_then(|bytes| state.resume(&bytes));
        resumed.with_context(|| format!("`{}`", file.display()))?;
    }
    let start = state.master.time();
    let tolerance = 1e-6 * state.master.stepping().step;
    let is_past = |(time, _): &&(f64, PathBuf)| *time < start - tolerance;
    if let Some((time, file)) = plan.snapshots.iter().find(is_past) {
        let (file, time, start) = (file.display(), short(*time), short(start));
        bail!("the snapshot `{file}` at {time} s cannot be saved: the run begins at {start} s");
    }
    let mut due: Vec<_> = plan.snapshots.iter().collect();
    save(&mut due, &state)?;
    let clock = Instant::now();
    observer.observe(&state.master)?;
    let (mut timed, mut shortest, mut signal, mut is_readable) = (0, Duration::MAX, None, true);
    while !observer.is_done() && !state.steps.is_over(&state.master) {
        signal = interrupt::signal();
        if signal.is_some() {
            break;
        }
        timed += 1;
        let time = state.master.time();
        let before = (timed <= thread_choice::STEPS).then(Instant::now);
        let made = state.steps.make(&mut state.master);
        shortest = before.map_or(shortest, |before| before.elapsed().min(shortest));
        // The first steps were timed on one thread: several threads continue if that is faster.
        if let (thread_choice::STEPS, Ok(_), Some(experiment)) = (timed, &made, &plan.threads_for) {
            let (k, all) = state.steps.so_far(&state.master);
            let (left, supervision) = (all - k, &mut state.supervision);
            if let Some(faster) =
                thread_choice::multi_threaded(system, plan, experiment, shortest, left, supervision)
            {
                (state.master, state.steps) = faster;
            }
        }
        let observed = match made {
            Ok(false) => continue,
            Ok(true) => observer.observe(&state.master),
            Err(error) => Err(error),
        };
        if let Err(error) = observed {
            if error.downcast_ref::<Ended>().is_some() {
                state.supervision.findings.note(format!("{error:#}"));
                // What it has reached can be read, but nothing after a step that was not made.
                is_readable = state.master.time() > time && observer.observe(&state.master).is_ok();
                break;
            }
            return Err(state.supervision.explain(error, system, &state.master));
        }
        state.supervision.add(&state.master)?;
        save(&mut due, &state)?;
        let (k, all) = state.steps.so_far(&state.master);
        if k % 256 == 0 {
            progress(k, all);
        }
    }
    if is_readable {
        observer.end(&state.master)?;
    }
    if let Some(signal) = signal {
        let time = Some(state.master.time());
        // The run is over, whatever the FMUs say.
        let _ = state.master.terminate();
        return Err(Interrupted { signal, time }.into());
    }
    let (_, all) = state.steps.so_far(&state.master);
    progress(all, all);
    Ok(Outcome {
        elapsed: clock.elapsed(),
        residuals: state.master.residuals().to_vec(),
        simulated: state.master.time() - start,
        steps: state.steps.count(),
        verdict: state.supervision.end(system, state.master)?,
    })
}

/// Saves the run to the files whose time has come.
fn save(due: &mut Vec<&(f64, PathBuf)>, state: &RunState) -> Result<()> {
    if due.is_empty() {
        return Ok(());
    }
    let tolerance = 1e-6 * state.master.stepping().step;
    let now = |(time, _): &&(f64, PathBuf)| *time <= state.master.time() + tolerance;
    for (_, file) in due.extract_if(.., |snapshot| now(snapshot)) {
        let written = state.to_bytes();
        let written = written.and_then(|bytes| Ok(output_file::write(file, bytes)?));
        written.with_context(|| format!("the snapshot `{}`", file.display()))?;
    }
    Ok(())
}

impl Outcome {
    /// Simulated time divided by computing time.
    pub fn real_time_factor(&self) -> f64 {
        self.simulated / self.elapsed.as_secs_f64()
    }

    /// Residuals, steps and speed as text.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        let mut line = |l: String| writeln!(text, "{l}").expect("a String takes every text");
        for r in &self.residuals {
            let share = match r.turnover > 0.0 {
                true => 100.0 * r.energy.abs() / r.turnover,
                false => 0.0,
            };
            line(format!(
                "power residual of bond {}: peak {:.3} W, net {:.3e} J ({share:.1e} % of {:.3e} J turned over)",
                r.bond, r.peak, r.energy, r.turnover
            ));
        }
        if let Some(steps) = self.steps {
            let [shortest, longest] = steps.lengths.unwrap_or_default();
            line(format!(
                "{} communication steps of {shortest:.3e} s to {longest:.3e} s, {} computed",
                steps.made, steps.computed
            ));
        }
        line(format!(
            "{:.3} s simulated in {:.3} s: {:.0} x real time",
            self.simulated,
            self.elapsed.as_secs_f64(),
            self.real_time_factor()
        ));
        text
    }
}
