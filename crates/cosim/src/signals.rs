//! Signals chosen by name patterns, read in one call per component and written as CSV.

use std::collections::BTreeMap;
use std::io::Write;

use anyhow::{Context, Result, bail};

use crate::description::{Kind, Variable};
use crate::exchange::{Read, reads};
use crate::master::Master;
use crate::slave::At;
use crate::system::System;
use crate::wiring::Port;

/// Chosen signals, with their present values.
pub struct Signals {
    /// Column titles: `component.variable [unit]`.
    pub titles: Vec<String>,
    /// Present values in the order of the titles.
    pub values: Vec<f64>,
    reads: Vec<Read>,
    /// Slot of each title among the raw values.
    order: Vec<usize>,
    raw: Vec<f64>,
    discrete: Vec<(usize, usize, Variable)>,
}

impl Signals {
    /// All outputs whose `component.variable` matches one of `patterns` (`*` stands for any text); inputs and local variables where a
    /// pattern names them without the wildcard in the variable's first letter. No pattern: all outputs.
    pub fn choose(system: &System, patterns: &[String]) -> Result<Self> {
        let mut chosen = Vec::new();
        let mut matched = vec![false; patterns.len()];
        for (component, (c, fmu)) in system
            .structure
            .components
            .iter()
            .zip(&system.fmus)
            .enumerate()
        {
            for (variable, v) in fmu.description.variables.iter().enumerate() {
                if v.kind == Kind::String
                    || matches!(
                        v.causality.as_str(),
                        "parameter" | "calculatedParameter" | "independent"
                    )
                {
                    continue;
                }
                let name = format!("{}.{}", c.name, v.name);
                let mut taken = patterns.is_empty() && v.causality == "output";
                for (pattern, matched) in patterns.iter().zip(&mut matched) {
                    if matches_pattern(pattern, &name)
                        && (v.causality == "output" || !pattern.ends_with(".*"))
                    {
                        (*matched, taken) = (true, true);
                    }
                }
                if taken {
                    chosen.push(Port {
                        component,
                        variable,
                    });
                }
            }
        }
        if let Some((pattern, _)) = patterns
            .iter()
            .zip(&matched)
            .find(|(_, matched)| !**matched)
        {
            bail!(
                "no signal matches `{pattern}`; signals are named component.variable, `*` stands for any text"
            );
        }
        Self::new(system, &chosen)
    }

    fn new(system: &System, chosen: &[Port]) -> Result<Self> {
        let wiring = system.wiring()?;
        let variable = |p: &Port| &wiring.description(p.component).variables[p.variable];
        let is_real = |p: &&Port| variable(p).kind == Kind::Real;
        let mut slots = BTreeMap::new();
        let reads = reads(&wiring, chosen.iter().filter(is_real).copied(), &mut slots);
        let mut discrete = Vec::new();
        for p in chosen.iter().filter(|p| !is_real(p)) {
            let slot = slots.len();
            slots.insert(*p, slot);
            discrete.push((p.component, slot, variable(p).clone()));
        }
        let title = |p: &Port| {
            let unit = variable(p).unit.as_deref().unwrap_or("1");
            format!("{} [{unit}]", wiring.name(*p))
        };
        Ok(Self {
            titles: chosen.iter().map(title).collect(),
            values: vec![0.0; chosen.len()],
            reads,
            order: chosen.iter().map(|p| slots[p]).collect(),
            raw: vec![0.0; slots.len()],
            discrete,
        })
    }

    /// Read the present values.
    pub fn read(&mut self, master: &Master) -> Result<()> {
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
        Ok(())
    }
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
pub(crate) fn matches_pattern(pattern: &str, name: &str) -> bool {
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
