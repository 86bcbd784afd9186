//! Values of variables as numbers: what a variable can take, and how people and files write it.

use anyhow::{Result, ensure};
use fmi_description::{Kind, Variable};

use fmi_import::value::{self, Value};

/// Whole numbers up to here pass as numbers without loss: 2^53.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// The number that `text` is for a variable: a number, `true` or `false`, the name or the number of
/// an enumeration item. Integers and Booleans may be written as this program writes them, `3.0`.
///
/// # Errors
/// What the text has to be.
pub fn number(v: &Variable, text: &str) -> Result<f64> {
    let number = match Value::parse_for(v, text) {
        Ok(Value::Whole(number)) => Some(whole(number)),
        _ => text.parse().ok(),
    };
    let number = number.filter(|number| fits(v, *number));
    ensure!(number.is_some(), "`{text}` is not {}", allowed(v));
    Ok(number.unwrap_or_default())
}

/// Whether a variable can take a number.
pub fn fits(v: &Variable, number: f64) -> bool {
    let is_whole = number.fract() == 0.0 && number.abs() <= WHOLE;
    let [least, greatest] = v.bounds();
    let is_within = least <= number && number <= greatest;
    match &v.kind {
        Kind::Real => number.is_finite() && is_within,
        Kind::Integer => is_whole && is_within && value::fits(v.access(), number as i128),
        Kind::Boolean => number == 0.0 || number == 1.0,
        Kind::Enumeration(items) => items.iter().any(|item| whole(item.value.into()) == number),
        Kind::String | Kind::Binary | Kind::Clock => false,
    }
}

/// What a variable takes, for messages.
pub fn allowed(v: &Variable) -> String {
    let bounds = match (v.min, v.max) {
        (Some(least), Some(greatest)) => Some(format!("from {least} to {greatest}")),
        (Some(least), None) => Some(format!("of at least {least}")),
        (None, greatest) => greatest.map(|greatest| format!("of at most {greatest}")),
    };
    match (&v.kind, bounds) {
        (Kind::Real, Some(bounds)) => format!("a number {bounds}"),
        (Kind::Integer, Some(bounds)) => format!("a whole number {bounds}"),
        (Kind::Real, None) => "a finite number".into(),
        (Kind::Boolean, _) => "true (1) or false (0)".into(),
        _ => Value::parse_for(v, "").err().unwrap_or("a number".into()),
    }
}

fn whole(value: i128) -> f64 {
    value as f64
}
