//! Variables of a running system read and set by handle, one call per component; names chosen by patterns; values written as CSV.

use std::collections::BTreeMap;
use std::io::Write;

use crate::exchange::{self, Read, reads, writes};
use crate::master::Master;
use crate::slave::At;
use crate::system::System;
use crate::wiring::Port;
use anyhow::{Context, Result, bail};
use fmu_description::{Causality, Kind, Variable};

/// Variables that are read together.
pub struct Signals {
    ports: Vec<Port>,
    values: Vec<f64>,
    reads: Vec<Read>,
    /// Slot of each port among the raw values.
    order: Vec<usize>,
    raw: Vec<f64>,
    discrete: Vec<(usize, usize, Variable)>,
}

impl Signals {
    /// The variables `ports`, of any type but String.
    pub fn new(system: &System, ports: &[Port]) -> Result<Self> {
        let is_real = |p: &&Port| system.variable(**p).kind == Kind::Real;
        let mut slots = BTreeMap::new();
        let reals = ports.iter().filter(is_real).copied();
        let reads = reads(&system.wiring()?, reals, &mut slots);
        let mut discrete = Vec::new();
        for p in ports.iter().filter(|p| !is_real(p)) {
            let slot = slots.len();
            slots.insert(*p, slot);
            discrete.push((p.component, slot, system.variable(*p).clone()));
        }
        Ok(Self {
            ports: ports.to_vec(),
            values: vec![0.0; ports.len()],
            reads,
            order: ports.iter().map(|p| slots[p]).collect(),
            raw: vec![0.0; slots.len()],
            discrete,
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
            read.run(master.slaves(), &mut self.raw, at)?;
        }
        for (component, slot, variable) in &self.discrete {
            self.raw[*slot] = master.slaves()[*component].number(variable, at)?;
        }
        for (value, slot) in self.values.iter_mut().zip(&self.order) {
            *value = self.raw[*slot];
        }
        Ok(&self.values)
    }
}

/// Real inputs that no connection drives and that the caller sets together.
pub struct Inputs {
    writes: Vec<exchange::Write>,
    buffer: Vec<f64>,
}

impl Inputs {
    /// The inputs `ports`.
    pub fn new(system: &System, ports: &[Port]) -> Result<Self> {
        let slots = ports.iter().copied().zip(0..);
        Ok(Self {
            writes: writes(&system.wiring()?, slots),
            buffer: vec![0.0; ports.len()],
        })
    }

    /// Set them at the present time, in the order of the ports.
    pub fn set(&mut self, master: &Master, values: &[f64]) -> Result<()> {
        let at = At::Time(master.time());
        let mut writes = self.writes.iter();
        writes.try_for_each(|w| w.run(master.slaves(), values, &mut self.buffer, at))
    }
}

/// All outputs whose `component.variable` matches one of `patterns` (`*` stands for any text); inputs and local variables where a
/// pattern names them without the wildcard in the variable's first letter. No pattern: all outputs.
///
/// # Errors
/// A pattern that matches nothing.
pub fn matching(system: &System, patterns: &[String]) -> Result<Vec<Port>> {
    let mut chosen = Vec::new();
    let mut matched = vec![false; patterns.len()];
    for (component, fmu) in system.fmus.iter().enumerate() {
        for (variable, v) in fmu.description.variables.iter().enumerate() {
            if v.kind == Kind::String || !(v.is_input() || v.is_computed()) {
                continue;
            }
            let is_output = v.causality == Causality::Output;
            let mut taken = patterns.is_empty() && is_output;
            let port = Port {
                component,
                variable,
            };
            let name = system.name(port);
            for (pattern, matched) in patterns.iter().zip(&mut matched) {
                if matches_pattern(pattern, &name) && (is_output || !pattern.ends_with(".*")) {
                    (*matched, taken) = (true, true);
                }
            }
            if taken {
                chosen.push(port);
            }
        }
    }
    if let Some((pattern, _)) = patterns.iter().zip(&matched).find(|(_, m)| !**m) {
        bail!(
            "no signal matches `{pattern}`; signals are named component.variable, `*` stands for any text"
        );
    }
    Ok(chosen)
}

/// Column titles of variables: `component.variable [unit]`.
pub fn titles(system: &System, ports: &[Port]) -> Vec<String> {
    let unit = |p: Port| system.variable(p).unit.as_deref().unwrap_or("1");
    let title = |p: &Port| format!("{} [{}]", system.name(*p), unit(*p));
    ports.iter().map(title).collect()
}

/// Writes signals as comma-separated values: a header with names and units, then one row per communication point.
pub struct CsvLog<W: Write> {
    out: W,
    row: Vec<u8>,
}

impl<W: Write> CsvLog<W> {
    /// Write the header.
    pub fn new(mut out: W, titles: &[String]) -> Result<Self> {
        write!(out, "time [s]")?;
        for title in titles {
            write!(out, ",{title}")?;
        }
        writeln!(out)?;
        Ok(Self {
            out,
            row: Vec::new(),
        })
    }

    /// Write one row; the numbers are the shortest that read back bit for bit.
    pub fn row(&mut self, time: f64, values: &[f64]) -> Result<()> {
        self.row.clear();
        let mut digits = zmij::Buffer::new();
        self.row.extend_from_slice(digits.format(time).as_bytes());
        for value in values {
            self.row.push(b',');
            self.row.extend_from_slice(digits.format(*value).as_bytes());
        }
        self.row.push(b'\n');
        self.out
            .write_all(&self.row)
            .context("the CSV file cannot be written")
    }

    /// Write what is still in memory.
    pub fn finish(mut self) -> Result<()> {
        self.out.flush().context("the CSV file cannot be written")
    }
}

/// True where `name` is `pattern` with each `*` replaced by some text.
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

    #[test]
    fn rows_read_back_bit_for_bit() {
        let mut bytes = Vec::new();
        let values = [1.0 / 3.0, -1e-300, 6.02e23, 0.0];
        let mut log = CsvLog::new(&mut bytes, &["a.x [m]".into(), "a.y [N]".into()]).unwrap();
        log.row(0.001, &values).unwrap();
        log.finish().unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("time [s],a.x [m],a.y [N]"));
        let back: Vec<f64> = lines
            .next()
            .unwrap()
            .split(',')
            .map(|v| v.parse().unwrap())
            .collect();
        assert_eq!(back[1..], values);
        assert_eq!(back[0], 0.001);
    }
}
