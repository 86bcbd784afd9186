//! Array connectors of SSP 2.0: for `system`, a connection of whole arrays becomes one connection
//! per element, because the master treats each element of an array as a variable.

use std::collections::HashMap;
use std::sync::Arc;

use anyhow::{Result, ensure};
use system_structure::Connector;

use crate::fmu::Fmu;
use crate::structure::{Connection, OuterOutput, Structure};

/// Component and variable.
type End = (String, String);

/// Names of the elements of each array of an FMU, `x[1]`, `x[2]`.
pub(crate) fn elements(fmu: &Fmu) -> HashMap<&str, Vec<&str>> {
    let mut arrays: HashMap<&str, Vec<&str>> = HashMap::new();
    for v in &fmu.description.variables {
        for (at, _) in v.name.match_indices('[') {
            if v.name[at..].find(']') == Some(v.name.len() - at - 1) {
                arrays.entry(&v.name[..at]).or_default().push(&v.name);
            }
        }
    }
    arrays
}

/// Replace connectors that have dimensions, and their connections, by those of the elements.
pub(crate) fn resolve(structure: &mut Structure, fmus: &[Arc<Fmu>]) -> Result<()> {
    let mut arrays: HashMap<End, Vec<String>> = HashMap::new();
    for (component, fmu) in structure.components.iter_mut().zip(fmus) {
        if component.connectors.iter().all(|c| c.dimensions.is_empty()) {
            continue;
        }
        let elements = elements(fmu);
        for connector in std::mem::take(&mut component.connectors) {
            let all = elements.get(&*connector.name);
            let Some(all) = all.filter(|_| !connector.dimensions.is_empty()) else {
                component.connectors.push(connector);
                continue;
            };
            let sizes: Option<Vec<usize>> = connector.dimensions.iter().copied().collect();
            let declared = sizes.map_or(all.len(), |sizes| sizes.iter().product());
            ensure!(
                declared == all.len(),
                "connector `{}.{}` is declared with {declared} elements, but its FMU has {}",
                component.name,
                connector.name,
                all.len()
            );
            let one = |name: &&str| Connector {
                name: (*name).into(),
                dimensions: Vec::new(),
                ..connector.clone()
            };
            component.connectors.extend(all.iter().map(one));
            let all = all.iter().map(|name| (*name).to_string()).collect();
            arrays.insert((component.name.clone(), connector.name), all);
        }
    }
    let elements_of = |end: &End| {
        let each = |name: &String| (end.0.clone(), name.clone());
        let found = arrays.get(end);
        found.map_or(vec![end.clone()], |all| all.iter().map(each).collect())
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
    let mut places = HashMap::new();
    for input in std::mem::take(&mut structure.inputs) {
        for (end, way) in &input.ends {
            for one in elements_of(end) {
                let name = input.name.clone() + one.1.strip_prefix(&end.1).unwrap_or_default();
                structure.feed(&mut places, name, input.unit.clone(), (one, way.clone()));
            }
        }
    }
    Ok(())
}
