//! Definitions of units and display units, for the model description.

use super::setters::setters;

/// A unit in terms of the SI base units and `rad`:
///
/// ```
/// # use fmu_export::{DisplayUnit, Unit};
/// const VISCOSITY: Unit = Unit::new("Pa.s").kg(1).m(-1).s(-1).display(&[DisplayUnit::new("mPa.s", 1e3)]);
/// const FAHRENHEIT: Unit = Unit::new("degF").K(1).factor(5.0 / 9.0).offset(459.67 * 5.0 / 9.0);
/// ```
///
/// A value in base units = factor · value + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    pub(crate) name: &'static str,
    /// In the order of [`DIMENSIONS`].
    pub(crate) exponents: [i8; 8],
    pub(crate) factor: f64,
    pub(crate) offset: f64,
    pub(crate) display: &'static [DisplayUnit],
}

/// The base units, named like the attributes of `<BaseUnit>`.
pub(crate) const DIMENSIONS: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

macro_rules! exponents {
    ($($unit:ident $k:literal)*) => {$(
        #[doc = concat!("Exponent of ", stringify!($unit), ".")]
        #[allow(non_snake_case)] // named like the unit
        #[must_use]
        pub const fn $unit(mut self, exponent: i8) -> Self {
            self.exponents[$k] = exponent;
            self
        }
    )*};
}

impl Unit {
    /// A unit without dimension. `name` is what the `unit` attribute has, e.g. `N.m`.
    #[must_use]
    pub const fn new(name: &'static str) -> Self {
        Self {
            name,
            exponents: [0; 8],
            factor: 1.0,
            offset: 0.0,
            display: &[],
        }
    }

    /// Whether this is the unit of a rate of change, per second, of values in `unit`.
    #[cfg(feature = "derive")]
    pub(crate) const fn is_rate_of(&self, unit: &Unit) -> bool {
        let mut is_it = self.factor == unit.factor && self.offset == 0.0;
        let mut k = 0;
        while k < DIMENSIONS.len() {
            is_it &= self.exponents[k] == unit.exponents[k] - (k == 2) as i8; // s
            k += 1;
        }
        is_it
    }

    exponents! { kg 0 m 1 s 2 A 3 K 4 mol 5 cd 6 rad 7 }

    setters! {
        /// Value of one unit in base units.
        #[must_use]
        factor(factor: f64) factor = factor;
        /// Value of the unit's zero in base units.
        #[must_use]
        offset(offset: f64) offset = offset;
        /// Units in which tools may show values.
        #[must_use]
        display(units: &'static [DisplayUnit]) display = units;
    }
}

/// A unit in which tools may show values: shown value = factor · value + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayUnit {
    pub(crate) name: &'static str,
    pub(crate) factor: f64,
    pub(crate) offset: f64,
}

impl DisplayUnit {
    /// `factor` is the number of display units in one unit (`mm` for `m`: 1000).
    #[must_use]
    pub const fn new(name: &'static str, factor: f64) -> Self {
        Self {
            name,
            factor,
            offset: 0.0,
        }
    }

    setters! {
        /// The value shown for a zero of the unit (`degC` for `K`: −273.15).
        #[must_use]
        offset(offset: f64) offset = offset;
    }
}
