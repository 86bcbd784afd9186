//! Definitions of units and display units, for the model descriptions that FMUs write
//! (`fmu-export`), and for the master, which knows common units by name.

/// A unit in terms of the SI base units and `rad`, in one line:
///
/// ```
/// # use fmi_units::{DisplayUnit, Unit};
/// const VISCOSITY: Unit = Unit::new("Pa.s").kg(1).m(-1).s(-1).display(&[DisplayUnit::new("mPa.s", 1e3)]);
/// const FAHRENHEIT: Unit = Unit::new("degF").K(1).factor(5.0 / 9.0).offset(459.67 * 5.0 / 9.0);
/// ```
///
/// A value in base units = factor · value + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name.
    pub name: &'static str,
    /// In the order of [`BASE`].
    pub exponents: [i8; 8],
    /// Factor from this unit to base units (`mm` to `m`: 1e-3).
    pub factor: f64,
    /// Value of its zero in base units.
    pub offset: f64,
    /// Units to show values in.
    pub display: &'static [DisplayUnit],
}

/// The base units, as the attributes of `<BaseUnit>` are called.
pub const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

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

    exponents! { kg 0 m 1 s 2 A 3 K 4 mol 5 cd 6 rad 7 }

    /// Sets how many base units it is.
    #[must_use]
    pub const fn factor(mut self, factor: f64) -> Self {
        self.factor = factor;
        self
    }

    /// Sets the value of its zero in base units.
    #[must_use]
    pub const fn offset(mut self, offset: f64) -> Self {
        self.offset = offset;
        self
    }

    /// Sets the units to show values in.
    #[must_use]
    pub const fn display(mut self, units: &'static [DisplayUnit]) -> Self {
        self.display = units;
        self
    }
}

/// A unit to show values in: shown value = factor · value + offset. [`Unit`] goes the other way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Name.
    pub name: &'static str,
    /// How many display units one unit is.
    pub factor: f64,
    /// What a zero of the unit is shown as.
    pub offset: f64,
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

    /// Sets what a zero of the unit is shown as (`degC` for `K`: −273.15).
    #[must_use]
    pub const fn offset(mut self, offset: f64) -> Self {
        self.offset = offset;
        self
    }
}
