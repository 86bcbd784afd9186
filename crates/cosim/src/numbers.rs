//! Values of variables as numbers: what a variable can take, and how people and files write it.

use anyhow::{Result, ensure};
use fmu_description::{Kind, Variable};

use crate::slave::range;

/// Whole numbers up to here pass as numbers without loss: 2^53.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// The number that `text` is for a variable: a number, `true` or `false`, the name or the number of
/// an enumeration item. Integers and Booleans may be written as this program writes them, `3.0`.
///
/// # Errors
/// What the text has to be.
pub fn number(v: &Variable, text: &str) -> Result<f64> {
    let number = match (&v.kind, text) {
        (Kind::Boolean, "true") => Some(1.0),
        (Kind::Boolean, "false") => Some(0.0),
        (Kind::Enumeration(items), _) => {
            let item = items.iter().find(|item| item.name == text);
            item.map(|item| whole(item.value)).or(text.parse().ok())
        }
        _ => text.parse().ok(),
    };
    let number = number.filter(|number| fits(v, *number));
    ensure!(number.is_some(), "`{text}` is not {}", allowed(v));
    Ok(number.unwrap_or_default())
}

/// Whether a variable can take a number.
pub fn fits(v: &Variable, number: f64) -> bool {
    let is_whole = number.fract() == 0.0 && number.abs() <= WHOLE;
    match &v.kind {
        Kind::Real => number.is_finite(),
        Kind::Integer => {
            let [least, most] = range(v.access()).map_or([-WHOLE, WHOLE], |r| r.map(whole));
            is_whole && least <= number && number <= most
        }
        Kind::Boolean => number == 0.0 || number == 1.0,
        Kind::Enumeration(items) => items.iter().any(|item| whole(item.value) == number),
        Kind::String | Kind::Binary | Kind::Clock => false,
    }
}

/// What a variable takes, for messages.
pub fn allowed(v: &Variable) -> String {
    match &v.kind {
        Kind::Real => "a finite number".into(),
        Kind::Integer => match range(v.access()) {
            Some([least, most]) => format!("a whole number from {least} to {most}"),
            None => "a whole number".into(),
        },
        Kind::Boolean => "true (1) or false (0)".into(),
        Kind::Enumeration(items) => {
            let item = |i: &fmu_description::Item| format!("{} ({})", i.name, i.value);
            let items: Vec<_> = items.iter().map(item).collect();
            format!("one of {}", items.join(", "))
        }
        other => format!("a number; the variable is of type {}", other.name()),
    }
}

#[expect(
    clippy::cast_precision_loss,
    reason = "whole numbers beyond 2^53 are refused"
)]
fn whole(value: i64) -> f64 {
    value as f64
}
