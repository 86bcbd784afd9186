//! Finds a unit by any of its usual names, such as those in heads of tables that the master reads.

use crate::known::KNOWN_UNITS;
use crate::unit::Unit;

/// Units that FMUs of `fmu-export` do not have. `bar` is here too, since the inverse of its factor
/// as a display unit is not exactly 1e5.
const FURTHER: [Unit; 2] = [
    Unit::new("km/h").m(1).s(-1).factor(1.0 / 3.6),
    Unit::new("bar").kg(1).m(-1).s(-2).factor(1e5),
];

const SPELLINGS: [(&str, &str); 7] = [
    ("°", "deg"),
    ("°/s", "deg/s"),
    ("r/min", "rpm"),
    ("rev/min", "rpm"),
    ("Nm", "N.m"),
    ("°C", "degC"),
    ("Celsius", "degC"),
];

/// The unit of this name: one of [`KNOWN_UNITS`], a display unit of one, or another common unit or
/// spelling. It has no display units itself.
pub fn named(name: &str) -> Option<Unit> {
    let spelling = SPELLINGS.iter().find(|(other, _)| *other == name);
    let name = spelling.map_or(name, |(_, name)| name);
    let mut all = FURTHER.iter().chain(KNOWN_UNITS);
    let known = all.find(|unit| unit.name == name);
    let known = known.map(|unit| unit.display(&[]));
    known.or_else(|| {
        let shown = |unit: &Unit| {
            let display = unit.display.iter().find(|display| display.name == name)?;
            let factor = unit.factor / display.factor;
            Some(Unit {
                name: display.name,
                factor,
                offset: unit.offset - factor * display.offset,
                display: &[],
                ..*unit
            })
        };
        KNOWN_UNITS.iter().find_map(shown)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{PI, TAU};

    /// Exactly, so that a table gives the same numbers whichever way a unit is known.
    #[test]
    fn common_units_have_the_factors_of_their_definitions() {
        for (name, base, factor, offset) in [
            ("mm", "m", 1e-3, 0.0),
            ("mm/s", "m/s", 1e-3, 0.0),
            ("km/h", "m/s", 1.0 / 3.6, 0.0),
            ("ms", "s", 1e-3, 0.0),
            ("°", "rad", PI / 180.0, 0.0),
            ("deg/s", "rad/s", PI / 180.0, 0.0),
            ("rev/min", "rad/s", TAU / 60.0, 0.0),
            ("kN", "N", 1e3, 0.0),
            ("bar", "Pa", 1e5, 0.0),
            ("MPa", "Pa", 1e6, 0.0),
            ("Nm", "J", 1.0, 0.0),
            ("kW", "W", 1e3, 0.0),
            ("Celsius", "K", 1.0, 273.15),
            ("A.h", "A.s", 3600.0, 0.0),
        ] {
            let (unit, base) = (named(name).unwrap(), named(base).unwrap());
            assert_eq!((unit.factor, unit.offset), (factor, offset), "{name}");
            assert_eq!(unit.exponents, base.exponents, "{name}");
        }
        assert_eq!(named("furlong"), None);
    }
}
