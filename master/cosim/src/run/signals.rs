//! Reads and sets variables of a running system together, and finds variables by patterns of their
//! names, for logs, recordings, studies, Python and pages.

use std::collections::{BTreeMap, BTreeSet};

use crate::exchange::{Read, Write, reads, writes};
use crate::instance::At;
use crate::master::Master;
use crate::run::verdict::Verdict;
use crate::structure::system::System;
use crate::wiring::Port;
use crate::wiring::transformation::Transformation;
use anyhow::{Result, bail, ensure};
use fmi_description::{Access, Causality, Kind, Variable};

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
            read.run_unchecked(master.instances(), &mut self.raw, at)?;
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
/// outputs if there are no connections; only those that are numbers. Of components without outputs
/// their local variables.
pub fn connected(system: &System) -> Result<Vec<Port>> {
    let mut ports: Vec<Port> = system.wiring()?.links.iter().map(|l| l.from).collect();
    if ports.is_empty() {
        return matching(system, &["*".into()]);
    }
    for k in without_outputs(system) {
        let name = format!("{}.*", system.structure.components[k].name);
        ports.extend(matching(system, &[name]).unwrap_or_default());
    }
    ports.retain(|port| system.variable(*port).access().is_number());
    ports.sort();
    ports.dedup();
    Ok(ports)
}

/// The components whose FMUs have no outputs.
fn without_outputs(system: &System) -> impl Iterator<Item = usize> {
    let has_none = |k: &usize| {
        let mut variables = system.fmus[*k].description.variables.iter();
        variables.all(|v| v.causality != Causality::Output)
    };
    (0..system.fmus.len()).filter(has_none)
}

/// What the user must know of signals that were not named one by one: of which components local
/// variables are among `ports`, because they have no outputs.
pub fn note_locals(system: &System, ports: &[Port], verdict: &mut Verdict) {
    for k in without_outputs(system) {
        let count = ports.iter().filter(|port| port.component == k).count();
        if count > 0 {
            verdict.note(format!(
                "`{}` has no outputs: {count} of its other variables are recorded",
                system.structure.components[k].name
            ));
        }
    }
}

/// All numeric outputs whose `component.variable` matches one of `patterns` (`*` stands for any
/// text), in the order of the patterns; also inputs and local variables, except for the patterns
/// `*` and `component.*`, which mean local variables of components without outputs. A name that
/// [`System::ports`] knows is no pattern. A pattern that matches nothing is an error.
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
    let silent: Vec<usize> = without_outputs(system).collect();
    let is_fit = |v: &Variable| is_wanted(v.access()) && (v.is_input() || v.is_computed());
    let is_shown = |pattern: &str, port: Port| {
        let is_whole = pattern == "*" || pattern.ends_with(".*");
        match system.variable(port).causality {
            Causality::Output => true,
            Causality::Local => !is_whole || silent.contains(&port.component),
            _ => !is_whole,
        }
    };
    meant(system, patterns, "signal", is_fit, is_shown)
}

/// The Real variables that patterns name, of any role: those that may have values that are not
/// finite (`--allow-nonfinite`). The name of an array stands for all its elements.
pub fn matching_real(system: &System, patterns: &[String]) -> Result<Vec<Port>> {
    let is_real = |v: &Variable| v.kind == Kind::Real;
    meant(
        system,
        patterns,
        "variable of type Real",
        is_real,
        |_, _| true,
    )
}

/// The fitting variables that each pattern means: by a name, else all shown ones that match it.
fn meant(
    system: &System,
    patterns: &[String],
    what: &str,
    is_fit: impl Fn(&Variable) -> bool,
    is_shown: impl Fn(&str, Port) -> bool,
) -> Result<Vec<Port>> {
    let (mut ports, mut seen) = (Vec::new(), BTreeSet::new());
    for pattern in patterns {
        let mut found = system.ports(pattern).unwrap_or_default();
        found.retain(|port| is_fit(system.variable(*port)));
        if found.is_empty() {
            found.extend(system.all_ports().filter(|port| {
                let is_wanted = is_fit(system.variable(*port)) && is_shown(pattern, *port);
                is_wanted && matches_pattern(pattern, &system.name(*port))
            }));
        }
        ensure!(
            !found.is_empty(),
            "no {what} matches `{pattern}`; names are component.variable, `*` stands for any text"
        );
        ports.extend(found.into_iter().filter(|port| seen.insert(*port)));
    }
    Ok(ports)
}

/// The names and patterns in lists that are separated by commas. A name may contain commas: the
/// longest name that is known counts, else the shortest pattern that matches something.
pub fn split_lists(system: &System, lists: &[String]) -> Vec<String> {
    let matches = |pattern: &str| {
        let mut all = system.all_ports();
        all.any(|port| matches_pattern(pattern, &system.name(port)))
    };
    let commas = |port| system.name(port).matches(',').count();
    let longest = system.all_ports().map(commas).max().unwrap_or(0) + 1;
    let mut names = Vec::new();
    for list in lists {
        let mut rest = list.as_str();
        loop {
            let ends = rest.match_indices(',').map(|(k, _)| k);
            let ends: Vec<usize> = ends.chain([rest.len()]).take(longest).collect();
            let is_name = |end: &&usize| system.is_known(rest[..**end].trim());
            let is_pattern = |end: &&usize| matches(rest[..**end].trim());
            let name = ends.iter().rev().find(is_name);
            let end = name.or_else(|| ends.iter().find(is_pattern));
            let end = *end.unwrap_or(&ends[0]);
            names.push(rest[..end].trim().to_string());
            match rest.get(end + 1..) {
                Some(more) => rest = more,
                None => break,
            }
        }
    }
    names
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
