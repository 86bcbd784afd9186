//! Units of measurement by name, in SI base units: those that a model made with `fmu-export` may
//! use without defining them, and further ones in tables that the master reads.
//!
//! ```
//! let rpm = fmi_units::named("rpm").unwrap();
//! assert_eq!(60.0 * rpm.factor, std::f64::consts::TAU); // rad/s
//! ```
#![forbid(unsafe_code)]
#![no_std]

mod expression;
mod known;
mod spelling;
mod unit;

pub use known::KNOWN_UNITS;
pub use spelling::named;
pub use unit::{BASE, DisplayUnit, Unit};
