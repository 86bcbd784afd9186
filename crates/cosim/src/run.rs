//! A run: a system stepped from its start to a stop time, observed at every communication point.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::bond::Residual;
use crate::divergence::Watch;
use crate::master::{Master, Stepping};
use crate::noise::Noise;
use crate::slave::messages;
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
    /// Noise on inputs.
    pub noise: Noise,
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
    /// What is to be said of the result: divergence, energy that the coupling made, warnings of the FMUs.
    pub verdict: Verdict,
}

impl Experiment {
    /// The initialized system at its start time.
    pub fn start(&self, system: &System) -> Result<Master> {
        messages::take();
        let mut master = Master::new(system, &self.settings, self.stepping)?;
        if !self.noise.sensors.is_empty() {
            master.disturb(system, &self.noise)?;
        }
        Ok(master)
    }

    /// The stop time asked for, else that of the system's default experiment, s.
    pub fn stop(&self, system: &System) -> Result<f64> {
        let stop = self.stop.or(system.structure.stop_time);
        stop.context("neither a stop time is given nor has the system structure one")
    }
}

/// Step `master`, which runs `system`, to `stop`, s; the last step is shortened where it has to be. `observe` sees every communication
/// point, the first included; `progress` is given the numbers of finished and of all steps from time to time.
///
/// # Errors
/// Besides what went wrong: where the loops of the system began to diverge before.
pub fn run(
    system: &System,
    mut master: Master,
    stop: f64,
    progress: &dyn Fn(u64, u64),
    mut observe: impl FnMut(&Master) -> Result<()>,
) -> Result<Outcome> {
    let start = master.time();
    let (steps, has_rest) = steps(master.stepping(), stop)?;
    let all = steps + u64::from(has_rest);
    let mut watch = Watch::new(start, &master.exchange().values);
    let clock = Instant::now();
    observe(&master)?;
    for k in 1..=all {
        let stepped = if k > steps {
            master.step_to(stop)
        } else {
            master.step()
        };
        let observed = stepped.and_then(|()| observe(&master));
        if let Err(error) = observed {
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
    let mut verdict = Verdict::default();
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

/// Energy that the coupling made or lost at a bond, beside what went through all: a bond through which next to nothing goes says nothing.
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

/// Number of whole communication steps to `stop`, s, and whether a part of one remains.
///
/// # Errors
/// A stop time before the start, or not finite.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be in range"
)]
fn steps(Stepping { start, step, .. }: Stepping, stop: f64) -> Result<(u64, bool)> {
    let steps = (stop - start) / step;
    if !(steps > 0.0 && steps < 1e12) {
        bail!("from {start} s to {stop} s in steps of {step} s: no run");
    }
    // A stop time that is a multiple of h up to rounding is met exactly; the comparison is relative to h.
    let whole = (steps + 1e-6).floor();
    Ok((whole as u64, steps - whole > 1e-6))
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

    #[test]
    fn a_stop_time_that_is_a_multiple_of_the_step_is_met() {
        let count = |stop, step| {
            let stepping = Stepping {
                start: 0.5,
                step,
                schedule: Default::default(),
            };
            steps(stepping, stop)
        };
        assert_eq!(count(0.8, 0.1).unwrap(), (3, false)); // 0.8 - 0.5 = 0.30000000000000004
        assert_eq!(count(0.85, 0.1).unwrap(), (3, true));
        assert_eq!(count(0.55, 0.1).unwrap(), (0, true));
        assert!(
            count(0.5, 0.1).is_err() && count(f64::NAN, 0.1).is_err() && count(1.0, 0.0).is_err()
        );
    }
}
