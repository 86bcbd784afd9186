//! [`Unit`]: a unit as model descriptions and files of SSP define it; the master converts by it.

use crate::xml::{Element, XmlError};

/// A unit with its conversion to SI base units: value in base units = `factor` · value + `offset`
/// (FMI 2.0, section 2.2.2; SSP 1.0, section 5.1).
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Name.
    pub name: String,
    /// Exponents of [`BASE`](fmi_units::BASE); None where the file does not define the unit.
    pub exponents: Option<[i32; 8]>,
    /// Factor to base units.
    pub factor: f64,
    /// Offset in base units.
    pub offset: f64,
}

impl Unit {
    /// A unit of which only the name is known.
    pub fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            exponents: None,
            factor: 1.0,
            offset: 0.0,
        }
    }

    /// Reads the unit that an element `Unit` defines.
    ///
    /// # Errors
    /// It has no name, or attributes that are no numbers.
    pub fn read(element: &Element) -> Result<Self, XmlError> {
        let mut unit = Self::named(element.required("name")?);
        let Some(base) = element.child("BaseUnit") else {
            return Ok(unit);
        };
        let mut exponents = [0; 8];
        for (exponent, name) in exponents.iter_mut().zip(fmi_units::BASE) {
            let Some(text) = base.get(name) else {
                continue;
            };
            *exponent = text.trim().parse().map_err(|_| {
                base.error(format!(
                    "unit `{}`: the exponent {name} = `{text}` must be a whole number",
                    unit.name
                ))
            })?;
        }
        unit.exponents = Some(exponents);
        unit.factor = base.finite("factor")?.unwrap_or(1.0);
        unit.offset = base.finite("offset")?.unwrap_or(0.0);
        Ok(unit)
    }

    /// The name in an attribute of `element`; None if there is none or it is empty.
    pub fn name_in<'a>(element: &'a Element, attribute: &str) -> Option<&'a str> {
        let name = element.get(attribute).map(str::trim);
        name.filter(|name| !name.is_empty())
    }
}
