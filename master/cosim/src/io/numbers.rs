//! Values of variables as f64, for faults, input tables, pages and the probing of feedthrough:
//! checks which numbers a variable accepts, and parses them as users and files write them.

use anyhow::{Result, ensure};
use fmi_description::{Kind, Variable};

pub use fmi_import::digits::short;
use fmi_import::value::{self, Value};

/// Integers up to here are exact as f64: 2^53.
const LARGEST_EXACT: f64 = 9_007_199_254_740_992.0;

/// Parse the value of a variable: a number, `true` or `false`, the name or the number of an
/// enumeration item. Integers and Booleans may be written `3.0`, as the CSV logs have them.
pub fn number(v: &Variable, text: &str) -> Result<f64> {
    let number = match Value::parse_for(v, text) {
        Ok(Value::Whole(number)) => Some(number as f64),
        _ => text.trim().parse().ok(),
    };
    let number = number.filter(|number| fits(v, *number));
    ensure!(number.is_some(), "`{text}` is not {}", allowed(v));
    Ok(number.unwrap_or_default())
}

/// Whether a variable accepts a number.
pub fn fits(v: &Variable, number: f64) -> bool {
    let is_whole = number.fract() == 0.0 && number.abs() <= LARGEST_EXACT;
    let [least, greatest] = v.bounds();
    let is_within = least <= number && number <= greatest;
    match &v.kind {
        Kind::Real => number.is_finite() && is_within,
        Kind::Integer => is_whole && is_within && value::fits(v.access(), number as i128),
        Kind::Boolean => number == 0.0 || number == 1.0,
        Kind::Enumeration(items) if items.is_empty() => is_whole && is_within,
        Kind::Enumeration(items) => items.iter().any(|item| item.value as f64 == number),
        Kind::String | Kind::Binary | Kind::Clock => false,
    }
}

/// The values that a variable accepts, for messages.
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
