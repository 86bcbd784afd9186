//! Joins connections that lead through connectors of nested systems into connections between
//! components, as the last part of `flatten`.

use std::collections::HashMap;

use anyhow::{Result, bail};
use system_structure::System;

use super::flat::{Connection, Hop, OuterOutput, Parameter, Structure};

/// A connector: the path of the element that owns it, and its name. Signals of dictionaries have a
/// path that no element has.
pub(super) type Key = (String, String);

/// The path of the element `name` in the system with the path `path`.
pub(super) fn join(path: &str, name: &str) -> String {
    match path.is_empty() {
        true => name.to_string(),
        false => format!("{path}.{name}"),
    }
}

/// The connections of all systems, by the connector that they lead to.
struct Network<'a> {
    drivers: HashMap<&'a Key, &'a Connection>,
    components: Vec<String>,
}

impl<'a> Network<'a> {
    fn is_component(&self, key: &Key) -> bool {
        self.components.contains(&key.0)
    }

    /// The chain of connections that leads to a connector, from its source on.
    fn way(&self, to: &Key) -> Result<Vec<&'a Connection>> {
        let (mut way, mut key) = (Vec::new(), to);
        while let Some(last) = self.drivers.get(key) {
            if way.len() > self.drivers.len() {
                bail!(
                    "the connections through {}.{} lead round in a circle",
                    to.0,
                    to.1
                );
            }
            way.insert(0, *last);
            key = &last.start;
            if self.is_component(key) {
                break;
            }
        }
        Ok(way)
    }
}

fn hops(way: &[&Connection]) -> Vec<Hop> {
    way.iter().flat_map(|part| part.way.clone()).collect()
}

/// Give a structure its connections, its inputs and outputs, and the values of its variables.
pub(super) fn resolve(
    structure: &mut Structure,
    parts: &[Connection],
    values: Vec<Parameter>,
    outermost: &System,
) -> Result<()> {
    let names = structure.components.iter().map(|c| c.name.clone());
    let network = Network {
        drivers: parts.iter().map(|part| (&part.end, part)).collect(),
        components: names.collect(),
    };
    // A value for a connector of a system is passed on to the components that the connector feeds.
    let mut fed: Vec<(&Key, String, Vec<Hop>)> = Vec::new();
    for part in parts.iter().filter(|part| network.is_component(&part.end)) {
        let way = network.way(&part.end)?;
        for (k, inner) in way.iter().enumerate() {
            if !network.is_component(&inner.start) {
                let (owner, connector) = &inner.start;
                fed.push((&part.end, join(owner, connector), hops(&way[k..])));
            }
        }
        let Some(first) = way.first() else { continue };
        if network.is_component(&first.start) {
            structure.connections.push(Connection {
                start: first.start.clone(),
                unit: first.unit.clone(),
                way: hops(&way),
                is_initial: way.iter().any(|part| part.is_initial),
                bond: way.iter().find_map(|part| part.bond.clone()),
                ..part.clone()
            });
        } else if first.start.0.is_empty() {
            let (name, end) = (first.start.1.clone(), (part.end.clone(), hops(&way)));
            structure.feed(name, first.unit.clone(), end);
        }
    }
    for connector in &outermost.connectors {
        let way = network.way(&(String::new(), connector.name.clone()))?;
        if let Some(first) = way.first()
            && network.is_component(&first.start)
        {
            structure.outputs.push(OuterOutput {
                name: connector.name.clone(),
                start: first.start.clone(),
            });
        }
    }
    for value in values {
        let mut is_matched = false;
        for component in &mut structure.components {
            let variable = value.name.strip_prefix(&component.name);
            let own = variable.and_then(|rest| rest.strip_prefix('.'));
            let own = own.map(|name| (name, Vec::new()));
            let given = fed
                .iter()
                .filter(|(end, name, _)| end.0 == component.name && *name == value.name);
            let given = given.map(|(end, _, hops)| (end.1.as_str(), hops.clone()));
            for (name, hops) in own.into_iter().chain(given) {
                let mut parameter = Parameter {
                    name: name.to_string(),
                    ..value.clone()
                };
                parameter.way.extend(hops);
                component.parameters.push(parameter);
                is_matched = true;
            }
        }
        if !is_matched {
            let text = format!("`{}` ({})", value.name, value.origin);
            structure.unmatched.push(text);
        }
    }
    Ok(())
}
