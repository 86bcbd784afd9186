//! Units of measurement by name, in SI base units: those that a model may name without defining them,
//! and those that people write in tables.
//!
//! ```
//! let rpm = fmi_units::named("rpm").unwrap();
//! assert_eq!(60.0 * rpm.factor, std::f64::consts::TAU); // rad/s
//! ```
#![forbid(unsafe_code)]
#![no_std]

mod common;
mod known;
mod unit;

pub use common::named;
pub use known::KNOWN_UNITS;
pub use unit::{BASE, DisplayUnit, Unit};
