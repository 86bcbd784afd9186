//! Array connectors of SSP 2.0: for `system`, a connection of whole arrays becomes one connection
//! per element, because the master treats each element of an array as a variable.

use std::sync::Arc;

use anyhow::{Result, ensure};
use system_structure::Connector;

use crate::fmu::Fmu;
use crate::structure::{Connection, OuterOutput, Structure};

/// Component and variable.
type End = (String, String);

/// Names of the elements of an array, `x[1]`, `x[2]`; empty if the FMU has no such array.
pub(crate) fn elements(fmu: &Fmu, array: &str) -> Vec<String> {
    let names = fmu.description.variables.iter().map(|v| &v.name);
    let is_element = |name: &&String| {
        let index = name.strip_prefix(array);
        index.is_some_and(|n| n.starts_with('[') && n.find(']') == Some(n.len() - 1))
    };
    names.filter(is_element).cloned().collect()
}

/// Replace connectors that have dimensions, and their connections, by those of the elements.
pub(crate) fn resolve(structure: &mut Structure, fmus: &[Arc<Fmu>]) -> Result<()> {
    let mut arrays: Vec<(End, Vec<String>)> = Vec::new();
    for (component, fmu) in structure.components.iter_mut().zip(fmus) {
        for connector in std::mem::take(&mut component.connectors) {
            let all = elements(fmu, &connector.name);
            if connector.dimensions.is_empty() || all.is_empty() {
                component.connectors.push(connector);
                continue;
            }
            let sizes: Option<Vec<usize>> = connector.dimensions.iter().copied().collect();
            let declared = sizes.map_or(all.len(), |sizes| sizes.iter().product());
            ensure!(
                declared == all.len(),
                "connector `{}.{}` is declared with {declared} elements, but its FMU has {}",
                component.name,
                connector.name,
                all.len()
            );
            let one = |name: &String| Connector {
                name: name.clone(),
                dimensions: Vec::new(),
                ..connector.clone()
            };
            component.connectors.extend(all.iter().map(one));
            arrays.push(((component.name.clone(), connector.name), all));
        }
    }
    let elements_of = |end: &End| {
        let found = arrays.iter().find(|(array, _)| array == end);
        let each = |name: &String| (end.0.clone(), name.clone());
        found.map_or(vec![end.clone()], |(_, all)| all.iter().map(each).collect())
    };
    for connection in std::mem::take(&mut structure.connections) {
        let (starts, ends) = (elements_of(&connection.start), elements_of(&connection.end));
        let (from, to) = (starts.len(), ends.len());
        ensure!(
            from == to,
            "connection {connection}: its ends have {from} and {to} elements"
        );
        for (start, end) in starts.into_iter().zip(ends) {
            structure.connections.push(Connection {
                start,
                end,
                ..connection.clone()
            });
        }
    }
    for output in std::mem::take(&mut structure.outputs) {
        for start in elements_of(&output.start) {
            let index = start.1.strip_prefix(&output.start.1).unwrap_or_default();
            let name = output.name.clone() + index;
            structure.outputs.push(OuterOutput { name, start });
        }
    }
    for input in std::mem::take(&mut structure.inputs) {
        for (end, way) in &input.ends {
            for one in elements_of(end) {
                let name = input.name.clone() + one.1.strip_prefix(&end.1).unwrap_or_default();
                structure.feed(name, input.unit.clone(), (one, way.clone()));
            }
        }
    }
    Ok(())
}
