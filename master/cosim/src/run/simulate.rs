//! A run: a system stepped from its start to a stop time, observed at every communication point,
//! and what came out of it.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::exchange::bond::Residual;
use crate::instance::Ended;
use crate::master::Master;
use crate::run::observer::{Function, Observer};
use crate::run::snapshot::RunState;
use crate::run::supervision::Supervision;
use crate::run::trial;
use crate::run::verdict::Verdict;
use crate::stepping::StepCount;
use crate::structure::system::System;

pub use crate::run::experiment::Experiment;
pub use crate::run::plan::Plan;

/// What came out of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Power residual of each bond.
    pub residuals: Vec<Residual>,
    /// Simulated time, s.
    pub simulated: f64,
    /// Numbers and lengths of steps, where lengths were chosen.
    pub chosen: Option<StepCount>,
    /// Time it took, without loading and initialization.
    pub elapsed: Duration,
    /// What is to be said of the result: divergence, energy that the coupling made, warnings of the
    /// FMUs.
    pub verdict: Verdict,
}

/// As [`planned`], by steps of one length to `stop`, s, with a function as the observer.
///
/// # Errors
/// As [`planned`].
pub fn run(
    system: &System,
    master: Master,
    stop: f64,
    progress: &dyn Fn(u64, u64),
    observe: impl FnMut(&Master) -> Result<()>,
) -> Result<Outcome> {
    let plan = Plan::to(stop);
    planned(system, master, &plan, progress, &mut Function(observe))
}

/// Step `master`, which runs `system`, by a plan; the last step is shortened where it has to be. The
/// `observer` sees every communication point, the first included, and may end the run; a run that is
/// gone on with is observed from there on. `progress` is given the numbers of finished and of all
/// steps from time to time.
///
/// # Errors
/// Besides what went wrong: where the loops of the system began to diverge before. What the plan
/// asks for cannot be had of this system, or a file is none of its.
pub fn planned(
    system: &System,
    mut master: Master,
    plan: &Plan,
    progress: &dyn Fn(u64, u64),
    observer: &mut dyn Observer,
) -> Result<Outcome> {
    let Plan { stop, control, .. } = plan;
    let (mut steps, has_left_rest) = plan.steps(system, &master)?;
    let mut verdict = Verdict::default();
    if let Some(fixed) = system.fixed_step().filter(|_| has_left_rest) {
        verdict.note(format!(
            "the last step is not shortened to end at {stop} s, because `{fixed}` cannot vary its step"
        ));
    }
    let mut supervision = Supervision::new(system, &master, verdict);
    let mut state = RunState {
        system,
        control,
        master: &mut master,
        steps: &mut steps,
        supervision: &mut supervision,
    };
    if let Some(file) = &plan.resume {
        let resumed = fs::read(file).map_err(Into::into);
        let resumed = resumed.and_then(|bytes| state.resume(&bytes));
        resumed.with_context(|| format!("`{}`", file.display()))?;
    }
    let start = state.master.time();
    let mut due: Vec<_> = plan.snapshots.iter().filter(|(t, _)| *t >= start).collect();
    save(&mut due, &state)?;
    let clock = Instant::now();
    observer.observe(&master)?;
    let (mut tried, mut shortest) = (0, Duration::MAX);
    while !observer.is_done() && !steps.is_over(&master) {
        tried += 1;
        let before = (tried <= trial::STEPS).then(Instant::now);
        let made = steps.make(&mut master);
        shortest = before.map_or(shortest, |before| before.elapsed().min(shortest));
        if let (trial::STEPS, Ok(_), Some(alone)) = (tried, &made, &plan.alone) {
            let (k, all) = steps.so_far(&master);
            let trial = (system, plan, alone);
            if let Some(wide) = trial::wide(trial, shortest, all - k, &mut supervision) {
                (master, steps) = wide;
            }
        }
        let observed = match made {
            Ok(false) => continue,
            Ok(true) => observer.observe(&master),
            Err(error) => Err(error),
        };
        if let Err(error) = observed {
            if error.downcast_ref::<Ended>().is_some() {
                supervision.note(format!("{error:#}"));
                break;
            }
            return Err(supervision.explain(error, system, &master));
        }
        supervision.add(&master);
        if !due.is_empty() {
            save(
                &mut due,
                &RunState {
                    system,
                    control,
                    master: &mut master,
                    steps: &mut steps,
                    supervision: &mut supervision,
                },
            )?;
        }
        let (k, all) = steps.so_far(&master);
        if k % 256 == 0 {
            progress(k, all);
        }
    }
    let (_, all) = steps.so_far(&master);
    progress(all, all);
    let elapsed = clock.elapsed();
    let (residuals, simulated) = (master.residuals().to_vec(), master.time() - start);
    Ok(Outcome {
        residuals,
        simulated,
        chosen: steps.chosen(),
        elapsed,
        verdict: supervision.end(system, master)?,
    })
}

/// Save the run to the files that are due.
fn save(due: &mut Vec<&(f64, PathBuf)>, state: &RunState) -> Result<()> {
    let tolerance = 1e-6 * state.master.stepping().step;
    let now = |(time, _): &&(f64, PathBuf)| *time <= state.master.time() + tolerance;
    for (_, file) in due.extract_if(.., |snapshot| now(snapshot)) {
        let written = state.to_bytes();
        let written = written.and_then(|bytes| Ok(fs::write(file, bytes)?));
        written.with_context(|| format!("the snapshot `{}`", file.display()))?;
    }
    Ok(())
}

impl Outcome {
    /// Simulated time per time taken.
    pub fn real_time_factor(&self) -> f64 {
        self.simulated / self.elapsed.as_secs_f64()
    }

    /// The outcome as text for people.
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
        if let Some(StepCount {
            made,
            computed,
            lengths,
        }) = self.chosen
        {
            let [shortest, longest] = lengths.unwrap_or_default();
            line(format!(
                "{made} communication steps of {shortest:.3e} s to {longest:.3e} s, {computed} computed"
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
