//! Checks of the table of variables: what the compiler cannot see.

use super::unit;
use crate::Model;
use crate::core::dependencies::Knowns;
use crate::core::layout::Layout;
use crate::core::value::Value;
use crate::core::variable::{Causality, Place, Variable};
use std::collections::BTreeSet;

/// The first thing that is wrong with the table, with the name of the row.
pub(super) fn check<M: Model>(layout: &Layout<M>) -> Result<(), String> {
    let identifier = M::INFO.model;
    if !is_identifier(identifier) {
        return Err(format!("model name `{identifier}` is not a C identifier"));
    }
    let (parameters, input) = M::defaults();
    let knowns = Knowns::new(layout);
    let mut names = BTreeSet::new();
    for (i, row) in layout.iter() {
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
        let checks = [
            attributes(row, i),
            bounds(row),
            start(row, &parameters, &input, i),
        ];
        if let Some(reason) = checks.into_iter().find_map(Result::err) {
            return wrong(&reason);
        }
        let has_any = knowns
            .resolve(row.dependencies, i, false)
            .and_then(|while_stepping| {
                let initially = knowns.resolve(row.initial_dependencies, i, true)?;
                Ok(while_stepping.is_some() || initially.is_some())
            });
        match has_any {
            Err(reason) => return wrong(&reason),
            Ok(true) if row.causality != Causality::Output => {
                return wrong("only outputs have dependencies");
            }
            Ok(_) => {}
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
        && (row.causality != Causality::Parameter
            || matches!(row.place, Place::StringParameter(..)))
    {
        return Err("only numeric parameters can be tunable".to_owned());
    }
    if row.discrete && (!is_real || row.causality == Causality::Parameter) {
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
    match (
        unit_of_element,
        unit_of_element.and_then(unit::<M>),
        row.display_unit,
    ) {
        (Some(name), None, _) => Err(format!(
            "unit `{name}` is neither in KNOWN_UNITS nor in Info::units"
        )),
        (None, _, Some(display)) => Err(format!("display unit `{display}` without a unit")),
        (_, Some(unit), Some(display)) if unit.display.iter().all(|(name, _)| *name != display) => {
            Err(format!(
                "display unit `{display}` is not one of unit `{}`",
                unit.name
            ))
        }
        _ => Ok(()),
    }
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
        Some(nominal) if !(nominal.is_finite() && nominal > 0.0) => Err(format!(
            "nominal = {nominal}; allowed are finite values > 0"
        )),
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
