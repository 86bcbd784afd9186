//! Reads variables, clocks and dependencies of a model description of FMI 3.0, for `parse`.

use std::collections::HashMap;

use crate::description::{Description, Unknown};
use crate::file::{Items, VariableElements, enumeration, items, unknown};
use crate::limits::ARRAY_ELEMENTS;
use crate::variable::{Access, Causality, ClockInterval, ClockTiming, Kind, Variability, Variable};
use crate::xml::{Element, XmlError};

/// Reads what FMI 3.0 describes in its own way, with these values of structural parameters.
pub fn read(
    root: &Element,
    into: &mut Description,
    sizes: &HashMap<u32, String>,
) -> Result<(), XmlError> {
    into.variables = variables(root, sizes)?;
    // The first of aliases.
    let pairs = into.variables.iter().enumerate().rev();
    let by_reference: HashMap<u32, usize> = pairs.map(|(k, v)| (v.reference, k)).collect();
    let index = |word: &str| {
        let number = word.trim().parse().ok();
        let found = number.and_then(|n: u32| by_reference.get(&n)).copied();
        found.ok_or_else(|| {
            format!("ModelStructure names value reference {word}, which no variable has")
        })
    };
    let unknowns = |tag| -> Result<Vec<Unknown>, XmlError> {
        let read = |u| unknown(u, "valueReference", index);
        root.listed("ModelStructure", tag).map(read).collect()
    };
    into.outputs = unknowns("Output")?;
    into.derivatives = unknowns("ContinuousStateDerivative")?;
    into.initial_unknowns = unknowns("InitialUnknown")?;
    let lists = [&into.outputs, &into.derivatives, &into.initial_unknowns];
    let all = lists.into_iter().flatten();
    let known = all.flat_map(|u| u.dependencies.iter().flat_map(|known| known.iter()));
    if known.map(|k| into.variables[*k].size()).sum::<usize>() > 16 * ARRAY_ELEMENTS {
        let most = 16 * ARRAY_ELEMENTS;
        let text =
            format!("ModelStructure lists more than {most} dependencies, counted by element");
        return Err(root.error(text));
    }
    let indicators = unknowns("EventIndicator")?;
    let mut listed = indicators.iter().map(|u| &into.variables[u.variable]);
    if let Some(v) = listed.find(|v| v.kind != Kind::Real) {
        let name = &v.name;
        let text =
            format!("ModelStructure lists `{name}` as an event indicator, but it is no Float64");
        return Err(root.error(text));
    }
    let indicators = indicators.into_iter();
    into.event_indicators = indicators.map(|u| into.variables[u.variable].size()).sum();
    Ok(())
}

/// Reads all variables and their aliases.
fn variables(root: &Element, sizes: &HashMap<u32, String>) -> Result<Vec<Variable>, XmlError> {
    let types = root.all_in("TypeDefinitions");
    let types: HashMap<_, _> = types.map(|t| (t.text("name"), t)).collect();
    let enumerations = items(types.iter().map(|(name, t)| (name, *t)));
    let mut lengths: HashMap<_, _> = root.all_in("ModelVariables").filter_map(length).collect();
    let given = sizes.iter();
    let given = given.filter_map(|(reference, size)| Some((*reference, size.parse().ok()?)));
    lengths.extend(given);
    let (mut variables, mut size) = (Vec::new(), 0);
    for element in root.all_in("ModelVariables") {
        let Some(access) = access(&element.tag) else {
            continue; // an annotation
        };
        let declared = element.get("declaredType").and_then(|name| types.get(name));
        let source = VariableElements {
            variable: element,
            typed: element,
            declared: declared.copied(),
        };
        let is_given = |dimension: &Element| {
            let reference = dimension.whole("valueReference").ok().flatten();
            reference.is_some_and(|reference| sizes.contains_key(&reference))
        };
        let is_resized = element.all("Dimension").any(is_given);
        let mut own = Variable {
            dimensions: dimensions(element, &lengths, is_resized)?,
            ..variable(source, access, &enumerations)?
        };
        if is_resized {
            own.start.clear();
        } else if let Some(value) = sizes.get(&own.reference) {
            own.start = vec![value.clone()];
        }
        let aliases = element.all("Alias").map(|alias| {
            let display_unit = alias.get("displayUnit").map(str::to_string);
            Ok(Variable {
                name: alias.required("name")?,
                description: alias.text("description"),
                display_unit: display_unit.or_else(|| own.display_unit.clone()),
                ..own.clone()
            })
        });
        let aliases = aliases.collect::<Result<Vec<_>, XmlError>>()?;
        // Each element has the texts of its array.
        let weight = 1 + (own.name.len() + own.description.len()) / 256;
        if !own.dimensions.is_empty() {
            size += own.size().saturating_mul(weight * (1 + aliases.len()));
        }
        if size > ARRAY_ELEMENTS {
            return Err(element.wrong(format!(
                "is too large: all arrays of an FMU may have {ARRAY_ELEMENTS} elements together"
            )));
        }
        variables.push(own);
        variables.extend(aliases);
    }
    Ok(variables)
}

/// The functions for variables with this tag: `Some(None)` for an enumeration, None for no
/// variable.
fn access(tag: &str) -> Option<Option<Access>> {
    match Access::WORDS.iter().find(|(word, _)| *word == tag) {
        Some((_, access)) => Some(Some(*access)),
        None => (tag == "Enumeration").then_some(None),
    }
}

/// Value reference and start value of a structural parameter, which is the length of arrays whose
/// dimension names it.
fn length(element: &Element) -> Option<(u32, usize)> {
    if element.tag != "UInt64" {
        return None;
    }
    let number = |name| element.get(name).map(str::trim);
    let reference = number("valueReference")?.parse().ok()?;
    Some((reference, number("start")?.parse().ok()?))
}

/// The lengths of an array; only one that is resized may have no elements.
fn dimensions(
    element: &Element,
    lengths: &HashMap<u32, usize>,
    is_resized: bool,
) -> Result<Vec<usize>, XmlError> {
    let length = |dimension: &Element| {
        let start = dimension.whole("start").ok()?;
        let reference: Option<u32> = dimension.whole("valueReference").ok()?;
        match (start, reference) {
            (Some(start), None) => Some(start),
            (None, Some(reference)) => lengths.get(&reference).copied(),
            _ => None,
        }
    };
    let lengths: Option<Vec<usize>> = element.all("Dimension").map(length).collect();
    let lengths = lengths.filter(|lengths| {
        let mut lengths = lengths.iter();
        let size = lengths.try_fold(1_usize, |size, length| size.checked_mul(*length));
        let least = usize::from(!is_resized);
        size.is_some_and(|size| (least..=ARRAY_ELEMENTS).contains(&size))
    });
    lengths.ok_or_else(|| {
        if is_resized {
            return element.wrong(format!(
                "is too large at this size: an array has at most {ARRAY_ELEMENTS} elements"
            ));
        }
        element.error(format!(
            "a dimension of `{}` must be a number of at least 1 or name a structural parameter that starts at one; an array has at most {ARRAY_ELEMENTS} elements",
            element.text("name")
        ))
    })
}

fn variable(
    source: VariableElements,
    access: Option<Access>,
    enumerations: &Items,
) -> Result<Variable, XmlError> {
    let kind = match access {
        None => enumeration(source.typed, enumerations)?,
        Some(Access::Real | Access::Float32) => Kind::Real,
        Some(Access::Boolean) => Kind::Boolean,
        Some(Access::String) => Kind::String,
        Some(Access::Binary) => Kind::Binary,
        Some(Access::Clock) => Kind::Clock,
        Some(_) => Kind::Integer,
    };
    let element = source.variable;
    let start = match (&kind, element.get("start")) {
        (Kind::String | Kind::Binary, _) => {
            let starts = element.all("Start").map(|start| start.required("value"));
            starts.collect::<Result<_, _>>()?
        }
        (_, Some(list)) => list.split_whitespace().map(String::from).collect(),
        (_, None) => Vec::new(),
    };
    let timing = match kind {
        Kind::Clock => timing(source)?,
        _ => None,
    };
    let clocks = element.get("clocks").unwrap_or_default().split_whitespace();
    let clock = |word: &str| {
        let reference = word.parse();
        reference.map_err(|_| element.wrong(format!("names `{word}` as a clock")))
    };
    Ok(Variable {
        start,
        timing,
        clocks: clocks.map(clock).collect::<Result<_, _>>()?,
        ..source.read(kind, access.unwrap_or(Access::Int64), default_variability)?
    })
}

/// The default of the variability.
fn default_variability(causality: Causality, kind: &Kind) -> Variability {
    match (causality, kind) {
        (
            Causality::Parameter | Causality::StructuralParameter | Causality::CalculatedParameter,
            _,
        ) => Variability::Fixed,
        (_, Kind::Real) => Variability::Continuous,
        _ => Variability::Discrete,
    }
}

/// Reads how a clock ticks; None if nothing is said.
fn timing(source: VariableElements) -> Result<Option<ClockTiming>, XmlError> {
    let number = |name: &str| {
        let element = source.element_with(name);
        element.map_or(Ok(None), |element| element.number(name))
    };
    let Some(element) = source.element_with("intervalVariability") else {
        return Ok(None);
    };
    let interval = element.word("intervalVariability", ClockInterval::WORDS)?;
    let resolution = number("resolution")?;
    let seconds = |decimal, counter| {
        let counted: Option<f64> = number(counter)?;
        let in_seconds = |(n, per_second)| n / per_second;
        Ok(number(decimal)?.or(counted.zip(resolution).map(in_seconds)))
    };
    let period = seconds("intervalDecimal", "intervalCounter")?;
    let shift = seconds("shiftDecimal", "shiftCounter")?.unwrap_or(0.0);
    let priority = match source.element_with("priority") {
        Some(element) => element.whole("priority")?.unwrap_or(0),
        None => 0,
    };
    Ok(interval.map(|interval| ClockTiming {
        interval,
        period,
        shift,
        priority,
    }))
}
