//! The system or FMU that a page has opened, with its run; `command` and `exports` call it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};

use cosim::fmu::Fmu;
use cosim::run::experiment::Experiment;
use cosim::schedule::{STEP, Schedule, Stepping};
use cosim::structure::FmuUse;
use cosim::structure::package::{FmuPlace, Package};
use cosim::structure::system::System;
use serde_json::{Map, Value};

use crate::run::Run;

/// Name of the package in messages.
const NAME: &str = "the package";
/// Component name that stands for an FMU opened by itself.
const FMU_NAME: &str = "fmu";
const NO_RUN: &str = "nothing runs yet: start it with `restart`";

/// Settings other than start values.
const STRUCTURE: &str = "structure";
const PARAMETERS: &str = "parameters";
const SCHEDULE: &str = "schedule";
const STEP_SIZE: &str = "step";
const START_TIME: &str = "start_time";
const TOLERANCE: &str = "tolerance";

/// An opened package and its run.
pub struct Engine {
    source: Source,
    run: Option<Run>,
    /// Rows of time and watched values, from the last call that made some.
    pub history: Vec<f64>,
}

/// An opened package.
enum Source {
    /// A packed system, with the structures and FMUs loaded from it, by name.
    Package {
        package: Box<Package>,
        systems: BTreeMap<String, System>,
        fmus: BTreeMap<String, Arc<Fmu>>,
    },
    /// One FMU.
    Fmu(Box<System>),
}

impl Engine {
    /// Open a packed system or an FMU.
    pub fn open(bytes: Vec<u8>) -> Result<Self> {
        let package = Package::from_bytes(NAME, bytes)?;
        let source = if package.holds("modelDescription.xml") {
            let mut bytes = package.into_bytes();
            let read = |_: &str| Ok(std::mem::take(&mut bytes));
            let files = vec![(String::new(), FMU_NAME.to_string())];
            let system = System::from_files(files, &[], &FmuUse::default(), read)?;
            Source::Fmu(Box::new(system))
        } else {
            ensure!(
                package.names().any(|name| name.ends_with(".ssd")),
                "{NAME} holds neither a system structure (.ssd) nor a model description: it is no system and no FMU"
            );
            Source::Package {
                package: Box::new(package),
                systems: BTreeMap::new(),
                fmus: BTreeMap::new(),
            }
        };
        Ok(Self {
            source,
            run: None,
            history: Vec::new(),
        })
    }

    /// Files of the package whose names end with `end`.
    pub fn files(&self, end: &str) -> Vec<&str> {
        match &self.source {
            Source::Package { package, .. } => {
                package.names().filter(|n| n.ends_with(end)).collect()
            }
            Source::Fmu(_) => Vec::new(),
        }
    }

    /// The name of a variable with its component, which may be left out for an FMU opened by
    /// itself.
    pub fn full_name(&self, name: String) -> String {
        let Source::Fmu(system) = &self.source else {
            return name;
        };
        let own = name
            .strip_prefix(FMU_NAME)
            .and_then(|own| own.strip_prefix('.'));
        let own = own.unwrap_or(&name);
        let full = format!("{}.{own}", system.structure.components[0].name);
        let needs_it = system.port(&name).is_err() && system.port(&full).is_ok();
        if needs_it { full } else { name }
    }

    /// The run, if one was started.
    pub fn run(&mut self) -> Result<&mut Run> {
        self.run.as_mut().context(NO_RUN)
    }

    /// The system of a structure, else of the default one, with the values of these parameter sets,
    /// and the sizes of arrays that start values, `name=value`, give.
    fn system(
        &mut self,
        structure: Option<&str>,
        sets: &[String],
        start_values: &[String],
    ) -> Result<System> {
        let (package, systems, fmus) = match &mut self.source {
            Source::Package {
                package,
                systems,
                fmus,
            } => (package, systems, fmus),
            Source::Fmu(system) => {
                ensure!(
                    structure.is_none() && sets.is_empty(),
                    "an FMU by itself has no structures and no parameter sets"
                );
                return system.clone().with_sizes(None, &[], start_values);
            }
        };
        let key = structure.unwrap_or_default().to_string();
        let mut system = match systems.get(&key) {
            Some(system) => system.clone(),
            None => {
                let else_in = Vec::new();
                let place = FmuPlace::Structure { else_in };
                let uses = FmuUse::default();
                let system =
                    System::from_package(package, structure, &place, &[], &[], &uses, fmus)?;
                systems.entry(key).or_insert(system).clone()
            }
        };
        let sets: Vec<PathBuf> = sets.iter().map(PathBuf::from).collect();
        system = system.with_sizes(Some(package), &sets, start_values)?;
        for set in sets {
            system.apply_set_from(package, &set)?;
        }
        Ok(system)
    }

    /// Start a new run. The settings are start values by the names of variables, and `structure`,
    /// `parameters` (names of sets), `schedule`, `step` and `start_time`, s, and the `tolerance`
    /// that FMUs are told. If this fails, the run before goes on.
    pub fn restart(&mut self, settings: &Map<String, Value>) -> Result<()> {
        let word = |key: &str| {
            settings
                .get(key)
                .map(setting_text)
                .filter(|text| !text.is_empty())
        };
        let sets = match settings.get(PARAMETERS) {
            Some(Value::Array(sets)) => sets.iter().map(setting_text).collect(),
            _ => word(PARAMETERS).into_iter().collect::<Vec<_>>(),
        };
        let given = settings.iter().map(|(name, value)| {
            let name = self.full_name(name.clone());
            format!("{name}={}", setting_text(value))
        });
        let given: Vec<String> = given.collect();
        let system = self.system(word(STRUCTURE).as_deref(), &sets, &given)?;
        // A variable of this name counts, of an FMU opened by itself.
        let is_of_run =
            |name: &str| [START_TIME, TOLERANCE].contains(&name) && system.ports(name).is_err();
        let mut start_values = Vec::new();
        for (name, value) in settings {
            let is_other = [STRUCTURE, PARAMETERS, SCHEDULE, STEP_SIZE].contains(&name.as_str());
            if !is_other && !is_of_run(name) {
                let full = self.full_name(name.clone());
                start_values.extend(system.settings(&full, &setting_text(value))?);
            }
        }
        let number = |key: &str, what: &str, fits: fn(f64) -> bool| {
            let number = word(key).filter(|_| is_of_run(key) || key == STEP_SIZE);
            let number = number.map(|text| text.parse().ok().filter(|x: &f64| fits(*x)));
            let number = number.map(|number| number.with_context(|| format!("`{key}`: {what}")));
            number.transpose()
        };
        let start = number(START_TIME, "the start must be a time in s", f64::is_finite)?;
        let start = start.unwrap_or(system.structure.start_time);
        let what = "a relative tolerance must be above 0 and below 1";
        let tolerance = number(TOLERANCE, what, |x| x > 0.0 && x < 1.0)?;
        let what = "the communication step must be a number greater than 0 s";
        let step = number(STEP_SIZE, what, |h| h.is_finite() && h > 0.0)?;
        let stop = system.structure.stop_time;
        let stop = stop.unwrap_or_else(|| system.preferred_stop(start));
        let default = system.default_step(stop - start).filter(|_| step.is_none());
        let own_step = default.as_ref().map_or(STEP, |chosen| chosen.step);
        let schedule = word(SCHEDULE).map_or(Ok(Schedule::default()), |name| schedule(&name))?;
        let experiment = Experiment {
            tolerance,
            settings: start_values,
            ..Experiment::new(Stepping::new(start, step.unwrap_or(own_step), schedule))
        };
        let gaps = system.find_gaps(&experiment.given(&system)?)?;
        let mut verdict = gaps.judge(&system, experiment.stepping.schedule, false)?;
        let widened = default.filter(|chosen| chosen.is_widened);
        (widened.into_iter()).for_each(|chosen| verdict.note(chosen.text));
        let mut run = Run::start(system, &experiment, verdict)?;
        let watched = self.run.iter().flat_map(|before| before.watched());
        let known = watched.filter(|name| run.system.port(name).is_ok());
        let known = known.cloned().collect();
        run.watch(known)?;
        self.run = Some(run);
        self.restart_history()
    }

    /// Watch these variables from now on; `history` starts again.
    pub fn watch(&mut self, names: Vec<String>) -> Result<()> {
        let names = names.into_iter().map(|name| self.full_name(name));
        let names = names.collect();
        self.run()?.watch(names)?;
        self.restart_history()
    }

    /// Return to a saved state; `history` starts again.
    pub fn restore(&mut self, id: u64) -> Result<()> {
        self.run()?.restore(id)?;
        self.restart_history()
    }

    /// Start `history` with the present values.
    fn restart_history(&mut self) -> Result<()> {
        self.history.clear();
        self.run.as_mut().context(NO_RUN)?.record(&mut self.history)
    }

    /// Make communication steps, each with a row in `history`, which starts again. If a step fails,
    /// the rows tell how many were made.
    pub fn advance(&mut self, steps: u32) -> Result<()> {
        let run = self.run.as_mut().context(NO_RUN)?;
        self.history.clear();
        (0..steps).try_for_each(|_| run.step(&mut self.history))
    }
}

/// A value as `--set NAME=` takes it.
pub fn setting_text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn schedule(name: &str) -> Result<Schedule> {
    let mut named = Schedule::NAMED.iter();
    let Some((_, schedule)) = named.find(|(known, _)| *known == name) else {
        let names = Schedule::NAMED.map(|(known, _)| known).join(", ");
        bail!("`schedule` = `{name}`: it must be one of {names}");
    };
    Ok(*schedule)
}
