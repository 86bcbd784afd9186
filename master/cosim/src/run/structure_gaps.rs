//! What a system structure may have forgotten, and what is to be said of that.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use anyhow::{Result, ensure};
use fmi_description::Kind;

use crate::fmu::Fmu;
use crate::run::verdict::Verdict;
use crate::schedule::Schedule;
use crate::structure::system::{Setting, System};
use crate::wiring::Port;

/// Components of an FMU of which inputs that are not mentioned are named; further ones are counted.
const NAMED: usize = 3;

/// What a system structure may have forgotten, as `component.variable`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forgotten {
    /// Connectors that the FMU does not have.
    pub connectors: Vec<String>,
    /// Input connectors that neither a connection nor a parameter value gives, so that they keep
    /// their start values; elements of an array, and members of a structure, are one item.
    pub inputs: Vec<String>,
    /// Inputs of the FMU without a connector: the structure does not use them, and they keep their
    /// start values. Of an FMU with many components the first three are named, the others counted.
    pub unmentioned: Vec<String>,
    /// Bound values that match no variable, with their origin.
    pub values: Vec<String>,
    /// What is odd about connections and FMUs, but does no harm.
    pub remarks: Vec<String>,
}

impl System {
    /// What the structure may have forgotten, under the start values `settings`.
    pub fn forgotten(&self, settings: &[Setting]) -> Result<Forgotten> {
        let wiring = self.wiring()?;
        let mut remarks = self.structure.remarks.clone();
        remarks.extend(wiring.remarks.iter().cloned());
        for (k, fmu) in self.fmus.iter().enumerate() {
            if self.fmus[..k].iter().all(|other| !Arc::ptr_eq(other, fmu)) {
                let own = fmu.remarks.iter();
                remarks.extend(own.map(|r| format!("FMU `{}`: {r}", fmu.file)));
            }
        }
        let mut forgotten = Forgotten {
            values: self.structure.unmatched.clone(),
            remarks,
            ..Forgotten::default()
        };
        // Of how many components an input is not mentioned, and how many are counted only.
        let mut found: BTreeMap<(usize, &str), usize> = BTreeMap::new();
        let mut counted: BTreeMap<usize, (&str, usize)> = BTreeMap::new();
        for (component, (c, fmu)) in self.structure.components.iter().zip(&self.fmus).enumerate() {
            let declared = c.connectors.iter().map(|connector| &connector.name);
            let lacking = declared.filter(|name| fmu.description.index(name).is_none());
            let lacking = lacking.map(|name| format!("{}.{name}", c.name));
            forgotten.connectors.extend(lacking);
            let is_same = |other: &Arc<Fmu>| Arc::ptr_eq(other, fmu);
            let kind = self.fmus.iter().position(is_same).unwrap_or(component);
            let (mut seen, mut is_counted) = (BTreeSet::new(), false);
            for (variable, v) in fmu.description.variables.iter().enumerate() {
                let port = Port {
                    component,
                    variable,
                };
                let is_given = wiring.driver(port).is_some()
                    || c.parameters.iter().any(|p| p.name == v.name)
                    || settings.iter().any(|s| s.port == port);
                let group = v.name.split(['[', '.']).next().unwrap_or(&v.name);
                let is_declared = c.connectors.iter().any(|c| c.name == v.name);
                let is_known = !v.is_input() || v.kind == Kind::Clock || is_given;
                if is_known || !seen.insert((group, is_declared)) {
                    continue;
                }
                let name = format!("{}.{group}", c.name);
                if is_declared {
                    forgotten.inputs.push(name);
                    continue;
                }
                let copies = found.entry((kind, group)).or_insert(0);
                *copies += 1;
                match *copies <= NAMED {
                    true => forgotten.unmentioned.push(name),
                    false => is_counted = true,
                }
            }
            counted.entry(kind).or_insert((&fmu.file, 0)).1 += usize::from(is_counted);
        }
        for (file, count) in counted.into_values().filter(|(_, count)| *count > 0) {
            let more = format!("and those of {count} more components of `{file}`");
            forgotten.unmentioned.push(more);
        }
        Ok(forgotten)
    }
}

impl Forgotten {
    /// What is to be said of it in a run by this schedule.
    ///
    /// # Errors
    /// Where the judge `is_strict`, anything forgotten; inputs that the system does not mention are
    /// only told of.
    pub fn judge(&self, system: &System, schedule: Schedule, is_strict: bool) -> Result<Verdict> {
        let mut verdict = Verdict::default();
        let tell = |verdict: &mut Verdict, what: &str, names: &[String], is_bad| {
            let text = format!("{what}: {}", names.join(", "));
            match (names.is_empty(), is_bad) {
                (true, _) => {}
                (false, true) => verdict.object(text),
                (false, false) => verdict.note(text),
            }
        };
        let what = "connectors that the FMUs do not have";
        tell(&mut verdict, what, &self.connectors, true);
        let what = "inputs that nothing drives or sets keep their start values";
        tell(&mut verdict, what, &self.inputs, false);
        let what = "bound values that match no variable are passed over";
        tell(&mut verdict, what, &self.values, false);
        if is_strict {
            let texts: Vec<_> = verdict.findings().iter().map(|f| f.text.as_str()).collect();
            ensure!(texts.is_empty(), "--strict: {}", texts.join("; "));
        }
        let read_once = match schedule {
            Schedule::Standard => Vec::new(),
            _ => system.read_once()?,
        };
        let what = "outputs that do not declare on which inputs they depend are read right after the step, so that what goes through them \
             arrives one step later (--feedthrough COMPONENT, where they may be read again)";
        tell(&mut verdict, what, &read_once, false);
        for remark in &self.remarks {
            verdict.note(remark.clone());
        }
        let what = "inputs that the system does not mention keep their start values";
        tell(&mut verdict, what, &self.unmentioned, false);
        Ok(verdict)
    }
}
