//! Finds mistakes in a table of variables, for model descriptions and for instantiation.

use super::parts::unit;
use crate::c_api::log::CATEGORIES;
use crate::core::causality::Causality;
use crate::core::dependencies::Knowns;
use crate::core::layout::{Layout, state};
use crate::core::model::Variable;
use crate::core::sizes::{self, StartValues};
use crate::core::storage::{Kind, Storage, each, typed};
use crate::core::value::Value;
use crate::{Enumeration, Model, ModelExchange};
use std::collections::{BTreeMap, BTreeSet};

/// The first mistake in the table, with the name of the row.
pub(crate) fn check<M: Model>(layout: &Layout<M>, start: &StartValues<M>) -> Result<(), String> {
    let identifier = M::INFO.model;
    if !is_identifier(identifier) {
        return Err(format!("model name `{identifier}` is not a C identifier"));
    }
    categories::<M>()?;
    experiment::<M>()?;
    for row in ModelExchange::<M>::rows() {
        check_derivative::<M>(row)
            .map_err(|reason| format!("variable `{}`: {reason}", row.full_name()))?;
    }
    for row in M::variables() {
        check_rate::<M>(row)
            .map_err(|reason| format!("variable `{}`: {reason}", row.full_name()))?;
    }
    lengths(layout, start)?;
    let (parameters, input) = start;
    let knowns = Knowns::new(layout);
    let mut names = BTreeSet::new();
    let mut numbers = BTreeMap::new();
    let mut units = BTreeMap::new();
    let mut enumerations = BTreeMap::new();
    for (number, (span, i, n)) in layout.entries() {
        let row = span.row;
        let name = row.element_name(i);
        let wrong = |reason: &str| Err(format!("variable `{name}`: {reason}"));
        if !is_structured(row.name) {
            return wrong(
                "is not a structured name such as `a.b` (no spaces, and no brackets, which vectors get automatically)",
            );
        }
        if !names.insert(name.clone()) {
            return wrong("is in the table twice");
        }
        let largest = span.largest_number();
        if number > largest {
            return wrong(&format!(
                "value reference {number} must be at most {largest}"
            ));
        }
        if let Some(first) = numbers.insert(number, name.clone()) {
            return wrong(&format!(
                "value reference {number} is already that of `{first}`"
            ));
        }
        let enumeration = row.enumeration.map(|e| (e.name, (e.items, e.description)));
        let checks = [
            attributes::<M>(row, i),
            same(
                &mut units,
                "unit",
                unit::<M>(row, i).map(|u| (u.name, u)),
                &name,
            ),
            items(row),
            same(&mut enumerations, "enumeration", enumeration, &name),
            bounds(row),
            self::start(row, parameters, input, (i, n)),
        ];
        if let Some(reason) = checks.into_iter().find_map(Result::err) {
            return wrong(&reason);
        }
        let while_stepping = knowns.resolve(row, i, false);
        let initially = knowns.resolve(row, i, true);
        match (while_stepping, initially, row.causality) {
            (Err(reason), _, _) | (_, Err(reason), _) => return wrong(&reason),
            _ if row.storage.is_equation() => {}
            (_, _, Causality::Output) | (Ok(None), _, Causality::CalculatedParameter) => {}
            (Ok(None), Ok(None), _) => {}
            _ => return wrong("only outputs have dependencies"),
        }
    }
    Ok(())
}

fn experiment<M: Model>() -> Result<(), String> {
    let e = M::INFO.experiment;
    let is_sound = e.start.is_finite() && e.stop > e.start && e.stop.is_finite() && e.step > 0.0;
    if is_sound && e.step.is_finite() {
        return Ok(());
    }
    Err(format!(
        "default experiment: start = {} s, stop = {} s, step = {} s must be finite, with stop > start and step > 0",
        e.start, e.stop, e.step
    ))
}

/// Each row has as many elements as it declares, and at least one: an empty row would be left out
/// of the description silently.
fn lengths<M: Model>(layout: &Layout<M>, (p, u): &StartValues<M>) -> Result<(), String> {
    let y = sizes::output::<M>(p);
    for (elements, row) in layout.rows() {
        let wrong = |reason: &str| Err(format!("variable `{}`: {reason}", row.name));
        if let Err(reason) = row.check_lengths() {
            return wrong(&reason);
        }
        match (elements.len(), row.storage.len(p, u, &y)) {
            (0, _) => return wrong("has no elements"),
            _ if row.storage.is_equation() => {}
            (n, found) if n != found => {
                return wrong(&format!("has {found} elements, but declares {n}"));
            }
            _ => {}
        }
    }
    Ok(())
}

/// The model's log categories have unique names.
fn categories<M: Model>() -> Result<(), String> {
    let mut names: BTreeSet<_> = CATEGORIES.iter().map(|(name, ..)| *name).collect();
    for (name, _) in M::INFO.log_categories {
        if name.is_empty() {
            return Err("a log category has no name".to_owned());
        }
        if !names.insert(name) {
            return Err(format!(
                "log category `{name}` is declared twice, or is a standard category"
            ));
        }
    }
    Ok(())
}

fn is_identifier(name: &str) -> bool {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    !name.is_empty() && name.chars().all(is_word) && !name.starts_with(|c: char| c.is_ascii_digit())
}

/// Whether a row's name is structured, such as `motor[2].winding.R`. Its last part must not have an
/// index, because this crate appends the indices of a vector's elements.
fn is_structured(name: &str) -> bool {
    let part = |part: &str| match part.strip_suffix(']').and_then(|part| part.split_once('[')) {
        Some((name, index)) => is_identifier(name) && index.parse::<u32>().is_ok(),
        None => is_identifier(part),
    };
    match name.rsplit_once('.') {
        Some((before, last)) => before.split('.').all(part) && is_identifier(last),
        None => is_identifier(name),
    }
}

/// A row that is the rate of another is a Real of the same causality and shape.
fn check_rate<M: Model>(row: &Variable<M>) -> Result<(), String> {
    let Some(name) = row.rate_of else {
        return Ok(());
    };
    let is_fit = |of: &&Variable<M>| {
        let are_inputs = [row, of].map(|row| matches!(row.storage, Storage::RealIn(_)));
        let are_outputs = [row, of].map(|row| matches!(row.storage, Storage::RealOut(_)));
        (are_inputs == [true; 2] || are_outputs == [true; 2])
            && !of.discrete
            && of.scalar == row.scalar
            && of.shape == row.shape
    };
    let mut rows = M::variables().iter().filter(|of| of.name == name);
    match rows.find(is_fit) {
        Some(_) => Ok(()),
        None => Err(format!(
            "it is the rate of `{name}`, which must be a continuous Real of the same causality and length"
        )),
    }
}

/// A derivative row names a continuous Real output or local variable, and has its shape.
fn check_derivative<M: Model>(row: &Variable<M>) -> Result<(), String> {
    if !row.storage.is_derivative() {
        return Ok(());
    }
    let is_fit = |state: &&Variable<M>| {
        let is_shown = matches!(state.causality, Causality::Output | Causality::Local);
        let is_real = matches!(state.storage, Storage::RealOut(_));
        is_real && is_shown && !state.discrete && state.scalar == row.scalar
    };
    if state::<M>(row.name).filter(is_fit).is_some() {
        return Ok(());
    }
    let kind = if row.scalar { "scalar" } else { "vector" };
    Err(format!(
        "`{}` must be a continuous Real output or local variable of the table, a {kind}",
        row.name
    ))
}

/// Attributes are used only where the row's type and causality allow them.
fn attributes<M: Model>(row: &Variable<M>, i: usize) -> Result<(), String> {
    let is_real = row.storage.is_real();
    if row.description.is_empty() {
        return Err("has no description".to_owned());
    }
    let (causality, storage) = (row.causality, &row.storage);
    let may_be_tuned = matches!(
        causality,
        Causality::Parameter | Causality::CalculatedParameter
    );
    if row.tunable && (!may_be_tuned || matches!(storage, Storage::Text(..))) {
        let reason = "only parameters can be tunable, except String parameters with a setter";
        return Err(reason.to_owned());
    }
    let varies = matches!(
        causality,
        Causality::Input | Causality::Output | Causality::Local
    );
    if row.discrete && !(is_real && varies) {
        return Err("only a Real that is not a parameter can be declared discrete".to_owned());
    }
    if row.enumeration.is_some() && row.storage.kind() != Kind::Integer {
        return Err("only an Integer row can have an enumeration".to_owned());
    }
    let unit_of_element = row.unit_of(i);
    let units = row.each_unit.len();
    if units > 0 && i >= units {
        return Err(format!("has units for {units} elements only"));
    }
    let has_unit = unit_of_element.is_some() || row.display_unit.is_some();
    if !is_real && (has_unit || row.nominal.is_some()) {
        return Err("only a Real has a unit or a nominal value".to_owned());
    }
    match (unit_of_element, unit::<M>(row, i), row.display_unit) {
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

/// An enumeration has items with unique names.
fn items<M: Model>(row: &Variable<M>) -> Result<(), String> {
    let Some(Enumeration { name, items, .. }) = row.enumeration else {
        return Ok(());
    };
    let mut names = BTreeSet::new();
    match items.iter().find(|(item, _)| !names.insert(item)) {
        Some((item, _)) => Err(format!("enumeration `{name}` has the item `{item}` twice")),
        None if items.is_empty() => Err(format!("enumeration `{name}` has no items")),
        None => Ok(()),
    }
}

/// No two enumerations, and no two units, share a name. `what` names the kind and `name` the
/// variable; `known` has the first variable of each.
fn same<T: Copy + PartialEq>(
    known: &mut BTreeMap<&'static str, (T, String)>,
    what: &str,
    own: Option<(&'static str, T)>,
    name: &str,
) -> Result<(), String> {
    let Some((of, own)) = own else {
        return Ok(());
    };
    let (first, at) = known.entry(of).or_insert_with(|| (own, name.to_owned()));
    match *first == own {
        true => Ok(()),
        false => Err(format!("{what} `{of}` is defined differently for `{at}`")),
    }
}

fn bounds<M: Model>(row: &Variable<M>) -> Result<(), String> {
    let fits = |x: f64| x.is_infinite() || typed!(row.storage.kind(), T => T::holds(x));
    if !(row.min <= row.max && fits(row.min) && fits(row.max)) {
        return Err(format!(
            "min = {} and max = {} are not valid bounds",
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

/// The start values of an input or parameter are allowed: `n` elements from the `i`-th on.
fn start<M: Model>(
    row: &Variable<M>,
    p: &M::Parameters,
    u: &M::Input,
    (i, n): (usize, usize),
) -> Result<(), String> {
    fn check<M: Model, T: Value>(row: &Variable<M>, starts: &[T]) -> Result<(), String> {
        match starts.iter().find(|start| !start.is_allowed(row)) {
            None => Ok(()),
            Some(start) => {
                let allowed = crate::core::value::allowed(row);
                Err(format!("start value {start} must be {allowed}"))
            }
        }
    }
    let of_input = row.storage.input_values(u);
    match of_input.or_else(|| row.storage.parameter_values(p)) {
        Some(values) => each!(Values, values, |values| check(row, &values[i..i + n])),
        None => Ok(()),
    }
}
