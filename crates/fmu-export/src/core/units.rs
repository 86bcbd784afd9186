//! Units every model may name without declaring them.

use crate::{Base, Unit};
use std::f64::consts::PI;

const ONE: Base = Base::ONE;
const DEG: (&str, f64) = ("deg", 180.0 / PI);

/// SI units in use in mechanics and electrical drives, with the display units people expect. All have factor 1 to the base units.
#[rustfmt::skip]
pub const KNOWN_UNITS: &[Unit] = &[
    Unit { name: "1",           base: ONE,                                                    display: &[("%", 100.0)] },
    Unit { name: "s",           base: Base { s: 1, ..ONE },                                   display: &[("ms", 1e3)] },
    Unit { name: "Hz",          base: Base { s: -1, ..ONE },                                  display: &[("kHz", 1e-3)] },
    Unit { name: "1/s",         base: Base { s: -1, ..ONE },                                  display: &[] },
    Unit { name: "1/s2",        base: Base { s: -2, ..ONE },                                  display: &[] },
    Unit { name: "1/m",         base: Base { m: -1, ..ONE },                                  display: &[] },
    Unit { name: "m",           base: Base { m: 1, ..ONE },                                   display: &[("mm", 1e3)] },
    Unit { name: "m2",          base: Base { m: 2, ..ONE },                                   display: &[("mm2", 1e6)] },
    Unit { name: "m/s",         base: Base { m: 1, s: -1, ..ONE },                            display: &[("mm/s", 1e3)] },
    Unit { name: "m/s2",        base: Base { m: 1, s: -2, ..ONE },                            display: &[] },
    Unit { name: "m/rad",       base: Base { m: 1, rad: -1, ..ONE },                          display: &[] },
    Unit { name: "rad",         base: Base { rad: 1, ..ONE },                                 display: &[DEG] },
    Unit { name: "rad/s",       base: Base { rad: 1, s: -1, ..ONE },                          display: &[("rpm", 30.0 / PI), ("deg/s", 180.0 / PI)] },
    Unit { name: "rad/s2",      base: Base { rad: 1, s: -2, ..ONE },                          display: &[("deg/s2", 180.0 / PI)] },
    Unit { name: "kg",          base: Base { kg: 1, ..ONE },                                  display: &[("t", 1e-3)] },
    Unit { name: "kg.m",        base: Base { kg: 1, m: 1, ..ONE },                            display: &[] },
    Unit { name: "kg.m2",       base: Base { kg: 1, m: 2, ..ONE },                            display: &[] },
    Unit { name: "N",           base: Base { kg: 1, m: 1, s: -2, ..ONE },                     display: &[("kN", 1e-3)] },
    Unit { name: "N.m",         base: Base { kg: 1, m: 2, s: -2, ..ONE },                     display: &[("kN.m", 1e-3)] },
    Unit { name: "N/m",         base: Base { kg: 1, s: -2, ..ONE },                           display: &[("N/mm", 1e-3), ("kN/mm", 1e-6)] },
    Unit { name: "N.s/m",       base: Base { kg: 1, s: -1, ..ONE },                           display: &[] },
    Unit { name: "N.m/rad",     base: Base { kg: 1, m: 2, s: -2, rad: -1, ..ONE },            display: &[] },
    Unit { name: "N.m.s/rad",   base: Base { kg: 1, m: 2, s: -1, rad: -1, ..ONE },            display: &[] },
    Unit { name: "N.m2",        base: Base { kg: 1, m: 3, s: -2, ..ONE },                     display: &[] },
    Unit { name: "Pa",          base: Base { kg: 1, m: -1, s: -2, ..ONE },                    display: &[("bar", 1e-5), ("MPa", 1e-6)] },
    Unit { name: "J",           base: Base { kg: 1, m: 2, s: -2, ..ONE },                     display: &[("kJ", 1e-3)] },
    Unit { name: "W",           base: Base { kg: 1, m: 2, s: -3, ..ONE },                     display: &[("kW", 1e-3)] },
    Unit { name: "A",           base: Base { A: 1, ..ONE },                                   display: &[] },
    Unit { name: "V",           base: Base { kg: 1, m: 2, s: -3, A: -1, ..ONE },              display: &[] },
    Unit { name: "V/A",         base: Base { kg: 1, m: 2, s: -3, A: -2, ..ONE },              display: &[] },
    Unit { name: "V/(A.s)",     base: Base { kg: 1, m: 2, s: -4, A: -2, ..ONE },              display: &[] },
    Unit { name: "V.s/m",       base: Base { kg: 1, m: 1, s: -2, A: -1, ..ONE },              display: &[] },
    Unit { name: "Ohm",         base: Base { kg: 1, m: 2, s: -3, A: -2, ..ONE },              display: &[("mOhm", 1e3)] },
    Unit { name: "H",           base: Base { kg: 1, m: 2, s: -2, A: -2, ..ONE },              display: &[("mH", 1e3)] },
    Unit { name: "Wb",          base: Base { kg: 1, m: 2, s: -2, A: -1, ..ONE },              display: &[] },
    Unit { name: "K",           base: Base { K: 1, ..ONE },                                   display: &[] },
];
