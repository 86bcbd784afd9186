//! Checks of a communication step, its substeps and its errors, for the models of plant and drives.

use std::fmt;

use thiserror::Error;

/// Largest number of substeps in one step, half a second of computing. Normal operation takes 2 to
/// 16 per millisecond.
pub const MAX_SUBSTEPS: f64 = 1e6;

/// Largest `rate·dt` of a linear mode. The classical Runge–Kutta method is stable to 2.78 on the
/// real and 2.83 on the imaginary axis; 1 keeps it accurate too.
pub const RATE_STEP: f64 = 1.0;

/// The stages of the classical Runge–Kutta method: share of the substep at which the rates are
/// taken, and their weight.
pub const RK4_STAGES: [(f64, f64); 4] = [
    (0.0, 1.0 / 6.0),
    (0.5, 1.0 / 3.0),
    (0.5, 1.0 / 3.0),
    (1.0, 1.0 / 6.0),
];

/// Share by which a substep may exceed the longest one: importers' clocks have rounding errors, and
/// a nanosecond more than a millisecond must not cost another substep.
const TIME_SLACK: f64 = 1e-3;

/// A time, s, as messages show it: to the microsecond, without the rest of a rounding error. Shorter
/// than a millisecond, or too large for microseconds, it keeps its digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seconds(pub f64);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let has_microseconds = (1e-3..1e9).contains(&self.0.abs());
        let rounded = (self.0 * 1e6).round() / 1e6;
        if has_microseconds { rounded } else { self.0 }.fmt(f)
    }
}

/// Why a step could not be completed; the caller's state is untouched.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum StepError {
    /// The step itself is unusable.
    #[error("t = {} s: step h = {} s must be finite, > 0 and at most 10⁶ substeps long", Seconds(*t), Seconds(*h))]
    BadStep {
        /// Start of the step, s.
        t: f64,
        /// Length of the step, s.
        h: f64,
    },
    /// A quantity became infinite or NaN.
    #[error("t = {} s: `{signal}` became {value}; it must be finite", Seconds(*t))]
    NotFinite {
        /// Start of the step, s.
        t: f64,
        /// What became infinite or undefined.
        signal: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Number of substeps of at most `dt_max`, s, in a step of `h`, s. All have the same length, so the
/// last one ends where the step does.
#[inline]
pub fn substeps(h: f64, dt_max: f64) -> f64 {
    (h * (1.0 - TIME_SLACK) / dt_max).ceil().max(1.0)
}

/// Checks that the step size `h` is finite and positive; `t`, s, is the time in the error.
#[inline]
pub fn check_step(t: f64, h: f64) -> Result<(), StepError> {
    if h.is_finite() && h > 0.0 {
        return Ok(());
    }
    Err(StepError::BadStep { t, h })
}

/// Checks that all `values`, each with its name, are finite at the end of the step that began at
/// `t`, s.
#[inline]
pub fn check_finite<const N: usize>(
    t: f64,
    values: [(&'static str, f64); N],
) -> Result<(), StepError> {
    // 0·v is 0, unless v is infinite or NaN: one sum instead of a branch for each.
    if values.iter().map(|(_, value)| 0.0 * value).sum::<f64>() == 0.0 {
        return Ok(());
    }
    let is_wrong = |(_, value): &(&str, f64)| !value.is_finite();
    match values.into_iter().find(is_wrong) {
        None => Ok(()),
        Some((signal, value)) => Err(StepError::NotFinite { t, signal, value }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock that is off by rounding costs no substep; a longer step does.
    #[test]
    fn substeps_are_as_few_as_the_longest_allows() {
        let counts = [1e-9, 0.5e-3, 1e-3, 1.0005e-3, 1.01e-3, 2.9e-3].map(|h| substeps(h, 0.5e-3));
        assert_eq!(counts, [1.0, 1.0, 2.0, 2.0, 3.0, 6.0]);
    }

    #[test]
    fn times_are_shown_to_the_microsecond() {
        let shown = [
            1.180_999_999_999_999_8,
            2.0,
            0.1 + 0.2,
            -1.5,
            1e-7,
            1e300,
            f64::NAN,
        ]
        .map(|t| Seconds(t).to_string());
        let short = ["1.181", "2", "0.3", "-1.5", "0.0000001"].map(String::from);
        assert_eq!(shown[..5], short);
        assert_eq!((shown[5].len(), &*shown[6]), (301, "NaN"));
    }

    #[test]
    fn what_is_unusable_is_named() {
        for h in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
            assert!(check_step(3.0, h).is_err(), "{h}");
        }
        assert!(check_step(3.0, 1e-3).is_ok());
        assert!(check_finite(0.0, [("x", 1e308), ("y", -1e308)]).is_ok());
        let error = check_finite(0.5, [("x", 1.0), ("y", f64::NEG_INFINITY), ("z", f64::NAN)]);
        let expected = "t = 0.5 s: `y` became -inf; it must be finite";
        assert_eq!(error.expect_err("y").to_string(), expected);
    }
}
