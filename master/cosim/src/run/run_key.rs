//! The key of a run: all that its numbers depend on, by name and by content. Snapshots, the stores
//! of the studies and the sweeps of the Python package reuse results only where it is the same.
//!
//! Structure and experiment are taken apart field by field, so that a new field does not compile
//! before it is decided whether numbers depend on it; parts of theirs count whole.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::env::consts;
use std::fmt::Debug;
use std::path::Path;

use fmi_description::{Interface, Kind, Variable};
use serde::{Deserialize, Serialize};
use system_structure::Connector;

use crate::exchange::faults::Faults;
use crate::io::digest::{sha256, sha256_of_file};
use crate::run::experiment::Experiment;
use crate::schedule::Stepping;
use crate::structure::system::{Setting, System, method_name};
use crate::structure::{Connection, Structure};

/// Name of the part that a resumed run may have otherwise: it may go on for longer.
pub(crate) const STOP_TIME: &str = "the stop time";
/// Differences that a message lists, and characters of a value in it.
const LISTED: usize = 4;
const SHOWN: usize = 60;

/// What the numbers of a run depend on: names, and values or their hashes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunKey {
    parts: BTreeMap<String, String>,
}

impl RunKey {
    /// The key of `experiment` on `system`. Where files are and how many threads share the work
    /// makes no difference; a start value that names a file counts by the file's content.
    pub fn new(system: &System, experiment: &Experiment) -> Self {
        let mut key = Self {
            parts: BTreeMap::new(),
        };
        let version = env!("CARGO_PKG_VERSION");
        let version = format!("{version} ({} {})", consts::OS, consts::ARCH);
        key.add("the version of cosim", version);
        let structure = &system.structure;
        key.add_structure(structure);
        key.add_start_values(system, &experiment.settings);
        let Experiment {
            stepping,
            threads: _,
            stop,
            settings: _, // added above
            faults,
            inputs,
            tolerance,
            nonfinite,
        } = experiment;
        let Stepping {
            start,
            step,
            schedule,
            between,
            jitter,
            repeats: _, // from the choice of steps
        } = stepping;
        key.add("the start time", format!("{start} s"));
        key.add("the communication step", format!("{step} s"));
        key.add("the schedule", format!("{schedule:?}"));
        key.add("the option --between", format!("{between:?}"));
        key.add("the jitter", format!("{jitter:?}"));
        key.add("the tolerance", format!("{tolerance:?}"));
        let nonfinite: Vec<String> = nonfinite.iter().map(|port| system.name(*port)).collect();
        key.add("the variables that may be not finite", nonfinite.join(", "));
        let stop = stop.or(structure.stop_time);
        let stop = stop.map_or("not given".into(), |stop| format!("{stop} s"));
        key.add(STOP_TIME, stop);
        key.add_faults(system, faults);
        for column in inputs.iter().flat_map(|table| &table.columns) {
            let times = inputs.as_ref().map(|table| &table.times);
            key.add_hash(format!("the input `{}`", column.name), &(column, times));
        }
        key
    }

    /// Adds what else the numbers depend on, such as an option of a study.
    pub fn add(&mut self, name: impl Into<String>, value: impl Into<String>) {
        self.parts.insert(name.into(), value.into());
    }

    /// A hash of all parts.
    pub fn digest(&self) -> String {
        sha256(format!("{:?}", self.parts).as_bytes())
    }

    /// How the run of `self` differs from that of `other`, which is called `there`, apart from the
    /// part `except`; None if it does not.
    pub fn difference(&self, other: &Self, there: &str, except: &str) -> Option<String> {
        let names = self.parts.keys().chain(other.parts.keys());
        let mut names: Vec<&String> = names.filter(|name| *name != except).collect();
        names.sort();
        names.dedup();
        names.retain(|name| self.parts.get(*name) != other.parts.get(*name));
        let shown = |key: &Self, name: &str| match key.parts.get(name) {
            Some(value) if value.chars().count() > SHOWN => {
                format!("{}...", value.chars().take(SHOWN).collect::<String>())
            }
            Some(value) => value.clone(),
            None => "not given".into(),
        };
        let line = |name: &&String| {
            let (own, others) = (shown(self, name), shown(other, name));
            format!("{name} is {others} {there} and {own} here")
        };
        let mut lines: Vec<String> = names.iter().take(LISTED).map(line).collect();
        if let Some(more @ 1..) = names.len().checked_sub(LISTED) {
            lines.push(format!("and {more} more"));
        }
        (!lines.is_empty()).then(|| lines.join("; "))
    }

    fn add_structure(&mut self, structure: &Structure) {
        let Structure {
            name: _,
            components,
            connections,
            inputs,
            outputs: _,
            start_time: _, // in the experiment's stepping
            has_start: _,
            stop_time: _, // in the stop time
            step: _,      // in the experiment's stepping
            feedthrough,
            rates,
            interfaces: _, // in the FMUs
            isolated: _,   // the same bits
            limits: _,
            prefers_wasm,
            solves_loops,
            alarms: _, // they judge the numbers, and change none
            remarks: _,
            unmatched: _,
        } = structure;
        if *prefers_wasm {
            self.add("binaries", "WebAssembly");
        }
        let names: Vec<&str> = components.iter().map(|c| c.name.as_str()).collect();
        self.add("the order of components", names.join(", "));
        for component in components {
            let moved = |c: &Connector| {
                format!(
                    "{:?}",
                    Connector {
                        line: 0,
                        ..c.clone()
                    }
                )
            };
            let mut declared: Vec<String> = component.connectors.iter().map(moved).collect();
            declared.sort();
            let name = format!("the list of connectors of `{}`", component.name);
            self.add_hash(name, &declared);
        }
        let mut order = Vec::new();
        for connection in connections {
            let ((component, output), (owner, input)) = (&connection.start, &connection.end);
            let place = String::new();
            let moved = Connection {
                place,
                ..connection.clone()
            };
            let source = format!("{component}.{output} ({})", hash(&moved));
            self.add(format!("the source of `{owner}.{input}`"), source);
            order.push((owner, input));
        }
        self.add_hash("the order of connections".into(), &order);
        self.add_hash("the list of inputs of the system".into(), inputs);
        let mut feedthrough: Vec<&str> = feedthrough.iter().map(String::as_str).collect();
        feedthrough.sort_unstable();
        feedthrough.dedup();
        self.add("the list of --feedthrough", feedthrough.join(", "));
        for (component, step) in rates {
            self.add(format!("the step of `{component}`"), format!("{step} s"));
        }
        self.add("the option --solve-loops", solves_loops.to_string());
    }

    /// The FMUs, and the start values of the structure, of parameter sets and of `settings`: of
    /// each variable the last one counts.
    fn add_start_values(&mut self, system: &System, settings: &[Setting]) {
        let structure = &system.structure;
        for (k, (component, fmu)) in structure.components.iter().zip(&system.fmus).enumerate() {
            let name = &component.name;
            let digest = format!("sha256 {}", short(&fmu.sha256));
            self.add(format!("the FMU of `{name}`"), digest);
            let description = &fmu.description;
            if description.interface == Interface::ModelExchange {
                self.add(format!("the interface of `{name}`"), "Model Exchange");
                if let Some(method) = fmu.method().map(method_name) {
                    self.add(format!("the solver of `{name}`"), method);
                }
            }
            // Their values have the types and units of the variables.
            let bound = component.parameters.iter();
            let bound = bound.filter_map(|p| Some((description.index(&p.name)?, &p.value)));
            let own = settings.iter().filter_map(|Setting { port, value }| {
                (port.component == k).then_some((port.variable, value))
            });
            let mut given = BTreeMap::new();
            for (variable, value) in bound.chain(own) {
                let v = &description.variables[variable];
                given.insert(variable, content(v, value));
            }
            // A file that the FMU takes by default may change without the FMU.
            for (variable, v) in description.variables.iter().enumerate() {
                if let (Kind::String, Entry::Vacant(entry)) = (&v.kind, given.entry(variable))
                    && let Some(value) = v.start_of(0).and_then(file)
                {
                    entry.insert(value);
                }
            }
            for (variable, value) in given {
                let variable = &description.variables[variable].name;
                self.add(format!("the start value of `{name}.{variable}`"), value);
            }
        }
    }

    fn add_faults(&mut self, system: &System, faults: &Faults) {
        let Faults { list, seed } = faults;
        if list.is_empty() {
            return;
        }
        self.add("the seed of faults", seed.to_string());
        let described = list.iter().map(|f| {
            let kind = if f.is_event { "event" } else { "fault" };
            let (name, effect) = (system.name(f.port), f.effect);
            format!(
                "{kind} of {name}: {effect:?} from {} s until {} s",
                f.from, f.until
            )
        });
        self.add("the list of faults", Vec::from_iter(described).join(", "));
    }

    fn add_hash(&mut self, name: String, value: &impl Debug) {
        self.add(name, format!("sha256 {}", hash(value)));
    }
}

/// A hash of a value. The shortest digits of its numbers tell them all apart.
fn hash(value: &impl Debug) -> String {
    short(&sha256(format!("{value:?}").as_bytes())).to_string()
}

/// As many digits of a hash as no two values share by chance.
fn short(digest: &str) -> &str {
    &digest[..32]
}

/// A start value: a Real in one notation, a text that names a file by its content.
fn content(variable: &Variable, value: &str) -> String {
    let value = value.trim();
    match (&variable.kind, value.parse::<f64>()) {
        (Kind::Real, Ok(number)) => number.to_string(),
        (Kind::String, _) => file(value).unwrap_or_else(|| format!("`{value}`")),
        _ => value.into(),
    }
}

/// The content of the file that a value names, if it names one; its extension may say what it is.
fn file(value: &str) -> Option<String> {
    let path = Path::new(value.strip_prefix("file://").unwrap_or(value));
    let digest = sha256_of_file(path)?;
    let kind = path.extension().unwrap_or_default().to_string_lossy();
    Some(format!("a file ({kind}, sha256 {})", short(&digest)))
}
