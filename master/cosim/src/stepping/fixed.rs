//! Communication steps of one length for `Steps`, with jitter if it is wanted. The last step is
//! shortened to end at the stop time, if every component can vary its step.

use anyhow::{Result, bail, ensure};

use crate::master::Master;
use crate::schedule::Stepping;
use fmi_import::digits::short;

/// The communication steps of a run to a stop time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedSteps {
    /// Number of whole steps.
    whole: u64,
    /// A last, shorter step follows.
    has_rest: bool,
    /// Number of steps that are made, including those whose communication points are lost.
    pub(super) made: u64,
    /// Stop time, s.
    stop: f64,
    stepping: Stepping,
}

impl FixedSteps {
    /// The steps to `stop`, s, which must be after the start.
    pub fn new(stepping: Stepping, stop: f64) -> Result<Self> {
        let Stepping { start, step, .. } = stepping;
        let steps = (stop - start) / step;
        if !(steps > 0.0 && steps < 1e12) {
            bail!(
                "the run from {} s to {} s must go forward, in less than 1e12 steps of {} s",
                short(start),
                short(stop),
                short(step)
            );
        }
        // A stop time that is a multiple of h up to rounding is met exactly; the comparison is
        // relative to h.
        let whole = (steps + 1e-6).floor();
        Ok(Self {
            whole: whole as u64,
            has_rest: steps - whole > 1e-6,
            made: 0,
            stop,
            stepping,
        })
    }

    /// Number of all steps.
    pub fn all(&self) -> u64 {
        self.whole + u64::from(self.has_rest)
    }

    /// Omits the shortened last step; true if there was one.
    pub fn omit_rest(&mut self) -> bool {
        std::mem::take(&mut self.has_rest)
    }

    /// Continues after `made` steps, at `time`, s.
    pub(super) fn resume(&mut self, time: f64, made: u64) -> Result<()> {
        let Stepping { start, step, .. } = self.stepping;
        let grid = start + made as f64 * step;
        ensure!(
            (time - grid).abs() <= 1e-6 * step || self.stepping.jitter.is_some(),
            "after {made} steps of {step} s the time must be {} s, not {} s: the last one was shortened",
            short(grid),
            short(time)
        );
        self.made = made;
        Ok(())
    }

    /// Makes the next step; false if its communication point is lost.
    pub fn make(&mut self, master: &mut Master) -> Result<bool> {
        let k = self.made + 1;
        let Stepping { start, step, .. } = self.stepping;
        self.made = k;
        let is_last = k >= self.all();
        let grid = start + k as f64 * step;
        match (k > self.whole, self.stepping.jitter) {
            (true, _) => master.step_to(self.stop)?,
            (false, None) => master.step()?,
            (false, Some(_)) if is_last => master.step_to(grid)?,
            (false, Some(jitter)) => {
                let Some(late) = jitter.lateness(k) else {
                    return Ok(false);
                };
                // A late one still leaves a rest.
                let point = start + (k as f64 + late) * step;
                master.step_to(if point < self.stop { point } else { grid })?;
            }
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::Jitter;

    #[test]
    fn a_stop_time_that_is_a_multiple_of_the_step_is_met() {
        let count = |stop, step| {
            let stepping = Stepping::new(0.5, step, Default::default());
            FixedSteps::new(stepping, stop).map(|s| (s.whole, s.has_rest))
        };
        assert_eq!(count(0.8, 0.1).unwrap(), (3, false)); // 0.8 - 0.5 = 0.30000000000000004
        assert_eq!(count(0.85, 0.1).unwrap(), (3, true));
        assert_eq!(count(0.55, 0.1).unwrap(), (0, true));
        assert!(
            count(0.5, 0.1).is_err() && count(f64::NAN, 0.1).is_err() && count(1.0, 0.0).is_err()
        );
    }

    /// Steps differ by at most the part asked for, to both sides, points stay on their grid to half
    /// of it, and about the share asked for is lost: of 10⁵ points 100 ± 4·√100. Another seed is
    /// another sequence.
    #[test]
    fn jitter_is_within_its_bounds_and_follows_its_seed() {
        let of = |seed| Jitter {
            seed,
            part: 0.1,
            lost: 1e-3,
        };
        let points: Vec<_> = (0..100_000).map(|k| of(7).lateness(k)).collect();
        let lost = points.iter().filter(|late| late.is_none()).count();
        assert!((60..=140).contains(&lost), "{lost}");
        let most = points
            .iter()
            .flatten()
            .fold(0.0, |m: f64, late| m.max(late.abs()));
        assert!(most <= 0.05 && most > 0.0499, "{most}");
        let mean = points.iter().flatten().sum::<f64>() / 1e5;
        // Four standard deviations of the mean of uniform numbers of width 0.1.
        assert!(
            mean.abs() < 4.0 * 0.1 / 12.0_f64.sqrt() / 1e5_f64.sqrt(),
            "{mean}"
        );
        assert!((0..100).any(|k| of(8).lateness(k) != of(7).lateness(k)));
    }
}
