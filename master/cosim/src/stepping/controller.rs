//! The four choices of the lengths of communication steps (fixed, repeated, energy, doubling), and
//! the PI controller by which `variable` holds the error of each step near a tolerance.

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};

/// How the lengths of communication steps are chosen.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub enum StepControl {
    /// All have one length.
    #[default]
    Fixed,
    /// All have one length, but if a component stops within a step, the step is repeated by all
    /// components to where it stopped.
    Repeated,
    /// By the energy that the coupling creates or loses at the power bonds over a step (Sadjina,
    /// Kyllingstad, Skjong, Pedersen 2017, arXiv 1602.06434).
    ///
    /// The error of a step is the root mean square over all bonds of `|δE| / (tolerance (scale +
    /// |E|))`: `δE` is the energy residual of the bond over the step, `E` the energy that went
    /// through it.
    Energy {
        /// Energy residual of a step relative to the energy transferred.
        tolerance: f64,
        /// Energy added to that transferred, J: it makes the tolerance absolute for small energies.
        scale: f64,
        /// A step whose error is more than twice the allowed one is repeated, shorter.
        repeats: bool,
        /// How the length follows the error.
        limits: StepLimits,
    },
    /// By step doubling: comparison of one step with two steps of half the length. The error is the
    /// largest difference of a connected, continuous output, relative to `tolerance (nominal value +
    /// |output|)`. Steps whose error is too large are repeated, shorter.
    Doubling {
        /// Difference relative to the sum of nominal and present value.
        tolerance: f64,
        /// How the length follows the error; the gains are ignored, since a step is of first order.
        limits: StepLimits,
    },
}

/// Parameters of the controller. The next length follows from the error relative to the allowed
/// one: `h ← h · safety · error^−(i + p) · (error before)^p`, within these limits. The defaults are
/// those of libcosim's example.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct StepLimits {
    /// Shortest and longest step, s.
    pub length: [f64; 2],
    /// Smallest and largest factor between two steps.
    pub change: [f64; 2],
    /// Safety factor.
    pub safety: f64,
    /// Proportional gain p.
    pub proportional: f64,
    /// Integral gain i.
    pub integral: f64,
}

impl Default for StepLimits {
    fn default() -> Self {
        Self {
            length: [1e-5, 1e-2],
            change: [0.2, 1.5],
            safety: 0.99,
            proportional: 0.2,
            integral: 0.15,
        }
    }
}

impl StepLimits {
    fn check(&self) -> Result<()> {
        let [shortest, longest] = self.length;
        ensure!(
            shortest > 0.0 && shortest <= longest && longest.is_finite(),
            "steps of {shortest} s to {longest} s: the shortest must be greater than 0 s and at most the longest"
        );
        let [least, most] = self.change;
        ensure!(
            least > 0.0 && least < 1.0 && most > 1.0 && most.is_finite(),
            "changes of the step by {least} to {most}: they must lie below and above 1"
        );
        let (safety, p, i) = (self.safety, self.proportional, self.integral);
        ensure!(
            safety > 0.0 && safety <= 1.0,
            "safety {safety} of the step must be greater than 0 and at most 1"
        );
        ensure!(
            i > 0.0 && p >= 0.0 && (i + p).is_finite(),
            "gains {p} (proportional) and {i} (integral) of the step: the first must not be negative, the second greater than 0"
        );
        Ok(())
    }
}

/// Progress of the steps of a run, as a snapshot saves it.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct Progress {
    /// Number of steps, also of those whose communication points jitter leaves out.
    pub made: u64,
    pub controller: ControllerState,
}

/// State of the controller; zero for steps of one length.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct ControllerState {
    /// Length of the next step, s.
    pub next: f64,
    /// Error of the step before, relative to the allowed one; 0: there was none.
    pub error: f64,
    /// Length of the step before, s.
    pub length: f64,
}

/// Chooses the lengths of steps.
#[derive(Clone, Debug)]
pub(super) struct StepController {
    limits: StepLimits,
    pub state: ControllerState,
    remembers: bool,
}

/// Time constant with which an error is forgotten, in longest steps.
const MEMORY: f64 = 5.0;

impl StepController {
    /// Begins with steps of `length`, s, within the limits.
    ///
    /// With `remembers` it follows the largest of the recent errors, each scaled with the square of
    /// the step length, to which an energy residual is proportional. When a bond's power passes
    /// zero, its error is small for a moment although the coupling is as bad as before. Following
    /// that dip would lengthen the step and then shorten or repeat it, so the largest error counts.
    pub fn new(limits: StepLimits, length: f64, remembers: bool) -> Result<Self> {
        limits.check()?;
        let next = length.clamp(limits.length[0], limits.length[1]);
        let state = ControllerState {
            next,
            error: 0.0,
            length: next,
        };
        Ok(Self {
            limits,
            state,
            remembers,
        })
    }

    /// End of the next step from `t`, s. The last two steps before `stop` have equal lengths, so
    /// that none is tiny.
    pub fn end(&self, t: f64, stop: f64) -> f64 {
        let next = self.state.next;
        let steps = (stop - t) / next;
        match steps {
            _ if steps <= 1.0 + 1e-6 => stop,
            _ if steps < 2.0 => t + 0.5 * (stop - t),
            _ => t + next,
        }
    }

    /// Chooses the next length after a step of `length`, s, with this error relative to the allowed
    /// one.
    pub fn follow(&mut self, length: f64, mut error: f64) -> Result<()> {
        let StepLimits { safety, .. } = self.limits;
        let ([shortest, longest], [least, most]) = (self.limits.length, self.limits.change);
        let (proportional, integral) = (self.limits.proportional, self.limits.integral);
        ensure!(
            !error.is_nan(),
            "the error of the communication step is NaN"
        );
        let last = self.state;
        if self.remembers {
            let faded = (-length / (MEMORY * longest)).exp();
            let remembered = last.error * (length / last.length).powi(2);
            error = error.max(faded * remembered);
        }
        let before = match last.error > 0.0 {
            true => last.error,
            false => error,
        };
        let factor = match error > 0.0 {
            true => safety * error.powf(-integral - proportional) * before.powf(proportional),
            false => most,
        };
        let next = (length * factor.clamp(least, most)).clamp(shortest, longest);
        self.state = ControllerState {
            next,
            error,
            length,
        };
        Ok(())
    }

    /// Whether a step of `length`, s, is the shortest that is allowed.
    pub fn is_shortest(&self, length: f64) -> bool {
        length <= self.limits.length[0] * (1.0 + 1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The law by hand, within its limits; where nothing is wrong the step grows as fast as it may.
    #[test]
    fn the_length_follows_the_error_within_the_limits() {
        let mut r = StepController::new(StepLimits::default(), 1e-3, false).unwrap();
        r.follow(1e-3, 2.0).unwrap();
        let first = 0.99 * 2.0_f64.powf(-0.15) * 1e-3;
        assert!((r.state.next - first).abs() < 1e-18, "{}", r.state.next);
        r.follow(1e-3, 0.5).unwrap();
        let second = 0.99 * 0.5_f64.powf(-0.35) * 2.0_f64.powf(0.2) * 1e-3;
        assert!((r.state.next - second).abs() < 1e-18, "{}", r.state.next);
        for (error, length, next) in [
            (0.0, 1e-3, 1.5e-3),
            (1e12, 1e-3, 0.2e-3),
            (0.0, 9e-3, 1e-2),
            (1e12, 2e-5, 1e-5),
        ] {
            r.follow(length, error).unwrap();
            assert_eq!(r.state.next, next, "{error}");
        }
        assert!(r.follow(1e-3, f64::NAN).is_err());
    }

    /// A single error of 4 at 1 ms, then none: after a step of 2 ms it counts as 16, faded over two
    /// of the fifty milliseconds.
    #[test]
    fn an_error_is_remembered_with_the_square_of_the_length() {
        let mut r = StepController::new(StepLimits::default(), 1e-3, true).unwrap();
        r.follow(1e-3, 4.0).unwrap();
        r.follow(2e-3, 0.0).unwrap();
        let expected = 16.0 * (-2e-3_f64 / 50e-3).exp();
        assert!(
            (r.state.error / expected - 1.0).abs() < 1e-14,
            "{}",
            r.state.error
        );
        let length = 2e-3 * 0.99 * expected.powf(-0.35) * 4.0_f64.powf(0.2);
        assert!(
            (r.state.next / length - 1.0).abs() < 1e-14,
            "{}",
            r.state.next
        );
    }

    #[test]
    fn the_last_steps_meet_the_stop_time_and_none_is_tiny() {
        let r = StepController::new(StepLimits::default(), 1e-3, false).unwrap();
        assert_eq!(r.end(0.5, 2.0), 0.501);
        assert_eq!(r.end(0.5, 0.5011), 0.5 + 0.5 * (0.5011 - 0.5));
        assert_eq!(r.end(0.5, 0.5008), 0.5008);
    }

    #[test]
    fn limits_that_make_no_sense_are_refused() {
        let d = StepLimits::default();
        for (limits, word) in [
            (
                StepLimits {
                    length: [1e-2, 1e-3],
                    ..d
                },
                "shortest",
            ),
            (
                StepLimits {
                    length: [0.0, 1e-3],
                    ..d
                },
                "shortest",
            ),
            (
                StepLimits {
                    change: [1.1, 1.5],
                    ..d
                },
                "change",
            ),
            (StepLimits { safety: 1.5, ..d }, "safety"),
            (StepLimits { integral: 0.0, ..d }, "gains"),
        ] {
            let error = StepController::new(limits, 1e-3, false)
                .unwrap_err()
                .to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
