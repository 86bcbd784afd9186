//! Looks up units by name: as the files of a system define them, else among the common units. Input
//! tables use it, because their columns have unit names only.

use fmi_description::Unit;

use crate::structure::system::System;
use crate::wiring::transformation::unit_of;

/// The unit `name`: as an FMU or the structure defines it, else the common unit of this name.
pub(crate) fn find_unit(system: &System, name: &str) -> Unit {
    let descriptions = system.fmus.iter().map(|fmu| &fmu.description);
    let of_fmus = descriptions.flat_map(|d| d.variables.iter().filter_map(|v| unit_of(d, v)));
    let components = system.structure.components.iter();
    let connectors = components.flat_map(|c| c.connectors.iter().filter_map(|c| c.unit.clone()));
    let inputs = system.structure.inputs.iter();
    let outer = inputs.filter_map(|input| input.unit.clone());
    let mut all = of_fmus.chain(connectors).chain(outer);
    let defined = all.find(|unit| unit.name == name && unit.exponents.is_some());
    defined.unwrap_or_else(|| common_unit(name))
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
