//! A run: a system stepped from its start to a stop time, observed at every communication point.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::bond::Residual;
use crate::master::{Master, Stepping};
use crate::messages;
use crate::noise::Noise;
use crate::system::{Setting, System};

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
    /// What the FMUs said without failing.
    pub warnings: Vec<messages::Message>,
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

/// Step `master` to `stop`, s; the last step ends at or just behind it. `observe` sees every communication point, the first included;
/// `progress` is told the numbers of finished and of all steps from time to time.
pub fn run(
    mut master: Master,
    stop: f64,
    progress: &dyn Fn(u64, u64),
    mut observe: impl FnMut(&Master) -> Result<()>,
) -> Result<Outcome> {
    let start = master.time();
    let steps = steps(master.stepping(), stop)?;
    let clock = Instant::now();
    observe(&master)?;
    for k in 1..=steps {
        master.step()?;
        observe(&master)?;
        if k % 256 == 0 {
            progress(k, steps);
        }
    }
    progress(steps, steps);
    let elapsed = clock.elapsed();
    let (residuals, simulated) = (master.residuals().to_vec(), master.time() - start);
    master.terminate()?;
    Ok(Outcome {
        residuals,
        simulated,
        elapsed,
        warnings: messages::take(),
    })
}

/// Number of communication steps to `stop`, s.
///
/// # Errors
/// A stop time before the start, or not finite.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be in range"
)]
fn steps(Stepping { start, step, .. }: Stepping, stop: f64) -> Result<u64> {
    let steps = (stop - start) / step;
    if !(steps > 0.0 && steps < 1e12) {
        bail!("from {start} s to {stop} s in steps of {step} s: no run");
    }
    // A stop time that is a multiple of h up to rounding is met exactly; the comparison is relative to h.
    Ok((steps - 1e-6).ceil() as u64)
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
        for w in &self.warnings {
            line(format!("{}: {}", w.instance, w.text));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(count(0.8, 0.1).unwrap(), 3); // 0.8 - 0.5 = 0.30000000000000004
        assert_eq!(count(0.85, 0.1).unwrap(), 4);
        assert!(
            count(0.5, 0.1).is_err() && count(f64::NAN, 0.1).is_err() && count(1.0, 0.0).is_err()
        );
    }
}
