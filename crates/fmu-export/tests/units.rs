//! The known units say in base units what their names say.
#![allow(missing_docs, non_snake_case)] // symbols of units

use fmu_export::KNOWN_UNITS;
use std::f64::consts::PI;

/// A factor, and exponents of kg, m, s, A, K and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Size(f64, [i32; 6]);

/// What a symbol means by its definition (SI Brochure, 9th edition, tables 2, 4 and 8), as a factor and another expression.
#[rustfmt::skip]
const DEFINITIONS: &[(&str, f64, &str)] = &[
    ("Hz", 1.0, "1/s"), ("N", 1.0, "kg.m/s2"), ("Pa", 1.0, "N/m2"), ("J", 1.0, "N.m"), ("W", 1.0, "J/s"), ("V", 1.0, "W/A"),
    ("Ohm", 1.0, "V/A"), ("Wb", 1.0, "V.s"), ("H", 1.0, "Wb/A"), ("%", 0.01, "1"), ("deg", PI / 180.0, "rad"),
    ("rpm", 2.0 * PI / 60.0, "rad/s"), ("t", 1e3, "kg"), ("bar", 1e5, "Pa"), ("F", 1.0, "A.s/V"),
    ("h", 3600.0, "s"), ("degC", 1.0, "K"),
];

/// Zero of a unit in base units (SI Brochure, section 2.3.1: t/°C = T/K − 273.15); all others have the zero of their base units.
const ZEROS: &[(&str, f64)] = &[("degC", 273.15)];

fn zero(name: &str) -> f64 {
    (ZEROS.iter().find(|(known, _)| *known == name)).map_or(0.0, |(_, zero)| *zero)
}

/// One symbol with its prefix.
fn symbol(text: &str) -> Size {
    let base = ["kg", "m", "s", "A", "K", "rad"];
    if let Some(i) = base.iter().position(|&b| b == text) {
        let mut exponents = [0; 6];
        exponents[i] = 1;
        return Size(1.0, exponents);
    }
    if text == "1" {
        return Size(1.0, [0; 6]);
    }
    if let Some(&(_, factor, of)) = DEFINITIONS.iter().find(|(name, ..)| *name == text) {
        let Size(size, exponents) = expression(of);
        return Size(factor * size, exponents);
    }
    let prefixes = [("k", 1e3), ("M", 1e6), ("m", 1e-3)];
    let (prefix, factor) = (prefixes.into_iter())
        .find(|(prefix, _)| text.starts_with(prefix))
        .unwrap_or_else(|| panic!("`{text}` is not a symbol of a unit"));
    let Size(size, exponents) = symbol(&text[prefix.len()..]);
    Size(factor * size, exponents)
}

/// Symbols with exponents, joined by `.`, and at most one `/` with all that divides behind it.
fn expression(text: &str) -> Size {
    let (above, below) = text.split_once('/').unwrap_or((text, "1"));
    let mut product = Size(1.0, [0; 6]);
    for (part, sign) in [(above, 1), (below.trim_matches(['(', ')']), -1)] {
        for factor in part.split('.') {
            let name = factor.trim_end_matches(['2', '3']);
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

/// All known units and their display units. Tolerance of the factors: the rounding of a few products.
#[test]
fn units_are_what_their_names_say() {
    let is_near = |a: f64, b: f64| (a / b - 1.0).abs() < 8.0 * f64::EPSILON;
    for unit in KNOWN_UNITS {
        let ([kg, m, s, A, K, mol, cd, rad], factor, offset) = unit.base();
        assert_eq!([mol, cd], [0; 2], "{}", unit.name());
        let declared = [kg, m, s, A, K, rad].map(i32::from);
        let Size(size, exponents) = expression(unit.name());
        assert_eq!(exponents, declared, "{}", unit.name());
        assert!(is_near(factor, size), "{}", unit.name());
        assert_eq!(offset, zero(unit.name()), "{}", unit.name());
        for shown in unit.display_units() {
            let Size(size, exponents) = expression(shown.name());
            assert_eq!(exponents, declared, "{}", shown.name());
            // base = factor · value + offset in both, so shown = (factor · value + offset − zero)/size.
            let (shown_factor, shown_offset) = shown.scale();
            assert!(is_near(shown_factor * size, factor), "{}", shown.name());
            let expected = (offset - zero(shown.name())) / size;
            assert_eq!(shown_offset, expected, "{}", shown.name());
        }
    }
}

#[test]
fn what_heat_and_batteries_need_is_known() {
    for name in ["degC", "F", "A.h", "J/K", "W/K", "1/K", "K/W"] {
        assert!(KNOWN_UNITS.iter().any(|unit| unit.name() == name), "{name}");
    }
    let kelvin = KNOWN_UNITS.iter().find(|unit| unit.name() == "K").unwrap();
    assert_eq!(kelvin.display_units()[0].name(), "degC");
}
