//! A run: a system stepped from its start to a stop time, observed at every communication point,
//! and what came out of it.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::bond::Residual;
use crate::crew::cores;
use crate::master::Master;
use crate::observer::{Function, Observer};
use crate::slave::Ended;
use crate::stepping::FixedSteps;
use crate::supervision::Supervision;
use crate::system::System;
use crate::verdict::Verdict;

pub use crate::experiment::Experiment;

/// What came out of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Power residual of each bond.
    pub residuals: Vec<Residual>,
    /// Simulated time, s.
    pub simulated: f64,
    /// Time it took, without loading and initialization.
    pub elapsed: Duration,
    /// What is to be said of the result: divergence, energy that the coupling made, warnings of the
    /// FMUs.
    pub verdict: Verdict,
}

/// As [`observed`], with a function as the observer.
///
/// # Errors
/// As [`observed`].
pub fn run(
    system: &System,
    master: Master,
    stop: f64,
    progress: &dyn Fn(u64, u64),
    observe: impl FnMut(&Master) -> Result<()>,
) -> Result<Outcome> {
    observed(system, master, stop, progress, &mut Function(observe))
}

/// Step `master`, which runs `system`, to `stop`, s; the last step is shortened where it has to be.
/// The `observer` sees every communication point, the first included, and may end the run;
/// `progress` is given the numbers of finished and of all steps from time to time.
///
/// # Errors
/// Besides what went wrong: where the loops of the system began to diverge before.
pub fn observed(
    system: &System,
    master: Master,
    stop: f64,
    progress: &dyn Fn(u64, u64),
    observer: &mut dyn Observer,
) -> Result<Outcome> {
    shared_out(system, master, None, stop, progress, observer)
}

/// As [`observed`], with `master` made in one thread by the experiment `alone`, where there is one:
/// if the first steps take long, they are made once more by as many threads as there are cores,
/// which then go on. What is observed is the same.
///
/// # Errors
/// As [`observed`].
pub fn shared_out(
    system: &System,
    mut master: Master,
    alone: Option<&Experiment>,
    stop: f64,
    progress: &dyn Fn(u64, u64),
    observer: &mut dyn Observer,
) -> Result<Outcome> {
    let start = master.time();
    let mut steps = FixedSteps::new(master.stepping(), stop)?;
    let mut verdict = Verdict::default();
    if let Some(fixed) = system.fixed_step()
        && steps.leave_rest()
    {
        verdict.note(format!(
            "the last step is not shortened to end at {stop} s, because `{fixed}` cannot vary its step"
        ));
    }
    let all = steps.count();
    let mut supervision = Supervision::new(system, &master, verdict);
    let clock = Instant::now();
    observer.observe(&master)?;
    let mut stepped = Duration::ZERO;
    for k in 1..=all {
        if observer.is_done() {
            break;
        }
        let before = (k <= TRIAL).then(Instant::now);
        let made = steps.make(k, &mut master);
        stepped += before.map_or(Duration::ZERO, |before| before.elapsed());
        if let (TRIAL, Ok(_), Some(alone)) = (k, &made, alone)
            && let Some(threads) = worth(system, stepped, all - k)
        {
            drop(master);
            let wide = Experiment {
                threads,
                ..alone.clone()
            };
            let (done, note) = match repeated(system, &wide, &steps) {
                Ok(done) => (
                    done,
                    format!("the steps take long: {threads} threads make them (--threads 1: one)"),
                ),
                Err(error) => (
                    repeated(system, alone, &steps)?,
                    format!("one thread makes all steps, long as they are: {error:#}"),
                ),
            };
            master = done;
            supervision.note(note);
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
        if k % 256 == 0 {
            progress(k, all);
        }
    }
    progress(all, all);
    let elapsed = clock.elapsed();
    let (residuals, simulated) = (master.residuals().to_vec(), master.time() - start);
    Ok(Outcome {
        residuals,
        simulated,
        elapsed,
        verdict: supervision.end(system, master)?,
    })
}

/// Steps after which it is decided how many threads go on.
const TRIAL: u64 = 8;
/// A step that takes less is not shared out, s.
const LONG_STEP: f64 = 100e-6;
/// Nor is a run that will end sooner, s.
const LONG_RUN: f64 = 0.5;

/// Number of threads that are worth while.
fn worth(system: &System, trial: Duration, left: u64) -> Option<usize> {
    let step = trial.as_secs_f64() / TRIAL as f64;
    let threads = cores().min(system.fmus.len());
    (threads > 1 && step > LONG_STEP && step * left as f64 > LONG_RUN).then_some(threads)
}

/// The system after the first steps.
fn repeated(system: &System, experiment: &Experiment, steps: &FixedSteps) -> Result<Master> {
    let mut master = experiment.start(system)?;
    for k in 1..=TRIAL {
        steps.make(k, &mut master)?;
    }
    Ok(master)
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
            let share = if r.turnover > 0.0 {
                100.0 * r.energy.abs() / r.turnover
            } else {
                0.0
            };
            line(format!(
                "power residual of bond {}: peak {:.3} W, net {:.3e} J ({share:.1e} % of {:.3e} J turned over)",
                r.bond, r.peak, r.energy, r.turnover
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
