//! The class `System`: a loaded system, its variables, and its runs; `hdrm_fmu.System` holds one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum as _;
use cosim::cli::{InputArgs, IsolationArgs, RunArgs, STEP};
use cosim::io::input_table::{Column, Table};
use cosim::master::Schedule;
use cosim::run::run_key::RunKey;
use cosim::run::signals::connected;
use cosim::structure::Parameter;
use cosim::structure::package::{FmuPlace, Package, read};
use cosim::structure::system::{Setting, System as Loaded};
use cosim::{Experiment, Port, Verdict, matching};
use experiments::measures::run::default_signals;
use experiments::setup::loads;
use experiments::setup::machine_choice::{self, GainChoice};
use experiments::setup::run_setup::{check_mentions, set_delays};
use experiments::worlds::{Bounds, Cases, without_worlds};

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{failed_run, to_exception};
use crate::run::{self, Request};
use crate::session::Session;

/// A system with its FMUs, loaded once for any number of runs.
#[pyclass(frozen)]
pub struct System {
    system: Arc<Loaded>,
    /// Parameter sets that the user gives.
    sets: Vec<PathBuf>,
}

/// The files of a system, and the changes to it, as `hdrm_fmu.System` takes them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Source {
    /// A system, or FMUs without one.
    files: Vec<PathBuf>,
    /// Names of these FMUs; empty: those of the files.
    names: Vec<String>,
    /// Connections between these FMUs.
    connect: Vec<String>,
    variant: Option<String>,
    fmu_dirs: Vec<PathBuf>,
    parameters: Vec<PathBuf>,
    /// Values of structural parameters, on which the sizes of arrays depend: `name=value`.
    sizes: Vec<String>,
    disconnect: Vec<String>,
    replaced: Vec<(String, PathBuf)>,
    /// Mappings from names of the system to those of the components' FMUs.
    maps: Vec<(String, PathBuf)>,
    /// Components whose outputs may be read again after inputs were set.
    feedthrough: Vec<String>,
    /// Interfaces of components' FMUs, and methods by which those of Model Exchange are integrated.
    interfaces: Vec<String>,
    solvers: Vec<String>,
    /// Components in processes of their own, the limits of these, and which binaries run.
    isolate: Vec<String>,
    call_timeout: Option<f64>,
    memory_limit: Option<String>,
    prefer: String,
    /// Whether algebraic loops are solved.
    solve_loops: bool,
    /// Whether the loads of the controller's path are connected to the manipulator.
    has_loads: bool,
}

/// The conditions of a run: how it is stepped, its start values, its inputs.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Conditions {
    settings: Vec<(String, String)>,
    /// s; None: the step that the system asks for, else its FMUs.
    step: Option<f64>,
    start_time: Option<f64>,
    stop_time: Option<f64>,
    /// None: that of each FMU.
    tolerance: Option<f64>,
    schedule: String,
    strict: bool,
    inputs: Option<Inputs>,
    scenario: Option<PathBuf>,
    faults: Vec<String>,
    fault_seed: Option<u64>,
    /// Variables that may have values that are not finite.
    allow_nonfinite: Vec<String>,
}

/// Inputs that no connection drives, over time: times (s), and columns with names and units.
type Inputs = (Vec<f64>, Vec<(String, Option<String>, Vec<f64>)>);

/// Start values for a machine file: names and values; its gains by the rule, in words.
type MachineBound = (Vec<(String, String)>, Option<String>);

/// A machine of the real world, drawn by seed; its file exists as long as this object.
#[pyclass(frozen)]
pub struct DrawnMachine {
    /// Start values: names and values.
    #[pyo3(get)]
    settings: Vec<(String, String)>,
    _machines: Cases,
}

/// The fields of `hdrm_fmu.Variable`.
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
        let isolation = IsolationArgs {
            isolate: source.isolate,
            call_timeout: source.call_timeout,
            memory_limit: source.memory_limit,
            prefer: Some(source.prefer),
        };
        let options = isolation.fmu_use(source.interfaces)?;
        let system = match source.files.as_slice() {
            [path] if !is_fmu(path) => {
                let (package, loaded) = (&mut Package::open(path)?, &mut BTreeMap::new());
                let (replaced, maps) = (&source.replaced, &source.maps);
                Loaded::from_package(package, variant, &place, replaced, maps, &options, loaded)?
            }
            files if source.names.is_empty() => {
                Loaded::from_fmus(files, &source.connect, &options)?
            }
            files => {
                let files = files.iter().map(|file| file.display().to_string());
                let files = source.names.iter().cloned().zip(files).collect();
                let load = |file: &str| read(Path::new(file));
                Loaded::from_files(files, &source.connect, &options, load)?
            }
        };
        let mut system = system.with_sizes(None, &source.parameters, &source.sizes)?;
        if !source.sizes.is_empty() {
            system.check_fit()?;
        }
        system.structure.solves_loops = source.solve_loops;
        for name in source.feedthrough {
            let allowed = system.allow_feedthrough(&name);
            allowed.with_context(|| format!("feedthrough `{name}`"))?;
        }
        for text in &source.solvers {
            let chosen = system.choose_solver(text);
            chosen.with_context(|| format!("solver `{text}`"))?;
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
        Ok(Self {
            system: Arc::new(system),
            sets: without_worlds(&source.parameters),
        })
    }

    /// The experiment, by the same rules as the programs' command lines, with findings such as
    /// settings that match nothing. A run that is stepped gets its inputs from the script.
    fn experiment(
        &self,
        conditions: Conditions,
        is_stepped: bool,
    ) -> Result<(Experiment, Verdict)> {
        let Ok(schedule) = Schedule::from_str(&conditions.schedule, false) else {
            bail!(
                "schedule `{}`: it must be standard, jacobi or gauss-seidel",
                conditions.schedule
            );
        };
        let mut args = RunArgs {
            step: conditions.step,
            start_time: conditions.start_time,
            stop_time: conditions.stop_time,
            tolerance: conditions.tolerance,
            schedule,
            allow_nonfinite: conditions.allow_nonfinite,
            strict: conditions.strict,
            ..RunArgs::default()
        };
        // The machine's controller itself says when its motion ends.
        let preferred = match self.is_machine() {
            true => Verdict::default(),
            false => args.fill_defaults(&self.system),
        };
        let mut experiment = args.experiment(&self.system)?;
        for (name, value) in &conditions.settings {
            experiment
                .settings
                .extend(self.system.settings(name, value)?);
        }
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
        let altered = inputs.add_to(&mut experiment, &self.system)?;
        let given = match is_stepped {
            true => {
                let inputs = self.system.all_ports();
                let inputs = inputs.filter(|port| self.system.variable(*port).is_input());
                inputs.collect()
            }
            false => experiment.given(&self.system)?,
        };
        let schedule = experiment.stepping.schedule;
        let mut findings = check_mentions(&args, &self.system, schedule, &given)?;
        findings.extend(preferred);
        findings.extend(altered);
        set_delays(&self.system, &mut experiment)?;
        Ok((experiment, findings))
    }

    /// The system with a machine file bound to its FMUs.
    fn with_machine(&self, machine: &str) -> Result<Loaded> {
        let mut system = Loaded::clone(&self.system);
        machine_choice::bind(&mut system, machine)?;
        Ok(system)
    }

    /// Start values with which the system runs with a machine file: its name, axes, and the gains by
    /// the rule, as in `hdrm-fmu run --machine`; the user gives `values`. Second, a list of the gains
    /// in words.
    fn bound_for(&self, machine: &str, values: &[(String, String)]) -> Result<MachineBound> {
        let mut system = self.with_machine(machine)?;
        let mut settings = Vec::new();
        for (name, value) in values {
            settings.extend(system.settings(name, value)?);
        }
        let choice = GainChoice {
            machine,
            sets: &self.sets,
            settings: &settings,
        };
        let gains = choice.bind(&mut system)?;
        let mut bound = Vec::new();
        for component in &system.structure.components {
            let own = component.parameters.iter();
            let own = own.filter(|parameter| parameter.origin == machine_choice::ORIGIN);
            let named = |p: &Parameter| (format!("{}.{}", component.name, p.name), p.value.clone());
            bound.extend(own.map(named));
        }
        Ok((bound, gains))
    }

    /// Draws the machine of `seed` around the system's own machine or that of the file `machine`.
    fn drawn(&self, seed: u64, machine: Option<&str>) -> Result<DrawnMachine> {
        let seeds = seed..seed + 1;
        let machines = match machine {
            Some(machine) => {
                Cases::draw_machines(&self.with_machine(machine)?, seeds, &Bounds::REAL)?
            }
            None => Cases::draw_machines(&self.system, seeds, &Bounds::REAL)?,
        };
        let case = machines.list.first().context("one seed is one machine")?;
        let setting = |s: &Setting| (self.system.name(s.port), s.value.clone());
        Ok(DrawnMachine {
            settings: case.settings.iter().map(setting).collect(),
            _machines: machines,
        })
    }
}

#[pymethods]
impl System {
    #[new]
    fn new(py: Python<'_>, source: Source) -> PyResult<Self> {
        py.detach(|| Self::load(source)).map_err(to_exception)
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

    /// Communication step where none is given, s, of a run between these times, s.
    #[pyo3(signature = (start=None, stop=None))]
    fn step(&self, start: Option<f64>, stop: Option<f64>) -> f64 {
        let start = start.unwrap_or(self.system.structure.start_time);
        let stop = stop.or(self.system.structure.stop_time);
        let stop = stop.unwrap_or_else(|| self.system.preferred_stop(start));
        let preferred = self.system.default_step(stop - start);
        let preferred = preferred.filter(|_| !self.is_machine());
        preferred.map_or(STEP, |chosen| chosen.step)
    }

    /// Whether it is the manipulator with its controller.
    fn is_machine(&self) -> bool {
        let has = |name: &str| self.system.port(name).is_ok();
        has("hdrm.machine_file") && has("tip_error_norm")
    }

    /// Name, causality, variability, type, unit, description, items, bounds, driver and bound value
    /// of every variable.
    fn variables(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        let structure = &self.system.structure;
        for (c, fmu) in structure.components.iter().zip(&self.system.fmus) {
            for v in &fmu.description.variables {
                let mut connections = structure.connections.iter();
                let driver = connections.find(|x| x.end.0 == c.name && x.end.1 == v.name);
                let bound = c.parameters.iter().rfind(|p| p.name == v.name);
                let lower = |x: &dyn std::fmt::Debug| format!("{x:?}").to_lowercase();
                rows.push((
                    format!("{}.{}", c.name, v.name),
                    lower(&v.causality),
                    lower(&v.variability),
                    v.kind.name().into(),
                    v.unit.clone(),
                    v.description.clone(),
                    (v.items().iter().map(|item| (item.name.clone(), item.value))).collect(),
                    v.min,
                    v.max,
                    driver.map(|x| format!("{}.{}", x.start.0, x.start.1)),
                    bound
                        .map_or_else(|| v.start_of(0), |p| Some(&p.value))
                        .map(String::from),
                ));
            }
        }
        rows
    }

    /// Names of the signals that match patterns; None: the signals that are recorded by default.
    fn signals(&self, patterns: Option<Vec<String>>) -> PyResult<Vec<String>> {
        let ports = match patterns {
            Some(patterns) => matching(&self.system, &patterns),
            None => match default_signals(&self.system) {
                Ok(ports) if ports.is_empty() => connected(&self.system),
                ports => ports,
            },
        };
        let name = |port: &Port| self.system.name(*port);
        Ok(ports.map_err(to_exception)?.iter().map(name).collect())
    }

    /// Checks the conditions of a run.
    fn check(&self, conditions: Conditions) -> PyResult<()> {
        let checked = self.experiment(conditions, false);
        checked.map(drop).map_err(to_exception)
    }

    /// Key of a run under these conditions: a hash of all that its numbers depend on.
    fn key(&self, conditions: Conditions) -> PyResult<String> {
        let (experiment, _) = self.experiment(conditions, false).map_err(to_exception)?;
        Ok(RunKey::new(&self.system, &experiment).digest())
    }

    /// Draws a machine of the real world, around the system's own machine or that of the file
    /// `machine`.
    #[pyo3(signature = (seed, machine=None))]
    fn draw(&self, py: Python<'_>, seed: u64, machine: Option<&str>) -> PyResult<DrawnMachine> {
        let drawn = py.detach(|| self.drawn(seed, machine));
        drawn.map_err(to_exception)
    }

    /// Start values for a machine file besides those of the user, and a list of its gains by the rule.
    fn for_machine(
        &self,
        py: Python<'_>,
        machine: &str,
        values: Vec<(String, String)>,
    ) -> PyResult<MachineBound> {
        let bound = py.detach(|| self.bound_for(machine, &values));
        bound.map_err(to_exception)
    }

    /// Makes a whole run; the Python package documents the values.
    fn run(
        &self,
        py: Python<'_>,
        conditions: Conditions,
        request: Request,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyDict>> {
        let prepared = self.experiment(conditions, false);
        let (experiment, findings) = prepared.map_err(to_exception)?;
        let (is_machine, progress) = (self.is_machine(), progress.as_ref());
        let run = || run::run(&self.system, &experiment, &request, is_machine, progress);
        let (result, error) = py.detach(run).map_err(to_exception)?;
        let last = result.last_time();
        let result = result.into_python(py, &self.system, findings)?;
        match error {
            None => Ok(result),
            Some(error) => Err(failed_run(py, error, result, last)),
        }
    }

    /// Starts a run that the caller steps, in this thread.
    fn start(&self, py: Python<'_>, conditions: Conditions) -> PyResult<Session> {
        let experiment = self.experiment(conditions, true).map_err(to_exception)?;
        let (system, is_machine) = (self.system.clone(), self.is_machine());
        let start = || Session::start(system, experiment, is_machine);
        py.detach(start).map_err(to_exception)
    }

    /// Starts a run of this system anew.
    fn restart(&self, session: &Session, conditions: Conditions) -> PyResult<()> {
        let experiment = self.experiment(conditions, true).map_err(to_exception)?;
        session.restart(experiment, self.is_machine())
    }
}

fn is_fmu(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "fmu")
}
