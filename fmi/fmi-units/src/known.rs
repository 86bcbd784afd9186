//! The units that every model made with `fmu-export` may use undeclared; `spelling` finds them too.

use crate::unit::{DisplayUnit, Unit};
use core::f64::consts::PI;

const DEG: DisplayUnit = shown("deg", 180.0 / PI);

const fn shown(name: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit::new(name, factor)
}

/// Units of mechanics, electrical drives, heat and flow, with the usual display units. All but
/// `degC` and `A.h` have factor 1 to the base units.
#[rustfmt::skip]
pub const KNOWN_UNITS: &[Unit] = &[
    Unit::new("1").display(&[shown("%", 100.0)]),
    Unit::new("s").s(1).display(&[shown("ms", 1e3)]),
    Unit::new("Hz").s(-1).display(&[shown("kHz", 1e-3)]),
    Unit::new("1/s").s(-1),
    Unit::new("1/s2").s(-2),
    Unit::new("1/m").m(-1),
    Unit::new("m").m(1).display(&[shown("mm", 1e3)]),
    Unit::new("m2").m(2).display(&[shown("mm2", 1e6)]),
    Unit::new("m/s").m(1).s(-1).display(&[shown("mm/s", 1e3)]),
    Unit::new("m/s2").m(1).s(-2),
    Unit::new("m/rad").m(1).rad(-1),
    Unit::new("rad").rad(1).display(&[DEG]),
    Unit::new("rad/s").rad(1).s(-1).display(&[shown("rpm", 30.0 / PI), shown("deg/s", 180.0 / PI)]),
    Unit::new("rad/s2").rad(1).s(-2).display(&[shown("deg/s2", 180.0 / PI)]),
    Unit::new("kg").kg(1).display(&[shown("t", 1e-3)]),
    Unit::new("kg.m").kg(1).m(1),
    Unit::new("kg.m2").kg(1).m(2),
    Unit::new("N").kg(1).m(1).s(-2).display(&[shown("kN", 1e-3)]),
    Unit::new("N.m").kg(1).m(2).s(-2).display(&[shown("kN.m", 1e-3)]),
    Unit::new("N/m").kg(1).s(-2).display(&[shown("N/mm", 1e-3), shown("kN/mm", 1e-6)]),
    Unit::new("N.s/m").kg(1).s(-1),
    Unit::new("N.m/rad").kg(1).m(2).s(-2).rad(-1),
    Unit::new("N.m.s/rad").kg(1).m(2).s(-1).rad(-1),
    Unit::new("N.m2").kg(1).m(3).s(-2),
    Unit::new("Pa").kg(1).m(-1).s(-2).display(&[shown("bar", 1e-5), shown("MPa", 1e-6)]),
    Unit::new("J").kg(1).m(2).s(-2).display(&[shown("kJ", 1e-3)]),
    Unit::new("W").kg(1).m(2).s(-3).display(&[shown("kW", 1e-3)]),
    Unit::new("A").A(1),
    Unit::new("V").kg(1).m(2).s(-3).A(-1),
    Unit::new("V/A").kg(1).m(2).s(-3).A(-2),
    Unit::new("V/(A.s)").kg(1).m(2).s(-4).A(-2),
    Unit::new("V.s/m").kg(1).m(1).s(-2).A(-1),
    Unit::new("Ohm").kg(1).m(2).s(-3).A(-2).display(&[shown("mOhm", 1e3)]),
    Unit::new("H").kg(1).m(2).s(-2).A(-2).display(&[shown("mH", 1e3)]),
    Unit::new("Wb").kg(1).m(2).s(-2).A(-1),
    Unit::new("K").K(1).display(&[shown("degC", 1.0).offset(-273.15)]),
    Unit::new("K/s").K(1).s(-1),
    Unit::new("A/s").A(1).s(-1),
    Unit::new("V/s").kg(1).m(2).s(-4).A(-1),
    Unit::new("degC").K(1).offset(273.15),
    Unit::new("1/K").K(-1),
    Unit::new("K/W").kg(-1).m(-2).s(3).K(1),
    Unit::new("W/K").kg(1).m(2).s(-3).K(-1),
    Unit::new("J/K").kg(1).m(2).s(-2).K(-1),
    Unit::new("J/(kg.K)").m(2).s(-2).K(-1),
    Unit::new("W/(m.K)").kg(1).m(1).s(-3).K(-1),
    Unit::new("W/(m2.K)").kg(1).s(-3).K(-1),
    Unit::new("F").kg(-1).m(-2).s(4).A(2).display(&[shown("mF", 1e3)]),
    Unit::new("A.h").A(1).s(1).factor(3600.0),
    Unit::new("A.s").A(1).s(1).display(&[shown("A.h", 1.0 / 3600.0)]),
    Unit::new("m3").m(3),
    Unit::new("m3/s").m(3).s(-1),
    Unit::new("kg/m3").kg(1).m(-3),
    Unit::new("kg/s").kg(1).s(-1),
];

/// The known units say in base units what their names say.
#[cfg(test)]
#[allow(non_snake_case)] // symbols of units
mod tests {
    use super::*;

    use crate::unit::BASE;

    /// A factor, and exponents of [`BASE`].
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Size(f64, [i32; 8]);

    /// What a symbol means by its definition (SI Brochure, 9th edition, tables 2, 4 and 8), as a
    /// factor and another expression.
    #[rustfmt::skip]
    const DEFINITIONS: &[(&str, f64, &str)] = &[
        ("Hz", 1.0, "1/s"), ("N", 1.0, "kg.m/s2"), ("Pa", 1.0, "N/m2"), ("J", 1.0, "N.m"), ("W", 1.0, "J/s"), ("V", 1.0, "W/A"),
        ("Ohm", 1.0, "V/A"), ("Wb", 1.0, "V.s"), ("H", 1.0, "Wb/A"), ("%", 0.01, "1"), ("deg", PI / 180.0, "rad"),
        ("rpm", 2.0 * PI / 60.0, "rad/s"), ("t", 1e3, "kg"), ("bar", 1e5, "Pa"), ("F", 1.0, "A.s/V"),
        ("h", 3600.0, "s"), ("degC", 1.0, "K"), ("d", 24.0, "h"), ("min", 60.0, "s"), ("g", 1e-3, "kg"), ("l", 1e-3, "m3"),
        ("L", 1e-3, "m3"), ("C", 1.0, "A.s"), ("S", 1.0, "A/V"), ("T", 1.0, "Wb/m2"), ("lm", 1.0, "cd"), ("lx", 1.0, "lm/m2"),
        ("Bq", 1.0, "1/s"), ("Gy", 1.0, "J/kg"), ("Sv", 1.0, "J/kg"), ("kat", 1.0, "mol/s"), ("rev", 2.0 * PI, "rad"),
    ];

    /// Zero of a unit in base units (SI Brochure, section 2.3.1: t/°C = T/K − 273.15); all others
    /// have the zero of their base units.
    const ZEROS: &[(&str, f64)] = &[("degC", 273.15)];

    fn zero(name: &str) -> f64 {
        (ZEROS.iter().find(|(known, _)| *known == name)).map_or(0.0, |(_, zero)| *zero)
    }

    /// One symbol with its prefix.
    fn symbol(text: &str) -> Size {
        if let Some(i) = BASE.iter().position(|&b| b == text) {
            let mut exponents = [0; 8];
            exponents[i] = 1;
            return Size(1.0, exponents);
        }
        if text == "1" {
            return Size(1.0, [0; 8]);
        }
        if let Some(&(_, factor, of)) = DEFINITIONS.iter().find(|(name, ..)| *name == text) {
            let Size(size, exponents) = expression(of);
            return Size(factor * size, exponents);
        }
        let prefixes = [
            ("k", 1e3),
            ("M", 1e6),
            ("m", 1e-3),
            ("da", 10.0),
            ("d", 0.1),
            ("c", 0.01),
            ("h", 100.0),
            ("u", 1e-6),
            ("G", 1e9),
            ("n", 1e-9),
        ];
        let (prefix, factor) = (prefixes.into_iter())
            .find(|(prefix, _)| text.starts_with(prefix))
            .unwrap_or_else(|| panic!("`{text}` is not a symbol of a unit"));
        let Size(size, exponents) = symbol(&text[prefix.len()..]);
        Size(factor * size, exponents)
    }

    /// Symbols with exponents, joined by `.`, and at most one `/` with all that divides behind it.
    fn expression(text: &str) -> Size {
        let (above, below) = text.split_once('/').unwrap_or((text, "1"));
        let mut product = Size(1.0, [0; 8]);
        for (part, sign) in [(above, 1), (below.trim_matches(['(', ')']), -1)] {
            for factor in part.split('.') {
                let name = factor.trim_end_matches(['2', '3', '4']);
                let power = sign * factor[name.len()..].parse().unwrap_or(1);
                let Size(size, exponents) = symbol(name);
                product.0 *= size.powi(power);
                for (total, exponent) in product.1.iter_mut().zip(exponents) {
                    *total += power * exponent;
                }
            }
        }
        product
    }

    /// All known units and their display units. Tolerance of the factors: the rounding of a few
    /// products.
    #[test]
    fn units_are_what_their_names_say() {
        let is_near = |a: f64, b: f64| (a / b - 1.0).abs() < 8.0 * f64::EPSILON;
        for unit in KNOWN_UNITS {
            let &Unit { factor, offset, .. } = unit;
            let declared = unit.exponents.map(i32::from);
            let Size(size, exponents) = expression(unit.name);
            assert_eq!(exponents, declared, "{}", unit.name);
            assert!(is_near(factor, size), "{}", unit.name);
            assert_eq!(offset, zero(unit.name), "{}", unit.name);
            for shown in unit.display {
                let Size(size, exponents) = expression(shown.name);
                assert_eq!(exponents, declared, "{}", shown.name);
                // base = factor · value + offset in both, so shown = (factor · value + offset −
                // zero)/size.
                let (shown_factor, shown_offset) = (shown.factor, shown.offset);
                assert!(is_near(shown_factor * size, factor), "{}", shown.name);
                let expected = (offset - zero(shown.name)) / size;
                assert_eq!(shown_offset, expected, "{}", shown.name);
            }
        }
    }

    /// What is not known is read as it is written. Tolerance as above.
    #[test]
    #[rustfmt::skip]
    fn expressions_are_what_they_say() {
        for name in [
            "m3/(s.Pa)", "m2/s", "K/m", "l/min", "mol", "L/h", "mol/(l.s)", "W/(m2.K4)", "cm3/rev", "kg/kmol", "A/mm2", "uV/degC", "dam",
            "daN.cm", "hPa", "mbar.l/s", "cd/(mm2.lm)", "kat", "Gy/min", "mSv/h", "nF", "mT.mm", "C/mol", "kBq.d", "km/h", "rpm/s", "%/K",
            "mmol/l", "GW.h", "kS/cm", "klx", "kmol.K/kg", "deg/min2",
        ] {
            let unit = Unit::find(name).unwrap();
            let Size(size, exponents) = expression(name);
            assert!((unit.factor / size - 1.0).abs() < 8.0 * f64::EPSILON, "{name}: {} {size}", unit.factor);
            assert_eq!((unit.exponents.map(i32::from), unit.offset), (exponents, 0.0), "{name}");
        }
        // Beyond what the oracle reads: (own exponents, parentheses above); decimal factors exactly.
        let same = [("m.s-2", "m/s2"), ("s+2", "s2"), ("(kg.m)/s", "kg.m/s"), ("1/(m2/s)", "s/m2"), ("K-1", "1/K"), ("m/(s.(K.A))", "m/(s.K.A)"), ("Ym", "m")];
        for (one, other) in same {
            assert_eq!(Unit::find(one).unwrap().exponents, Unit::find(other).unwrap().exponents, "{one}");
        }
        for (name, factor) in [("mm3", 1e-9), ("mm", 1e-3), ("bar", 1e5), ("l", 1e-3), ("um2", 1e-12), ("1/mm", 1e3), ("ns-1", 1e9), ("Ym", 1e24)] {
            assert_eq!(Unit::find(name).unwrap().factor, factor, "{name}");
        }
    }

    #[test]
    #[rustfmt::skip]
    fn what_is_no_unit_is_refused() {
        for name in [
            "", "furlong", "m/s/s", "m/", "/s", "m.", ".m", "m..s", "m^2", "m s", "(m", "m)", "m-", "m2.5", "mmin", "kh", "kdeg", "kk", "m100", "2",
            "m/s.K", "Nm", "m*s", "µm", "mdegC", "s-", "m99.m99", "ft", "ft/s", "PS", "Gs", "at", "pt",
        ] {
            assert_eq!(Unit::find(name), None, "{name}");
        }
    }

    /// Tolerance: rounding of two factors.
    #[test]
    #[rustfmt::skip]
    fn any_unit_of_the_same_dimension_shows_another() {
        for (unit, shown, factor, offset) in [
            ("m3/s", "l/min", 6e4, 0.0), ("m", "km", 1e-3, 0.0), ("m", "mm", 1e3, 0.0), ("K", "degC", 1.0, -273.15), ("degC", "K", 1.0, 273.15),
            ("K", "mK", 1e3, 0.0), ("l/min", "m3/s", 1.0 / 6e4, 0.0),
        ] {
            let display = Unit::find(unit).unwrap().shown_in(shown).unwrap();
            assert!((display.factor / factor - 1.0).abs() < 4.0 * f64::EPSILON, "{unit} {shown}: {display:?}");
            assert_eq!((display.offset, display.name), (offset, shown), "{unit}");
        }
        for (unit, shown) in [("m", "s"), ("m/s", "furlong/s"), ("rad", "1"), ("K/s", "degC")] {
            assert_eq!(Unit::find(unit).unwrap().shown_in(shown), None, "{unit} {shown}");
        }
    }

    #[test]
    fn what_heat_and_batteries_need_is_known() {
        for name in ["degC", "F", "A.h", "J/K", "W/K", "1/K", "K/W"] {
            assert!(KNOWN_UNITS.iter().any(|unit| unit.name == name), "{name}");
        }
        let kelvin = KNOWN_UNITS.iter().find(|unit| unit.name == "K").unwrap();
        assert_eq!(kelvin.display[0].name, "degC");
    }
}
