//! By what the length of a communication step is chosen, and the controller that chooses it.

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};

/// How the lengths of communication steps come about.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub enum Control {
    /// All have one length.
    #[default]
    Fixed,
    /// All have one length; one that a component does not make to its end is repeated with all
    /// others to where it stopped.
    Repeated,
    /// By the energy that the coupling makes or loses at the power bonds over a step (Sadjina,
    /// Kyllingstad, Skjong, Pedersen 2017, arXiv 1602.06434).
    ///
    /// The error of a step is the root mean square over all bonds of `|δE| / (tolerance (scale +
    /// |E|))`: `δE` is the energy residual of the bond over the step, `E` the energy that went
    /// through it.
    Energy {
        /// Energy residual of a step beside the energy that passes.
        tolerance: f64,
        /// Energy from which on that counts, J: it makes the tolerance absolute for small ones.
        scale: f64,
        /// A step whose error is more than twice what is allowed is repeated, shorter.
        repeats: bool,
        /// How the length follows the error.
        limits: Limits,
    },
    /// By what two steps of half the length come to beside one step. The error is the largest
    /// difference of a connected, continuous output beside `tolerance (nominal value + |output|)`.
    /// Steps whose error is too large are repeated, shorter.
    Doubling {
        /// Difference beside nominal and present value.
        tolerance: f64,
        /// How the length follows the error, but for the gains: a step is of first order.
        limits: Limits,
    },
}

/// How the length of a step follows the error of the one before, beside what is allowed: `h ← h ·
/// safety · error^−(i + p) · (error before)^p`, within these limits. The defaults are those of the
/// example of libcosim.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Limits {
    /// Shortest and longest step, s.
    pub length: [f64; 2],
    /// Least and largest change from step to step.
    pub change: [f64; 2],
    /// Safety.
    pub safety: f64,
    /// Proportional gain p.
    pub proportional: f64,
    /// Integral gain i.
    pub integral: f64,
}

impl Default for Limits {
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

impl Limits {
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
        let Self {
            safety,
            proportional: p,
            integral: i,
            ..
        } = *self;
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

/// How far the steps of a run have come.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct Progress {
    /// Steps of one length, lost points included.
    pub made: u64,
    /// Length of the next step, s, where it is chosen.
    pub next: f64,
    /// Error that the controller follows, beside what is allowed.
    pub error: f64,
    /// Length of the step before, s.
    pub length: f64,
}

/// Chooses lengths.
#[derive(Clone, Debug)]
pub(super) struct Regulator {
    limits: Limits,
    /// Next length, s.
    pub next: f64,
    /// Error of the step before beside what is allowed; 0: there was none.
    pub before: f64,
    /// Its length, s.
    pub length: f64,
    /// Errors are remembered.
    remembers: bool,
}

/// Time over which an error is remembered, beside the longest step.
const MEMORY: f64 = 5.0;

impl Regulator {
    /// Begins with steps of `length`, s, as far as the limits have it.
    ///
    /// With `remembers` it follows the largest of the errors of late, each beside the square of its
    /// length, to which a residual of energy is proportional: a power that changes its sign shows
    /// no error there, but the coupling is no better, and steps that swing with it cost more than
    /// steady ones.
    pub fn new(limits: Limits, length: f64, remembers: bool) -> Result<Self> {
        limits.check()?;
        let next = length.clamp(limits.length[0], limits.length[1]);
        Ok(Self {
            limits,
            next,
            before: 0.0,
            length: next,
            remembers,
        })
    }

    /// End of the next step from `t`, s; the last two steps before `stop` have one length, so that
    /// none is tiny.
    pub fn end(&self, t: f64, stop: f64) -> f64 {
        let steps = (stop - t) / self.next;
        match steps {
            _ if steps <= 1.0 + 1e-6 => stop,
            _ if steps < 2.0 => t + 0.5 * (stop - t),
            _ => t + self.next,
        }
    }

    /// A step of `length`, s, had this error beside what is allowed.
    ///
    /// # Errors
    /// An error that is no number.
    pub fn follow(&mut self, length: f64, error: f64) -> Result<()> {
        let Limits {
            length: [shortest, longest],
            change: [least, most],
            safety,
            proportional,
            integral,
        } = self.limits;
        ensure!(
            !error.is_nan(),
            "the error of the communication step is no number"
        );
        let mut error = error;
        if self.remembers {
            let faded = (-length / (MEMORY * longest)).exp();
            let remembered = self.before * (length / self.length).powi(2);
            error = error.max(faded * remembered);
        }
        self.length = length;
        let before = match self.before > 0.0 {
            true => self.before,
            false => error,
        };
        let factor = match error > 0.0 {
            true => safety * error.powf(-integral - proportional) * before.powf(proportional),
            false => most,
        };
        self.next = (length * factor.clamp(least, most)).clamp(shortest, longest);
        self.before = error;
        Ok(())
    }

    /// Whether no shorter step than one of `length`, s, may be made.
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
        let mut r = Regulator::new(Limits::default(), 1e-3, false).unwrap();
        r.follow(1e-3, 2.0).unwrap();
        let first = 0.99 * 2.0_f64.powf(-0.15) * 1e-3;
        assert!((r.next - first).abs() < 1e-18, "{}", r.next);
        r.follow(1e-3, 0.5).unwrap();
        let second = 0.99 * 0.5_f64.powf(-0.35) * 2.0_f64.powf(0.2) * 1e-3;
        assert!((r.next - second).abs() < 1e-18, "{}", r.next);
        for (error, length, next) in [
            (0.0, 1e-3, 1.5e-3),
            (1e12, 1e-3, 0.2e-3),
            (0.0, 9e-3, 1e-2),
            (1e12, 2e-5, 1e-5),
        ] {
            r.follow(length, error).unwrap();
            assert_eq!(r.next, next, "{error}");
        }
        assert!(r.follow(1e-3, f64::NAN).is_err());
    }

    /// A single error of 4 at 1 ms, then none: after a step of 2 ms it counts as 16, faded over two
    /// of the fifty milliseconds.
    #[test]
    fn an_error_is_remembered_beside_the_square_of_its_length() {
        let mut r = Regulator::new(Limits::default(), 1e-3, true).unwrap();
        r.follow(1e-3, 4.0).unwrap();
        r.follow(2e-3, 0.0).unwrap();
        let expected = 16.0 * (-2e-3_f64 / 50e-3).exp();
        assert!((r.before / expected - 1.0).abs() < 1e-14, "{}", r.before);
        let length = 2e-3 * 0.99 * expected.powf(-0.35) * 4.0_f64.powf(0.2);
        assert!((r.next / length - 1.0).abs() < 1e-14, "{}", r.next);
    }

    #[test]
    fn the_last_steps_meet_the_stop_time_and_none_is_tiny() {
        let r = Regulator::new(Limits::default(), 1e-3, false).unwrap();
        assert_eq!(r.end(0.5, 2.0), 0.501);
        assert_eq!(r.end(0.5, 0.5011), 0.5 + 0.5 * (0.5011 - 0.5));
        assert_eq!(r.end(0.5, 0.5008), 0.5008);
    }

    #[test]
    fn limits_that_make_no_sense_are_refused() {
        let d = Limits::default();
        for (limits, word) in [
            (
                Limits {
                    length: [1e-2, 1e-3],
                    ..d
                },
                "shortest",
            ),
            (
                Limits {
                    length: [0.0, 1e-3],
                    ..d
                },
                "shortest",
            ),
            (
                Limits {
                    change: [1.1, 1.5],
                    ..d
                },
                "change",
            ),
            (Limits { safety: 1.5, ..d }, "safety"),
            (Limits { integral: 0.0, ..d }, "gains"),
        ] {
            let error = Regulator::new(limits, 1e-3, false).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
