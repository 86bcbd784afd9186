//! Range checks of models' parameters and path files; the error names parameter, value and rule.

use thiserror::Error;

/// A parameter outside its range.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("`{name}` = {value} must be {rule}")]
pub struct ParamError {
    /// Name of the parameter.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What must hold.
    pub rule: &'static str,
}

/// Ranges that many parameters have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Finite and more than 0.
    Positive,
    /// Finite and at least 0.
    NotNegative,
    /// From 0 to 1.
    Share,
    /// Between -1 and 1, without these.
    Asymmetry,
    /// Finite.
    Finite,
}

impl Range {
    /// Whether `value` lies inside.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        match self {
            Self::Positive => value.is_finite() && value > 0.0,
            Self::NotNegative => value.is_finite() && value >= 0.0,
            Self::Share => (0.0..=1.0).contains(&value),
            Self::Asymmetry => value.abs() < 1.0,
            Self::Finite => value.is_finite(),
        }
    }

    /// The rule in words, after "must be".
    #[must_use]
    pub fn rule(self) -> &'static str {
        match self {
            Self::Positive => "finite and > 0",
            Self::NotNegative => "finite and ≥ 0",
            Self::Share => "from 0 to 1",
            Self::Asymmetry => "between -1 and 1",
            Self::Finite => "finite",
        }
    }
}

/// Checks that all `values`, each with its name, lie in `range`; the error is the first outside.
pub fn check<const N: usize>(
    range: Range,
    values: [(&'static str, f64); N],
) -> Result<(), ParamError> {
    let mut values = values.into_iter();
    values.try_for_each(|(name, value)| require(name, value, range.rule(), range.contains(value)))
}

/// Checks that all elements of the parameter `name` lie in `range`.
pub fn check_each(range: Range, name: &'static str, values: &[f64]) -> Result<(), ParamError> {
    let mut values = values.iter();
    values.try_for_each(|value| check(range, [(name, *value)]))
}

/// Checks fields of `$of`, each with the [`Range`] that it is listed under; a field's name in the
/// error is its path. Same result as [`check`].
#[macro_export]
macro_rules! check_fields {
    ($of:expr; $($range:ident: $($first:ident $(. $more:ident)*),+;)+) => {{
        let of = $of;
        Ok(())$(.and_then(|()| $crate::check($crate::Range::$range, [$(
            (concat!(stringify!($first) $(, ".", stringify!($more))*), of.$first $(.$more)*)
        ),+])))+
    }};
}

/// Checks a parameter with a special rule: it must be finite, and the rule must hold.
pub fn require(
    name: &'static str,
    value: f64,
    rule: &'static str,
    holds: bool,
) -> Result<(), ParamError> {
    if value.is_finite() && holds {
        return Ok(());
    }
    Err(ParamError { name, value, rule })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_the_ends_that_their_rules_say() {
        use Range::{NotNegative, Positive, Share};
        for (range, inside, outside) in [
            (
                Positive,
                [5e-324, 1.0, f64::MAX],
                [0.0, -1.0, f64::INFINITY],
            ),
            (
                NotNegative,
                [0.0, -0.0, 7.0],
                [-5e-324, f64::INFINITY, -3.0],
            ),
            (Share, [0.0, 0.3, 1.0], [-1e-9, 1.0 + 1e-9, f64::INFINITY]),
        ] {
            assert!(inside.iter().all(|&v| range.contains(v)), "{range:?}");
            assert!(!outside.iter().any(|&v| range.contains(v)), "{range:?}");
            assert!(!range.contains(f64::NAN), "{range:?}");
        }
    }

    #[test]
    fn a_message_names_parameter_value_and_rule() {
        let values = [("R", 2.0), ("L", -0.5), ("C", f64::NAN)];
        let error = check(Range::Positive, values).expect_err("L");
        assert_eq!(error.to_string(), "`L` = -0.5 must be finite and > 0");
        assert!(require("v_max", 3.0, "above v_min", true).is_ok());
        let error = require("v_max", f64::NAN, "above v_min", true).expect_err("NaN");
        assert_eq!(error.to_string(), "`v_max` = NaN must be above v_min");
    }
}
