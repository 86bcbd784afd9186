//! Joins connections that lead through connectors of nested systems into connections between
//! components, as the last part of `flatten`.

use std::collections::{HashMap, HashSet};

use anyhow::{Result, bail, ensure};
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
    components: HashSet<String>,
}

impl<'a> Network<'a> {
    fn is_component(&self, key: &Key) -> bool {
        self.components.contains(&key.0)
    }

    /// The chain of connections that ends with this one, from its source on.
    fn way(&self, to: &'a Connection) -> Result<Vec<&'a Connection>> {
        let (mut way, mut last) = (vec![to], to);
        while !self.is_component(&last.start)
            && let Some(before) = self.drivers.get(&last.start)
        {
            if way.len() > self.drivers.len() {
                let (owner, name) = &to.end;
                bail!("the connections through {owner}.{name} lead round in a circle");
            }
            way.push(*before);
            last = before;
        }
        way.reverse();
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
    let mut fed: HashMap<String, Vec<(&Key, Vec<Hop>)>> = HashMap::new();
    let mut inputs: HashMap<String, usize> = HashMap::new();
    for part in parts.iter().filter(|part| network.is_component(&part.end)) {
        let way = network.way(part)?;
        for (k, inner) in way.iter().enumerate() {
            if !network.is_component(&inner.start) {
                let (owner, connector) = &inner.start;
                let ends = fed.entry(join(owner, connector)).or_default();
                ends.push((&part.end, hops(&way[k..])));
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
            ensure!(
                !part.is_term,
                "{}: a sum is of outputs of components, not of inputs of the system",
                part.place
            );
            let (name, end) = (first.start.1.clone(), (part.end.clone(), hops(&way)));
            structure.feed(&mut inputs, name, first.unit.clone(), end);
        }
    }
    for connector in &outermost.connectors {
        let Some(last) = network
            .drivers
            .get(&(String::new(), connector.name.clone()))
        else {
            continue;
        };
        if let Some(first) = network.way(last)?.first()
            && network.is_component(&first.start)
        {
            structure.outputs.push(OuterOutput {
                name: connector.name.clone(),
                start: first.start.clone(),
            });
        }
    }
    let components = structure.components.iter().enumerate().rev();
    let components: HashMap<_, _> = components.map(|(k, c)| (c.name.clone(), k)).collect();
    for value in values {
        let dots = value.name.match_indices('.');
        let own = dots.filter_map(|(at, _)| {
            let component = components.get(&value.name[..at])?;
            Some((*component, value.name[at + 1..].to_string(), Vec::new()))
        });
        let given = fed.get(&value.name).into_iter().flatten();
        let given = given.filter_map(|((component, name), hops)| {
            Some((*components.get(component)?, name.clone(), hops.clone()))
        });
        let all: Vec<_> = own.chain(given).collect();
        if all.is_empty() {
            let text = format!("`{}` ({})", value.name, value.origin);
            structure.unmatched.push(text);
        }
        for (component, name, hops) in all {
            let mut parameter = Parameter {
                name,
                ..value.clone()
            };
            parameter.way.extend(hops);
            structure.components[component].parameters.push(parameter);
        }
    }
    Ok(())
}
