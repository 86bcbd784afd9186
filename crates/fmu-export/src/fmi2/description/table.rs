//! Checks of the table of variables: what the compiler cannot see.

use super::unit;
use crate::core::dependencies::Knowns;
use crate::core::layout::{LARGEST_NUMBER, Layout};
use crate::core::value::Value;
use crate::core::variable::{Causality, Place, Variable};
use crate::{Model, Unit};
use std::collections::{BTreeMap, BTreeSet};

/// The first thing that is wrong with the table, with the name of the row.
pub(super) fn check<M: Model>(layout: &Layout<M>) -> Result<(), String> {
    let identifier = M::INFO.model;
    if !is_identifier(identifier) {
        return Err(format!("model name `{identifier}` is not a C identifier"));
    }
    let (parameters, input) = M::defaults();
    let knowns = Knowns::new(layout);
    let mut names = BTreeSet::new();
    let mut numbers = BTreeMap::new();
    let mut units = BTreeMap::new();
    for (number, (i, row)) in layout.numbered() {
        let name = row.element_name(i);
        let wrong = |reason: &str| Err(format!("variable `{name}`: {reason}"));
        if !is_structured(row.name) {
            return wrong(
                "is not a structured name such as `a.b` (no spaces, no brackets: vectors get them from the layer)",
            );
        }
        if !names.insert(name.clone()) {
            return wrong("is in the table twice");
        }
        if number > LARGEST_NUMBER {
            return wrong(&format!(
                "value reference {number} must be at most {LARGEST_NUMBER}"
            ));
        }
        if let Some(first) = numbers.insert(number, name.clone()) {
            return wrong(&format!(
                "value reference {number} is already that of `{first}`"
            ));
        }
        let checks = [
            attributes(row, i),
            same_unit(&mut units, row, i, &name),
            bounds(row),
            start(row, &parameters, &input, i),
        ];
        if let Some(reason) = checks.into_iter().find_map(Result::err) {
            return wrong(&reason);
        }
        let while_stepping = knowns.resolve(row.dependencies, i, false);
        let initially = knowns.resolve(row.initial_dependencies, i, true);
        match (while_stepping, initially, row.causality) {
            (Err(reason), _, _) | (_, Err(reason), _) => return wrong(&reason),
            (_, _, Causality::Output) | (Ok(None), _, Causality::CalculatedParameter) => {}
            (Ok(None), Ok(None), _) => {}
            _ => return wrong("only outputs have dependencies"),
        }
    }
    Ok(())
}

fn is_identifier(name: &str) -> bool {
    let mut chars = name.chars();
    chars
        .next()
        .is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && chars.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn is_structured(name: &str) -> bool {
    name.split('.').all(is_identifier)
}

/// What makes sense for the row's type and causality only.
fn attributes<M: Model>(row: &Variable<M>, i: usize) -> Result<(), String> {
    let is_real = row.place.type_name() == "Real";
    if row.description.is_empty() {
        return Err("has no description".to_owned());
    }
    if row.tunable
        && (!matches!(
            row.causality,
            Causality::Parameter | Causality::CalculatedParameter
        ) || matches!(row.place, Place::StringParameter(..)))
    {
        return Err("only numeric parameters can be tunable".to_owned());
    }
    let varies = matches!(
        row.causality,
        Causality::Input | Causality::Output | Causality::Local
    );
    if row.discrete && !(is_real && varies) {
        return Err("only a Real that is not a parameter can be declared discrete".to_owned());
    }
    if row.enumeration.is_some() && row.place.type_name() != "Integer" {
        return Err("only an Integer row can have an enumeration".to_owned());
    }
    let unit_of_element = row.unit_of(i);
    if !row.each_unit.is_empty() && i >= row.each_unit.len() {
        return Err(format!(
            "has units for {} elements only",
            row.each_unit.len()
        ));
    }
    if !is_real
        && (unit_of_element.is_some() || row.display_unit.is_some() || row.nominal.is_some())
    {
        return Err("only a Real has a unit or a nominal value".to_owned());
    }
    match (unit_of_element, unit(row, i), row.display_unit) {
        (Some(name), None, _) => Err(format!(
            "unit `{name}` is neither in KNOWN_UNITS nor in Info::units"
        )),
        (None, _, Some(display)) => Err(format!("display unit `{display}` without a unit")),
        (_, Some(unit), Some(display))
            if unit.display.iter().all(|shown| shown.name != display) =>
        {
            Err(format!(
                "display unit `{display}` is not one of unit `{}`",
                unit.name
            ))
        }
        _ => Ok(()),
    }
}

/// A name of a unit means one thing.
fn same_unit<M: Model>(
    units: &mut BTreeMap<&'static str, (&'static Unit, String)>,
    row: &Variable<M>,
    i: usize,
    name: &str,
) -> Result<(), String> {
    let Some(unit) = unit(row, i) else {
        return Ok(());
    };
    let (known, first) = units
        .entry(unit.name)
        .or_insert_with(|| (unit, name.to_owned()));
    if *known == unit {
        return Ok(());
    }
    Err(format!(
        "unit `{}` is defined otherwise for `{first}`",
        unit.name
    ))
}

fn bounds<M: Model>(row: &Variable<M>) -> Result<(), String> {
    let fits =
        |x: f64| x.is_infinite() || x == f64::from(x as i32) || row.place.type_name() == "Real";
    if !(row.min <= row.max && fits(row.min) && fits(row.max)) {
        return Err(format!(
            "min = {} and max = {} are no bounds",
            row.min, row.max
        ));
    }
    match row.nominal {
        Some(nominal) if !(nominal.is_finite() && nominal > 0.0) => {
            Err(format!("nominal = {nominal} must be finite and > 0"))
        }
        _ => Ok(()),
    }
}

fn start<M: Model>(
    row: &Variable<M>,
    p: &M::Parameters,
    u: &M::Input,
    i: usize,
) -> Result<(), String> {
    fn check<M: Model, T: Value>(row: &Variable<M>, start: T) -> Result<(), String> {
        if start.is_allowed(row) {
            return Ok(());
        }
        Err(format!(
            "start value {start} must be {}",
            crate::core::value::allowed(row)
        ))
    }
    match &row.place {
        Place::RealIn(place) => check(row, place.get(u, i)),
        Place::IntegerIn(place) => check(row, place.get(u, i)),
        Place::RealParameter(place) => check(row, place.get(p, i)),
        Place::IntegerParameter(place) => check(row, place.get(p, i)),
        _ => Ok(()),
    }
}
