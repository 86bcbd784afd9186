//! A run: a system stepped from its start to a stop time, observed at every communication point,
//! and what came out of it.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::bond::Residual;
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
    mut master: Master,
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
    for k in 1..=all {
        if observer.is_done() {
            break;
        }
        let observed = match steps.make(k, &mut master) {
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
