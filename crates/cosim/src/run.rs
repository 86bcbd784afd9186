//! A run: a system stepped from its start to a stop time, observed at every communication point,
//! and what came out of it.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::bond::Residual;
use crate::divergence::Watch;
use crate::faults::Faults;
use crate::input_table::{InputTable, Table};
use crate::master::{Master, Stepping};
use crate::observer::{Function, Observer};
use crate::slave::{Ended, messages};
use crate::stepping::FixedSteps;
use crate::system::{Setting, System};
use crate::verdict::Verdict;

/// Share of the energy through all bonds that the coupling may make or lose.
const SPURIOUS: f64 = 0.01;
/// Energy that may be rounding, J.
const ROUNDING: f64 = 1e-9;

/// Conditions of a run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Start, communication step and schedule.
    pub stepping: Stepping,
    /// Stop time, s, where it is not that of the system's default experiment.
    pub stop: Option<f64>,
    /// Start values, applied in this order after those of the system.
    pub settings: Vec<Setting>,
    /// What is done to values on their way: noise and other faults, events of a scenario.
    pub faults: Faults,
    /// Values over time for inputs that no connection drives.
    pub inputs: Option<Arc<Table>>,
}

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

impl Experiment {
    /// The initialized system at its start time.
    pub fn start(&self, system: &System) -> Result<Master> {
        messages::take();
        let mut master = Master::new(system, &self.settings, self.stepping)?;
        if let Some(table) = &self.inputs {
            master.feed(InputTable::new(system, table)?)?;
        }
        if !self.faults.list.is_empty() {
            master.alter(system, &self.faults)?;
        }
        Ok(master)
    }

    /// The stop time asked for, else that of the system's default experiment, s.
    pub fn stop(&self, system: &System) -> Result<f64> {
        let stop = self.stop.or(system.structure.stop_time);
        stop.context("neither a stop time is given nor has the system structure one")
    }
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
    let step = master.stepping().step;
    if let Some((component, internal)) = system.uneven_step(step) {
        verdict.note(format!(
            "the communication step of {step} s is no multiple of the fixed internal step of `{component}`, {internal} s"
        ));
    }
    let all = steps.count();
    let mut watch = Watch::new(start, &master.exchange().values);
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
                verdict.note(format!("{error:#}"));
                break;
            }
            return Err(match divergence(system, &master, &watch) {
                Some(cause) => error.context(cause),
                None => error,
            });
        }
        watch.add(master.time(), &master.exchange().values);
        if k % 256 == 0 {
            progress(k, all);
        }
    }
    progress(all, all);
    let elapsed = clock.elapsed();
    let (residuals, simulated) = (master.residuals().to_vec(), master.time() - start);
    if let Some(text) = divergence(system, &master, &watch) {
        verdict.object(text);
    }
    judge(&residuals, &mut verdict);
    master.terminate()?;
    for message in messages::take() {
        verdict.note(message.to_string());
    }
    Ok(Outcome {
        residuals,
        simulated,
        elapsed,
        verdict,
    })
}

/// Where a loop began to diverge, and why.
fn divergence(system: &System, master: &Master, watch: &Watch) -> Option<String> {
    let (slot, since) = watch.diverged?;
    let name = system.name(master.exchange().output(slot)?);
    let step = master.stepping().step;
    Some(format!(
        "`{name}` diverges from t = {since} s on: it jumps up and down from one communication point to the next, further each time; the \
         communication step of {step} s is too long for the loops of this system"
    ))
}

/// Energy that the coupling made or lost at a bond, beside what went through all: a bond through
/// which next to nothing goes says nothing.
fn judge(residuals: &[Residual], verdict: &mut Verdict) {
    let all: f64 = residuals.iter().map(|r| r.turnover).sum();
    for Residual { bond, energy, .. } in residuals {
        let share = energy.abs() / all;
        if share > SPURIOUS && energy.abs() > ROUNDING {
            let done = if *energy < 0.0 { "created" } else { "lost" };
            verdict.object(format!(
                "the coupling {done} {:.3e} J at the bond {bond}, {:.1} % of what went through all bonds: a loop is unstable, or the \
                 communication step too long",
                energy.abs(),
                100.0 * share
            ));
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bond_is_judged_beside_what_goes_through_all() {
        let residual = |energy, turnover| Residual {
            energy,
            turnover,
            ..Residual::new("a.F".into())
        };
        let is_bad = |residuals: &[Residual]| {
            let mut verdict = Verdict::default();
            judge(residuals, &mut verdict);
            verdict.is_bad()
        };
        assert!(is_bad(&[residual(-0.02, 1.0)]) && is_bad(&[residual(0.02, 1.0)]));
        assert!(!is_bad(&[residual(-0.02, 1.0), residual(0.0, 2.0)]));
        assert!(!is_bad(&[residual(-1e-12, 1e-12)]), "rounding");
    }
}
