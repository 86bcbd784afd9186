//! One experiment: a system run from start to stop, with its tip error, bond residuals, time and messages.

use std::fmt::Write as _;
use std::io::Write;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::bond::Residual;
use crate::description::Kind;
use crate::master::{Grid, Master, Setting};
use crate::messages;
use crate::noise::Noise;
use crate::signals::{CsvLog, Signals};
use crate::slave::At;
use crate::system::System;
use crate::tip::TipError;

/// The controller's output of which the tip error is made.
const TIP_ERROR: &str = "tip_error_norm";
/// The controller's parameter that says when the reference begins to move.
const MOTION_START: &str = "settle_time";
/// The controller's output that says when the reference has come to its end.
const MOTION_END: &str = "motion_end";

/// An experiment.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Start, step and schedule.
    pub grid: Grid,
    /// Stop time, s, where it is not the end of the motion; the last step ends at or just behind it.
    pub stop: Option<f64>,
    /// Start values.
    pub settings: Vec<Setting>,
    /// Noise on inputs.
    pub noise: Noise,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Tip error, where the system has a component that gives it.
    pub tip: Option<TipError>,
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
    /// Number of communication steps to `stop`, s.
    ///
    /// # Errors
    /// A stop time before the start, or not finite.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked to be in range"
    )]
    fn steps(&self, stop: f64) -> Result<u64> {
        let steps = (stop - self.grid.start) / self.grid.step;
        if !(steps > 0.0 && steps < 1e12) {
            bail!(
                "from {} s to {stop} s in steps of {} s: no run",
                self.grid.start,
                self.grid.step
            );
        }
        // A stop time that is a multiple of h up to rounding is met exactly; the comparison is relative to h.
        Ok((steps - 1e-6).ceil() as u64)
    }

    /// The stop time asked for, else the end of the motion as the controller tells it, else that of the default experiment.
    fn stop(&self, system: &System, master: &Master) -> Result<f64> {
        if let Some(stop) = self.stop {
            return Ok(stop);
        }
        if let Ok((k, variable)) = system.owner(MOTION_END) {
            let end = master.slaves()[k].number(variable, At::Time(master.time()))?;
            if end > self.grid.start {
                return Ok(end);
            }
        }
        system
            .structure
            .stop_time
            .context("neither a stop time is given nor has the system structure one")
    }

    /// Run. `progress` is told the numbers of finished and of all steps from time to time; rows go to `csv` where signals are given.
    pub fn run<W: Write>(
        &self,
        system: &System,
        progress: impl Fn(u64, u64),
        csv: Option<(&mut Signals, W)>,
    ) -> Result<Outcome> {
        let Some((signals, out)) = csv else {
            return self.watch(system, progress, None, |_, _| Ok(()));
        };
        let mut log = CsvLog::new(out, &signals.titles)?;
        let outcome = self.watch(system, progress, Some(signals), |t, row| log.row(t, row))?;
        log.finish()?;
        Ok(outcome)
    }

    /// Run; at every communication point `each` is given the time and the values of `signals`.
    pub fn watch(
        &self,
        system: &System,
        progress: impl Fn(u64, u64),
        mut signals: Option<&mut Signals>,
        mut each: impl FnMut(f64, &[f64]) -> Result<()>,
    ) -> Result<Outcome> {
        messages::take();
        let mut master = Master::new(system, &self.settings, self.grid)?;
        if !self.noise.sensors.is_empty() {
            master.disturb(system, &self.noise)?;
        }
        let steps = self.steps(self.stop(system, &master)?)?;
        let (mut tip_signal, mut tip) = tip_error(system, &master)?.unzip();
        let clock = Instant::now();
        for k in 0..=steps {
            if k > 0 {
                master.step()?;
            }
            if let (Some(signal), Some(tip)) = (&mut tip_signal, &mut tip) {
                signal.read(&master)?;
                tip.add(master.time(), signal.values[0]);
            }
            if let Some(signals) = &mut signals {
                signals.read(&master)?;
                each(master.time(), &signals.values)?;
            }
            if k % 256 == 0 {
                progress(k, steps);
            }
        }
        progress(steps, steps);
        let elapsed = clock.elapsed();
        let (residuals, simulated) = (master.residuals().to_vec(), master.time() - self.grid.start);
        master.terminate()?;
        Ok(Outcome {
            tip,
            residuals,
            simulated,
            elapsed,
            warnings: messages::take(),
        })
    }
}

/// The tip error's signal and the empty statistics, where the system has one.
fn tip_error(system: &System, master: &Master) -> Result<Option<(Signals, TipError)>> {
    let Ok((k, _)) = system.owner(TIP_ERROR) else {
        return Ok(None);
    };
    let component = &system.structure.components[k].name;
    let signal = Signals::choose(system, &[format!("{component}.{TIP_ERROR}")])?;
    let start = match system.fmus[k].description.variable(MOTION_START) {
        Ok(parameter) if parameter.kind == Kind::Real => {
            master.slaves()[k].number(parameter, At::Time(master.time()))?
        }
        _ => 0.0,
    };
    Ok(Some((signal, TipError::new(start))))
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
        if let Some(tip) = &self.tip {
            let mm = |d: &crate::tip::Distance| {
                format!("RMSE {:.4} mm, max {:.4} mm", 1e3 * d.rms(), 1e3 * d.max)
            };
            line(format!(
                "tip error, motion from {} s on: {}",
                tip.motion_start,
                mm(&tip.motion)
            ));
            line(format!(
                "tip error, whole run:           {}",
                mm(&tip.whole)
            ));
        }
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

/// Parse `component.variable=value`.
pub fn parse_setting(text: &str) -> Result<Setting> {
    let (left, value) = text
        .split_once('=')
        .with_context(|| format!("`{text}` is not component.variable=value"))?;
    let (component, variable) = left
        .split_once('.')
        .with_context(|| format!("`{left}` is not component.variable"))?;
    Ok(Setting {
        component: component.trim().into(),
        variable: variable.trim().into(),
        value: value.trim().into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::master::Schedule;

    #[test]
    fn a_stop_time_that_is_a_multiple_of_the_step_is_met() {
        let steps = |stop, step| {
            let grid = Grid {
                start: 0.5,
                step,
                schedule: Schedule::Jacobi,
            };
            Experiment {
                grid,
                stop: None,
                settings: Vec::new(),
                noise: Noise::default(),
            }
            .steps(stop)
        };
        assert_eq!(steps(0.8, 0.1).unwrap(), 3); // 0.8 - 0.5 = 0.30000000000000004
        assert_eq!(steps(0.85, 0.1).unwrap(), 4);
        assert!(
            steps(0.5, 0.1).is_err() && steps(f64::NAN, 0.1).is_err() && steps(1.0, 0.0).is_err()
        );
    }

    #[test]
    fn settings_split_at_the_first_signs() {
        let s = parse_setting("hdrm.payload.mass = 12=").unwrap();
        assert_eq!(
            (s.component.as_str(), s.variable.as_str(), s.value.as_str()),
            ("hdrm", "payload.mass", "12=")
        );
        assert!(parse_setting("hdrm.mass").is_err() && parse_setting("mass=2").is_err());
    }
}
