//! The units that the files of a system define, and the common units, by name. Input tables use
//! them, because their columns have unit names only.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use fmi_description::Unit;

use crate::structure::system::System;
use crate::wiring::transformation::unit_of;

/// The units that the FMUs of a system and its structure define, by name; the first of a name.
pub(crate) fn defined_units(system: &System) -> HashMap<String, Unit> {
    let mut seen = HashSet::new();
    let fmus = system.fmus.iter();
    let fmus = fmus.filter(|fmu| seen.insert(Arc::as_ptr(fmu)));
    let descriptions = fmus.map(|fmu| &fmu.description);
    let of_fmus = descriptions.flat_map(|d| d.variables.iter().filter_map(|v| unit_of(d, v)));
    let components = system.structure.components.iter();
    let connectors = components.flat_map(|c| c.connectors.iter().filter_map(|c| c.unit.clone()));
    let inputs = system.structure.inputs.iter();
    let outer = inputs.filter_map(|input| input.unit.clone());
    let mut units = HashMap::new();
    let all = of_fmus.chain(connectors).chain(outer);
    for unit in all.filter(|unit| unit.exponents.is_some()) {
        units.entry(unit.name.clone()).or_insert(unit);
    }
    units
}

/// The common unit `name`; without a definition if there is none.
pub(crate) fn common_unit(name: &str) -> Unit {
    let unit = Unit::named(name);
    match fmi_units::named(name) {
        Some(common) => Unit {
            exponents: Some(common.exponents.map(i32::from)),
            factor: common.factor,
            offset: common.offset,
            ..unit
        },
        None => unit,
    }
}
