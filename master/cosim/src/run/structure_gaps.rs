//! Finds gaps in a system structure: connectors that an FMU does not have, inputs that nothing
//! drives or sets, values that match no variable. They become findings of a run's verdict, also in
//! pages, or errors with `--strict`; `cosim wiring` lists them.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use anyhow::{Result, ensure};
use fmi_description::Kind;
use fmi_import::is_triggered;

use crate::fmu::Fmu;
use crate::run::verdict::Verdict;
use crate::schedule::Schedule;
use crate::structure::system::System;
use crate::wiring::Port;

/// Of an FMU with more components than this, unmentioned inputs of the others are only counted.
const NAMED: usize = 3;

/// Gaps of a system structure, as `component.variable`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StructureGaps {
    /// Connectors that the FMU does not have.
    pub missing_connectors: Vec<String>,
    /// Input connectors that get no value from a connection or a parameter and keep their start
    /// values; the elements of an array, or members of a structure, are one item.
    pub undriven_inputs: Vec<String>,
    /// Inputs of the FMU without a connector, which keep their start values. Of an FMU with many
    /// components the first three are named, the others counted.
    pub unmentioned_inputs: Vec<String>,
    /// Parameter values that match no variable, with their origin.
    pub unmatched_values: Vec<String>,
    /// Harmless oddities of connections and FMUs.
    pub remarks: Vec<String>,
}

impl System {
    /// The gaps of the structure in a run that itself gives values to the variables `given`.
    pub fn find_gaps(&self, given: &BTreeSet<Port>) -> Result<StructureGaps> {
        let wiring = self.wiring()?;
        let mut remarks = self.structure.remarks.clone();
        remarks.extend(wiring.remarks.iter().cloned());
        // The first component of each FMU.
        let mut kinds: HashMap<*const Fmu, usize> = HashMap::new();
        for (k, fmu) in self.fmus.iter().enumerate() {
            if *kinds.entry(Arc::as_ptr(fmu)).or_insert(k) == k {
                let own = fmu.remarks.iter();
                remarks.extend(own.map(|r| format!("FMU `{}`: {r}", fmu.file)));
            }
        }
        let mut gaps = StructureGaps {
            unmatched_values: self.structure.unmatched.clone(),
            remarks,
            ..StructureGaps::default()
        };
        // By FMU: components that do not mention an input, and those that are only counted.
        let mut found: BTreeMap<(usize, &str), usize> = BTreeMap::new();
        let mut counted: BTreeMap<usize, (&str, usize)> = BTreeMap::new();
        for (component, (c, fmu)) in self.structure.components.iter().zip(&self.fmus).enumerate() {
            let declared = c.connectors.iter().map(|connector| &connector.name);
            let lacking = declared.filter(|name| fmu.description.index(name).is_none());
            let lacking = lacking.map(|name| format!("{}.{name}", c.name));
            gaps.missing_connectors.extend(lacking);
            let declared: HashSet<&String> = c.connectors.iter().map(|c| &c.name).collect();
            let bound: HashSet<&String> = c.parameters.iter().map(|p| &p.name).collect();
            let kind = kinds[&Arc::as_ptr(fmu)];
            let (mut seen, mut is_counted) = (BTreeSet::new(), false);
            let inputs = fmu.description.variables.iter().enumerate();
            for (variable, v) in inputs.filter(|(_, v)| v.is_input()) {
                let port = Port::new(component, variable);
                if is_triggered(v) && wiring.clocks.iter().all(|[_, to]| *to != port) {
                    let remark =
                        "is triggered from outside, which no connection does: it never ticks";
                    let remark = format!("{}: its clock `{}` {remark}", c.name, v.name);
                    gaps.remarks.push(remark);
                }
                let is_given = wiring.driver(port).is_some()
                    || bound.contains(&v.name)
                    || given.contains(&port);
                let group = v.name.split(['[', '.']).next().unwrap_or(&v.name);
                let is_declared = declared.contains(&v.name);
                let is_known = v.kind == Kind::Clock || is_given;
                if is_known || !seen.insert((group, is_declared)) {
                    continue;
                }
                let name = format!("{}.{group}", c.name);
                if is_declared {
                    gaps.undriven_inputs.push(name);
                    continue;
                }
                let copies = found.entry((kind, group)).or_insert(0);
                *copies += 1;
                match *copies <= NAMED {
                    true => gaps.unmentioned_inputs.push(name),
                    false => is_counted = true,
                }
            }
            counted.entry(kind).or_insert((&fmu.file, 0)).1 += usize::from(is_counted);
        }
        for (file, count) in counted.into_values().filter(|(_, count)| *count > 0) {
            let more = format!("and those of {count} more components of `{file}`");
            gaps.unmentioned_inputs.push(more);
        }
        Ok(gaps)
    }
}

impl StructureGaps {
    /// The gaps as findings on a run with this schedule. If `is_strict`, any gap is an error,
    /// except unmentioned inputs of a system that declares connectors.
    pub fn judge(&self, system: &System, schedule: Schedule, is_strict: bool) -> Result<Verdict> {
        let mut verdict = Verdict::default();
        let note = |verdict: &mut Verdict, what: &str, names: &[String]| {
            if !names.is_empty() {
                verdict.note(format!("{what}: {}", names.join(", ")));
            }
        };
        if !self.missing_connectors.is_empty() {
            let names = self.missing_connectors.join(", ");
            verdict.object(format!("connectors that the FMUs do not have: {names}"));
        }
        let what = "inputs that nothing drives or sets keep their start values";
        note(&mut verdict, what, &self.undriven_inputs);
        let what = "parameter values that match no variable are ignored";
        note(&mut verdict, what, &self.unmatched_values);
        let mut components = system.structure.components.iter();
        // Connectors that the structure declares have a line in its file.
        let is_bare = components.all(|c| c.connectors.iter().all(|c| c.line == 0));
        if is_strict && is_bare {
            note(
                &mut verdict,
                "inputs that nothing drives or sets",
                &self.unmentioned_inputs,
            );
        }
        if is_strict {
            let texts: Vec<_> = verdict.findings().iter().map(|f| f.text.as_str()).collect();
            ensure!(texts.is_empty(), "--strict: {}", texts.join("; "));
        }
        if schedule != Schedule::Standard {
            let what = "outputs that do not declare on which inputs they depend are read right after the step, so that what goes through them \
                 arrives one step later (--feedthrough COMPONENT, where they may be read again)";
            note(&mut verdict, what, &system.read_once(true)?);
            let what = "outputs of FMUs of FMI 3.0 without Event Mode are read right after the step, so that what goes through them arrives one step \
                 later";
            note(&mut verdict, what, &system.read_once(false)?);
        }
        (self.remarks.iter()).for_each(|remark| verdict.note(remark.clone()));
        let what = "inputs that the system does not mention keep their start values";
        note(&mut verdict, what, &self.unmentioned_inputs);
        Ok(verdict)
    }
}
