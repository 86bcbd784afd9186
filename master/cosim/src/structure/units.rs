//! Units by their names: as the files of a system define them, else as everybody knows them.

use system_structure::Unit;

use crate::structure::system::System;
use crate::wiring::transformation::unit_of;

/// Exponents of kg, m, s, A, K, mol, cd and rad.
type Base = [i32; 8];
const LENGTH: Base = [0, 1, 0, 0, 0, 0, 0, 0];
const SPEED: Base = [0, 1, -1, 0, 0, 0, 0, 0];
const TIME: Base = [0, 0, 1, 0, 0, 0, 0, 0];
const MASS: Base = [1, 0, 0, 0, 0, 0, 0, 0];
const ANGLE: Base = [0, 0, 0, 0, 0, 0, 0, 1];
const RATE: Base = [0, 0, -1, 0, 0, 0, 0, 1];
const FORCE: Base = [1, 1, -2, 0, 0, 0, 0, 0];
const PRESSURE: Base = [1, -1, -2, 0, 0, 0, 0, 0];
const ENERGY: Base = [1, 2, -2, 0, 0, 0, 0, 0];
const POWER: Base = [1, 2, -3, 0, 0, 0, 0, 0];
const CURRENT: Base = [0, 0, 0, 1, 0, 0, 0, 0];
const VOLTAGE: Base = [1, 2, -3, -1, 0, 0, 0, 0];
const TEMPERATURE: Base = [0, 0, 0, 0, 1, 0, 0, 0];
const DEGREE: f64 = std::f64::consts::PI / 180.0;
const TURN: f64 = std::f64::consts::TAU;

/// Names, base units, factor and offset to base units.
const COMMON: &[(&[&str], Base, f64, f64)] = &[
    (&["m"], LENGTH, 1.0, 0.0),
    (&["mm"], LENGTH, 1e-3, 0.0),
    (&["m/s"], SPEED, 1.0, 0.0),
    (&["mm/s"], SPEED, 1e-3, 0.0),
    (&["km/h"], SPEED, 1.0 / 3.6, 0.0),
    (&["s"], TIME, 1.0, 0.0),
    (&["ms"], TIME, 1e-3, 0.0),
    (&["kg"], MASS, 1.0, 0.0),
    (&["rad"], ANGLE, 1.0, 0.0),
    (&["deg", "°"], ANGLE, DEGREE, 0.0),
    (&["rad/s"], RATE, 1.0, 0.0),
    (&["deg/s", "°/s"], RATE, DEGREE, 0.0),
    (&["rpm", "r/min", "rev/min"], RATE, TURN / 60.0, 0.0),
    (&["N"], FORCE, 1.0, 0.0),
    (&["kN"], FORCE, 1e3, 0.0),
    (&["Pa"], PRESSURE, 1.0, 0.0),
    (&["bar"], PRESSURE, 1e5, 0.0),
    (&["MPa"], PRESSURE, 1e6, 0.0),
    (&["J", "N.m", "Nm"], ENERGY, 1.0, 0.0),
    (&["W"], POWER, 1.0, 0.0),
    (&["kW"], POWER, 1e3, 0.0),
    (&["A"], CURRENT, 1.0, 0.0),
    (&["V"], VOLTAGE, 1.0, 0.0),
    (&["K"], TEMPERATURE, 1.0, 0.0),
    (&["degC", "°C", "Celsius"], TEMPERATURE, 1.0, 273.15),
];

/// The unit `name`: as an FMU or the structure of a system defines it, else a common one, else by
/// its name alone.
pub fn named(system: &System, name: &str) -> Unit {
    let descriptions = system.fmus.iter().map(|fmu| &fmu.description);
    let of_fmus = descriptions.flat_map(|d| d.variables.iter().filter_map(|v| unit_of(d, v)));
    let components = system.structure.components.iter();
    let connectors = components.flat_map(|c| c.connectors.iter().filter_map(|c| c.unit.clone()));
    let inputs = system.structure.inputs.iter();
    let outer = inputs.filter_map(|input| input.unit.clone());
    let mut all = of_fmus.chain(connectors).chain(outer);
    let defined = all.find(|unit| unit.name == name && unit.exponents.is_some());
    defined.unwrap_or_else(|| common(name))
}

/// A common unit, else one that is known by its name alone.
pub fn common(name: &str) -> Unit {
    let found = COMMON.iter().find(|(names, ..)| names.contains(&name));
    found.map_or_else(
        || Unit::named(name),
        |(_, exponents, factor, offset)| Unit {
            name: name.into(),
            exponents: Some(*exponents),
            factor: *factor,
            offset: *offset,
        },
    )
}
