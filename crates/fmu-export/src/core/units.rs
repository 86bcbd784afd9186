//! Units every model may name without declaring them.

use super::unit::{DisplayUnit, Unit};
use std::f64::consts::PI;

const DEG: DisplayUnit = shown("deg", 180.0 / PI);

const fn shown(name: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit::new(name, factor)
}

/// Units in use in mechanics, electrical drives, heat and flow, with the display units people expect. All but `degC` and `A.h` have
/// factor 1 to the base units.
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
