//! Reads and sets variables of a running system together, and finds variables by patterns of their
//! names, for logs, recordings, studies, Python and pages.

use std::collections::BTreeMap;

use crate::exchange::{Read, Write, reads, writes};
use crate::instance::At;
use crate::master::Master;
use crate::structure::system::System;
use crate::wiring::Port;
use crate::wiring::transformation::Transformation;
use anyhow::{Result, bail};
use fmi_description::{Access, Causality};

/// Variables that are read together.
#[derive(Clone, Debug)]
pub struct Signals {
    ports: Vec<Port>,
    values: Vec<f64>,
    reads: Vec<Read>,
    /// Slot of each port among the raw values.
    order: Vec<usize>,
    raw: Vec<f64>,
}

impl Signals {
    /// The variables `ports`, of any type but String.
    pub fn new(system: &System, ports: &[Port]) -> Result<Self> {
        let is_no_number = |p: &&Port| !system.variable(**p).access().is_number();
        if let Some(port) = ports.iter().find(is_no_number) {
            bail!("`{}` is not a number", system.name(*port));
        }
        let mut slots = BTreeMap::new();
        let reads = reads(&system.wiring()?, ports.iter().copied(), &mut slots);
        Ok(Self {
            ports: ports.to_vec(),
            values: vec![0.0; ports.len()],
            reads,
            order: ports.iter().map(|p| slots[p]).collect(),
            raw: vec![0.0; slots.len()],
        })
    }

    /// The variables.
    pub fn ports(&self) -> &[Port] {
        &self.ports
    }

    /// Their present values, in the order of the ports.
    pub fn read(&mut self, master: &Master) -> Result<&[f64]> {
        let at = At::Time(master.time());
        for read in &self.reads {
            read.run(master.instances(), &mut self.raw, at)?;
        }
        for (value, slot) in self.values.iter_mut().zip(&self.order) {
            *value = self.raw[*slot];
        }
        Ok(&self.values)
    }
}

/// Inputs that are set together; no connection may drive them.
pub struct Inputs {
    writes: Vec<Write>,
}

impl Inputs {
    /// The inputs `ports`.
    pub fn new(system: &System, ports: &[Port]) -> Result<Self> {
        let slots = ports.iter().zip(0..);
        let inputs = slots.map(|(port, slot)| (*port, slot, Transformation::NONE));
        Ok(Self {
            writes: writes(&system.wiring()?, inputs),
        })
    }

    /// Sets them at the present time, in the order of the ports.
    pub fn set(&mut self, master: &Master, values: &[f64]) -> Result<()> {
        let at = At::Time(master.time());
        let mut writes = self.writes.iter_mut();
        writes.try_for_each(|write| write.run(master.instances(), values, None, at))
    }
}

/// The signals that are written if none are named: all outputs that connections pass on, or all
/// outputs if there are no connections; only those that are numbers.
pub fn connected(system: &System) -> Result<Vec<Port>> {
    let mut ports: Vec<Port> = system.wiring()?.links.iter().map(|l| l.from).collect();
    if ports.is_empty() {
        return matching(system, &["*".into()]);
    }
    ports.retain(|port| system.variable(*port).access().is_number());
    ports.sort();
    ports.dedup();
    Ok(ports)
}

/// All numeric outputs whose `component.variable` matches one of `patterns` (`*` stands for any
/// text); also inputs and local variables, except for the patterns `*` and `component.*`. A pattern
/// that matches nothing is an error.
pub fn matching(system: &System, patterns: &[String]) -> Result<Vec<Port>> {
    matching_access(system, patterns, Access::is_number)
}

/// As [`matching`], with strings and binary values.
pub fn matching_any(system: &System, patterns: &[String]) -> Result<Vec<Port>> {
    matching_access(system, patterns, |access| access != Access::Clock)
}

fn matching_access(
    system: &System,
    patterns: &[String],
    is_wanted: impl Fn(Access) -> bool,
) -> Result<Vec<Port>> {
    let mut ports = Vec::new();
    let mut matched = vec![false; patterns.len()];
    for (component, fmu) in system.fmus.iter().enumerate() {
        for (variable, v) in fmu.description.variables.iter().enumerate() {
            if !is_wanted(v.access()) || !(v.is_input() || v.is_computed()) {
                continue;
            }
            let is_output = v.causality == Causality::Output;
            let port = Port {
                component,
                variable,
            };
            let (name, mut is_matched) = (system.name(port), false);
            for (pattern, matched) in patterns.iter().zip(&mut matched) {
                let names_variable = pattern != "*" && !pattern.ends_with(".*");
                if matches_pattern(pattern, &name) && (is_output || names_variable) {
                    (*matched, is_matched) = (true, true);
                }
            }
            ports.extend(is_matched.then_some(port));
        }
    }
    if let Some((pattern, _)) = patterns.iter().zip(&matched).find(|(_, m)| !**m) {
        bail!(
            "no signal matches `{pattern}`; signals are named component.variable, `*` stands for any text"
        );
    }
    Ok(ports)
}

/// True if `name` is `pattern` with each `*` replaced by some text.
pub fn matches_pattern(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        let Some(at) = rest.find(part) else {
            return false;
        };
        rest = &rest[at + part.len()..];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_as_a_shell_would() {
        for (pattern, name, expected) in [
            ("hdrm.x[1]", "hdrm.x[1]", true),
            ("hdrm.x[1]", "hdrm.x[12]", false),
            ("hdrm.*", "hdrm.x[1]", true),
            ("*.F", "emla_1.F", true),
            ("*.F", "emla_1.F_mean", false),
            ("emla_*.i_*", "emla_2.i_q", true),
            ("emla_*.i_*", "hdrm.i_q", false),
            ("*a*a", "a", false),
        ] {
            assert_eq!(matches_pattern(pattern, name), expected, "{pattern} {name}");
        }
    }
}
