//! Communication steps of one length; the last one is shortened where it has to be and every
//! component can.

use anyhow::{Result, bail};

use crate::master::Master;
use crate::schedule::Stepping;

/// The communication steps of a run to a stop time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedSteps {
    /// Whole communication steps.
    whole: u64,
    /// Part of one is left.
    has_rest: bool,
    /// s.
    stop: f64,
}

impl FixedSteps {
    /// The steps to `stop`, s.
    ///
    /// # Errors
    /// A stop time before the start, or not finite.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked to be in range"
    )]
    pub fn new(Stepping { start, step, .. }: Stepping, stop: f64) -> Result<Self> {
        let steps = (stop - start) / step;
        if !(steps > 0.0 && steps < 1e12) {
            bail!("from {start} s to {stop} s in steps of {step} s: no run");
        }
        // A stop time that is a multiple of h up to rounding is met exactly; the comparison is
        // relative to h.
        let whole = (steps + 1e-6).floor();
        Ok(Self {
            whole: whole as u64,
            has_rest: steps - whole > 1e-6,
            stop,
        })
    }

    /// Number of steps.
    pub fn count(&self) -> u64 {
        self.whole + u64::from(self.has_rest)
    }

    /// The same without a shortened last step; true where there was one.
    pub fn leave_rest(&mut self) -> bool {
        std::mem::take(&mut self.has_rest)
    }

    /// Make step number `k`, counted from 1.
    pub fn make(&self, k: u64, master: &mut Master) -> Result<()> {
        match k > self.whole {
            true => master.step_to(self.stop),
            false => master.step(),
        }
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
            FixedSteps::new(stepping, stop).map(|s| (s.whole, s.has_rest))
        };
        assert_eq!(count(0.8, 0.1).unwrap(), (3, false)); // 0.8 - 0.5 = 0.30000000000000004
        assert_eq!(count(0.85, 0.1).unwrap(), (3, true));
        assert_eq!(count(0.55, 0.1).unwrap(), (0, true));
        assert!(
            count(0.5, 0.1).is_err() && count(f64::NAN, 0.1).is_err() && count(1.0, 0.0).is_err()
        );
    }
}
