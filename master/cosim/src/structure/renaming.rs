//! Renames a system's variables to those of a component's FMU, for `System` (`--map`, and `maps` in
//! Python): a parameter mapping (`.ssm`) gives the FMU's name for each name of the structure.

use fmi_description::Description;
use system_structure::{MappingEntry, ParameterMapping, Transformation};

use crate::structure::{Hop, Structure};

/// Rename the connections, connectors and values of the component with the index `component` to the
/// names of its FMU. Connections to variables that the FMU lacks, and power bonds whose mean effort
/// it lacks, are dropped with a remark.
pub(crate) fn rename(
    structure: &mut Structure,
    component: usize,
    mapping: &ParameterMapping,
    description: &Description,
) {
    let name = structure.components[component].name.clone();
    let entry = |variable: &str| mapping.entries.iter().find(|e| e.source == variable);
    let renamed = |variable: &str| entry(variable).map_or(variable, |e| &e.target).to_string();
    let mut remarks = Vec::new();
    for connection in &mut structure.connections {
        if connection.end.0 == name
            && let Some(entry) = entry(&connection.end.1)
        {
            connection.end.1.clone_from(&entry.target);
            let last = hop(entry, entry.transformation.clone());
            connection.way.push(last);
        }
        if connection.start.0 != name {
            continue;
        }
        if let Some(entry) = entry(&connection.start.1) {
            connection.start.1.clone_from(&entry.target);
            let back = entry.transformation.as_ref().map(inverse);
            let unit = connection.unit.take();
            let first = Hop {
                unit,
                ..hop(entry, back)
            };
            connection.way.insert(0, first);
        }
        if let Some(bond) = &mut connection.bond {
            bond.step_mean = renamed(&bond.step_mean);
            bond.flow = renamed(&bond.flow);
            if description.index(&bond.step_mean).is_none() {
                remarks.push(format!(
                    "the power bond of {name}.{} is left out: its FMU has no mean effort `{}`",
                    connection.start.1, bond.step_mean
                ));
                connection.bond = None;
            }
        }
    }
    structure.connections.retain(|connection| {
        let ends = [&connection.start, &connection.end];
        let mut own = ends.into_iter().filter(|end| end.0 == name);
        let lacking = own.find(|end| description.index(&end.1).is_none());
        if let Some((_, variable)) = lacking {
            remarks.push(format!(
                "not connected: {connection}, because the FMU of `{name}` has no variable `{variable}` and the mapping names none for it"
            ));
        }
        lacking.is_none()
    });
    for alarm in &mut structure.alarms {
        let own = alarm.name.strip_prefix(&format!("{name}."));
        if let Some(entry) = own.and_then(entry) {
            alarm.name = format!("{name}.{}", entry.target);
        }
    }
    let component = &mut structure.components[component];
    for connector in &mut component.connectors {
        if let Some(entry) = entry(&connector.name) {
            connector.name.clone_from(&entry.target);
            connector.unit = None;
        }
    }
    for parameter in &mut component.parameters {
        if let Some(entry) = entry(&parameter.name) {
            parameter.name.clone_from(&entry.target);
            parameter.way.push(hop(entry, entry.transformation.clone()));
        }
    }
    structure.remarks.extend(remarks);
}

fn hop(entry: &MappingEntry, transformation: Option<Transformation>) -> Hop {
    Hop {
        transformation,
        keeps_units: entry.keeps_units,
        unit: None,
    }
}

/// The transformation from the FMU's values to those of the structure.
fn inverse(transformation: &Transformation) -> Transformation {
    fn swapped<T: Clone>(entries: &[(T, T)]) -> Vec<(T, T)> {
        let all = entries.iter().cloned();
        all.map(|(source, target)| (target, source)).collect()
    }
    match transformation {
        Transformation::Linear { factor, offset } => Transformation::Linear {
            factor: 1.0 / factor,
            offset: -offset / factor,
        },
        Transformation::Booleans(entries) => Transformation::Booleans(swapped(entries)),
        Transformation::Integers(entries) => Transformation::Integers(swapped(entries)),
        Transformation::Items(entries) => Transformation::Items(swapped(entries)),
    }
}
