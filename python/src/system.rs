//! A loaded system.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum as _;
use cosim::cli::{InputArgs, RunArgs, STEP};
use cosim::io::input_table::{Column, Table};
use cosim::master::Schedule;
use cosim::run::signals::connected;
use cosim::structure::package::FmuPlace;
use cosim::structure::system::{Setting, System as Loaded};
use cosim::{Experiment, Verdict, matching};
use experiments::measures::run::useful;
use experiments::setup::run_setup::{forgotten, tell_delay};
use experiments::setup::{loads, machine_choice};
use experiments::worlds::{Bounds, Cases};
use fmi_description::{Kind, Variable};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::raised;
use crate::run::{self, Request};
use crate::session::Session;

/// A system with its FMUs, loaded once for any number of runs.
#[pyclass(frozen)]
pub struct System {
    system: Arc<Loaded>,
}

/// What is loaded.
#[derive(FromPyObject)]
struct Source {
    /// A system, or FMUs by themselves.
    #[pyo3(item)]
    files: Vec<PathBuf>,
    /// Connections between these FMUs.
    #[pyo3(item)]
    connect: Vec<String>,
    #[pyo3(item)]
    variant: Option<String>,
    #[pyo3(item)]
    fmu_dirs: Vec<PathBuf>,
    #[pyo3(item)]
    parameters: Vec<PathBuf>,
    #[pyo3(item)]
    disconnect: Vec<String>,
    #[pyo3(item)]
    replaced: Vec<(String, PathBuf)>,
    /// Mappings from names of the system to those of the FMUs of components.
    #[pyo3(item)]
    maps: Vec<(String, PathBuf)>,
    /// Components whose outputs may be read again after inputs were set.
    #[pyo3(item)]
    feedthrough: Vec<String>,
    /// Whether the loads of the controller's path are connected to the manipulator.
    #[pyo3(item)]
    has_loads: bool,
}

/// How a run is stepped, and from which start values.
#[derive(FromPyObject)]
struct Conditions {
    #[pyo3(item)]
    settings: Vec<(String, String)>,
    /// s; None: what the system asks for, else its FMUs.
    #[pyo3(item)]
    step: Option<f64>,
    #[pyo3(item)]
    stop_time: Option<f64>,
    #[pyo3(item)]
    schedule: String,
    #[pyo3(item)]
    strict: bool,
    #[pyo3(item)]
    inputs: Option<Inputs>,
    #[pyo3(item)]
    scenario: Option<PathBuf>,
    #[pyo3(item)]
    faults: Vec<String>,
    #[pyo3(item)]
    fault_seed: u64,
}

/// Inputs that no connection drives, over time: times (s), and columns with names and units.
type Inputs = (Vec<f64>, Vec<(String, Option<String>, Vec<f64>)>);

/// A machine of the real world, drawn by seed; its file exists as long as this.
#[pyclass(frozen)]
pub struct Drawn {
    /// Start values: names and values.
    #[pyo3(get)]
    settings: Vec<(String, String)>,
    _machines: Cases,
}

/// What is told of a variable.
type Row = (
    String,
    String,
    String,
    String,
    Option<String>,
    String,
    BTreeMap<String, i64>,
    Option<f64>,
    Option<f64>,
    Option<String>,
    Option<String>,
);

impl System {
    fn load(source: Source) -> Result<Self> {
        let place = FmuPlace::Structure {
            else_in: source.fmu_dirs,
        };
        let variant = source.variant.as_deref();
        let mut system = match source.files.as_slice() {
            [path] if !is_fmu(path) => {
                Loaded::load(path, variant, &place, &source.replaced, &source.maps)?
            }
            files => Loaded::of_fmus(files, &source.connect)?,
        };
        for name in source.feedthrough {
            ensure!(
                system.structure.component(&name).is_some(),
                "feedthrough `{name}`: the system has no component of this name"
            );
            system.structure.feedthrough.push(name);
        }
        for set in &source.parameters {
            system.apply_set(set)?;
        }
        if source.has_loads {
            loads::connect(&mut system)?;
        }
        for input in &source.disconnect {
            let connections = &mut system.structure.connections;
            let before = connections.len();
            connections.retain(|c| format!("{}.{}", c.end.0, c.end.1) != *input);
            ensure!(
                connections.len() < before,
                "`{input}` cannot be disconnected: no connection drives it"
            );
        }
        let system = Arc::new(system);
        Ok(Self { system })
    }

    /// The experiment, by the same rules as the programs' command lines, and what the system may
    /// have forgotten.
    fn experiment(&self, conditions: Conditions) -> Result<(Experiment, Verdict)> {
        let Ok(schedule) = Schedule::from_str(&conditions.schedule, false) else {
            bail!(
                "schedule `{}`: it must be standard, jacobi or gauss-seidel",
                conditions.schedule
            );
        };
        let setting = |(name, value): &(String, String)| format!("{name}={value}");
        let mut args = RunArgs {
            step: conditions.step,
            stop_time: conditions.stop_time,
            schedule,
            input_derivatives: false,
            threads: None,
            between: Default::default(),
            settings: conditions.settings.iter().map(setting).collect(),
            strict: conditions.strict,
            check: false,
        };
        // Where the machine's motion ends, it says itself.
        let preferred = match self.is_machine() {
            true => Verdict::default(),
            false => args.fill_defaults(&self.system),
        };
        let mut experiment = args.experiment(&self.system)?;
        let mut forgotten = forgotten(&args, &self.system, &experiment)?;
        forgotten.extend(preferred);
        let column = |(name, unit, values)| Column { name, unit, values };
        let table = |(times, columns): Inputs| Table {
            times,
            columns: columns.into_iter().map(column).collect(),
        };
        experiment.inputs = conditions.inputs.map(|inputs| Arc::new(table(inputs)));
        let inputs = InputArgs {
            scenario: conditions.scenario,
            faults: conditions.faults,
            seed: conditions.fault_seed,
            ..InputArgs::default()
        };
        forgotten.extend(inputs.add_to(&mut experiment, &self.system)?);
        tell_delay(&self.system, &mut experiment)?;
        Ok((experiment, forgotten))
    }

    fn has(&self, name: &str) -> bool {
        self.system.port(name).is_ok()
    }

    /// The system with a machine file bound to its FMUs.
    fn with_machine(&self, machine: &str) -> Result<Loaded> {
        let mut system = Loaded {
            path: self.system.path.clone(),
            structure: self.system.structure.clone(),
            fmus: self.system.fmus.clone(),
        };
        machine_choice::bind(&mut system, machine)?;
        Ok(system)
    }

    /// The start values of the machine of `seed`, drawn around the system's own or around the
    /// `machine` of a file, and its file.
    fn drawn(&self, seed: u64, machine: Option<&str>) -> Result<Drawn> {
        let seeds = seed..seed + 1;
        let machines = match machine {
            Some(machine) => {
                Cases::of_machines(&self.with_machine(machine)?, seeds, &Bounds::REAL)?
            }
            None => Cases::of_machines(&self.system, seeds, &Bounds::REAL)?,
        };
        let case = machines.list.first().context("one seed is one machine")?;
        let setting = |s: &Setting| (self.system.name(s.port), s.value.clone());
        Ok(Drawn {
            settings: case.settings.iter().map(setting).collect(),
            _machines: machines,
        })
    }

    /// Whether a connection drives a variable, or a bound start value gives it.
    fn drivers(&self, variable: &str, component: usize) -> (Option<String>, Option<String>) {
        let c = &self.system.structure.components[component];
        let mut connections = self.system.structure.connections.iter();
        let driver = connections.find(|x| x.end.0 == c.name && x.end.1 == variable);
        let driver = driver.map(|x| format!("{}.{}", x.start.0, x.start.1));
        let bound = c.parameters.iter().rfind(|p| p.name == variable);
        (driver, bound.map(|p| p.value.clone()))
    }
}

#[pymethods]
impl System {
    #[new]
    fn new(py: Python<'_>, source: Source) -> PyResult<Self> {
        py.detach(|| Self::load(source)).map_err(raised)
    }

    /// Components and their FMUs, in the order in which they are stepped.
    fn components(&self) -> Vec<(String, String)> {
        let components = self.system.structure.components.iter();
        components
            .map(|c| (c.name.clone(), c.source.clone()))
            .collect()
    }

    /// Names of the system's own inputs, and of its outputs with the variables that they show.
    fn connectors(&self) -> (Vec<String>, BTreeMap<String, String>) {
        let structure = &self.system.structure;
        let inputs = structure.inputs.iter().map(|input| input.name.clone());
        let shown = |(component, variable): &(String, String)| format!("{component}.{variable}");
        let outputs = structure.outputs.iter();
        let outputs = outputs.map(|output| (output.name.clone(), shown(&output.start)));
        (inputs.collect(), outputs.collect())
    }

    /// Communication step where none is given, s.
    fn step(&self) -> f64 {
        let preferred = self.system.preferred_step().map(|(step, _)| step);
        preferred.filter(|_| !self.is_machine()).unwrap_or(STEP)
    }

    /// Whether it is the manipulator with its controller.
    fn is_machine(&self) -> bool {
        self.has("hdrm.machine_file") && self.has("tip_error_norm")
    }

    /// Name, causality, variability, type, unit, description, items, bounds, driver and bound value
    /// of every variable.
    fn variables(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        let all = self.system.structure.components.iter();
        for (k, (c, fmu)) in all.zip(&self.system.fmus).enumerate() {
            for v in &fmu.description.variables {
                let (driver, bound) = self.drivers(&v.name, k);
                let lower = |x: &dyn std::fmt::Debug| format!("{x:?}").to_lowercase();
                rows.push((
                    format!("{}.{}", c.name, v.name),
                    lower(&v.causality),
                    lower(&v.variability),
                    v.kind.name().into(),
                    v.unit.clone(),
                    v.description.clone(),
                    items(v),
                    v.min,
                    v.max,
                    driver,
                    bound.or_else(|| v.start_of(0).map(String::from)),
                ));
            }
        }
        rows
    }

    /// Names of the signals that patterns choose; None: those that are recorded where none are
    /// named.
    fn signals(&self, patterns: Option<Vec<String>>) -> PyResult<Vec<String>> {
        let ports = match patterns {
            Some(patterns) => matching(&self.system, &patterns),
            None => match useful(&self.system) {
                Ok(ports) if ports.is_empty() => connected(&self.system),
                ports => ports,
            },
        };
        let name = |port: &cosim::wiring::Port| self.system.name(*port);
        Ok(ports.map_err(raised)?.iter().map(name).collect())
    }

    /// Look at the conditions of a run before it.
    fn check(&self, conditions: Conditions) -> PyResult<()> {
        self.experiment(conditions).map(drop).map_err(raised)
    }

    /// Draw a machine of the real world, around the system's own or around that of the file
    /// `machine`.
    #[pyo3(signature = (seed, machine=None))]
    fn draw(&self, py: Python<'_>, seed: u64, machine: Option<&str>) -> PyResult<Drawn> {
        py.detach(|| self.drawn(seed, machine)).map_err(raised)
    }

    /// A whole run; see the Python package for what the values are.
    fn run(
        &self,
        py: Python<'_>,
        conditions: Conditions,
        request: Request,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyDict>> {
        let (experiment, forgotten) = self.experiment(conditions).map_err(raised)?;
        let (is_machine, progress) = (self.is_machine(), progress.as_ref());
        let run = || run::run(&self.system, &experiment, &request, is_machine, progress);
        let done = py.detach(run);
        done.map_err(raised)?
            .into_python(py, &self.system, forgotten)
    }

    /// A run that the caller steps.
    fn start(&self, py: Python<'_>, conditions: Conditions) -> PyResult<Session> {
        let (experiment, _) = self.experiment(conditions).map_err(raised)?;
        Session::start(py, self.system.clone(), experiment)
    }
}

fn is_fmu(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "fmu")
}

/// Names and numbers of the items of an enumeration.
fn items(v: &Variable) -> BTreeMap<String, i64> {
    match &v.kind {
        Kind::Enumeration(items) => items
            .iter()
            .map(|item| (item.name.clone(), item.value))
            .collect(),
        _ => BTreeMap::new(),
    }
}
