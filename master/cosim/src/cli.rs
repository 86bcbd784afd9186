//! Options and output that `cosim`, the programs of the studies and the Python module share: which
//! system is run and how, with which start values and inputs, the signals written, the exit code.

mod isolation_args;
mod outputs;
mod places;
mod step_args;

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use clap::{ArgGroup, Args};
use indicatif::{ProgressBar, ProgressStyle};

use crate::io::csv::Log;
use crate::io::input_table::{InputTable, Table};
use crate::io::scenario;
use crate::master::{Schedule, Stepping};
use crate::run::interrupt::Interrupted;
use crate::run::signals::{
    connected, matches_pattern, matching_any, matching_real, note_locals, split_lists,
};
use crate::run::simulate::Experiment;
use crate::run::verdict::Verdict;
pub use crate::schedule::STEP;
use crate::schedule::{Between, parse_rate};

use crate::structure::FmuUse;
use crate::structure::package::Package;
use crate::structure::system::{System, split_file};
use crate::wiring::Port;
use fmi_import::digits::short;
use fmi_import::output;
use places::place_of_fmi_3;

pub use isolation_args::{IsolationArgs, serve_if_asked};
pub use outputs::{claim_outputs, csv_output, keep_rows, keep_rows_in, output};
pub use places::{find, place};
pub use step_args::StepArgs;

/// Which system is run.
#[derive(Args, Clone, Default)]
pub struct SystemArgs {
    /// System: a packed .ssp, a .ssd, or an OspSystemStructure.xml or a folder that holds one
    #[arg(long, value_name = "FILE")]
    pub system: Option<PathBuf>,
    /// Take the FMUs from this directory, by file name [default: where the system says; of a .ssd
    /// also the environment variable FMU_DIR, or beside this program, or fmu/ in the build folder]
    #[arg(long, value_name = "DIR")]
    pub fmu_dir: Option<PathBuf>,
    /// Version of FMI: with 3 the FMUs come, by file name, from the folder `fmi3` in that
    /// directory, or in the first of the default places that has one
    #[arg(long, value_name = "VERSION", value_parser = clap::value_parser!(u8).range(2..=3))]
    pub fmi: Option<u8>,
    /// FMU for one component instead of the one that the system names, of either version;
    /// repeatable
    #[arg(long = "fmu", value_name = "COMPONENT=FILE")]
    pub fmus: Vec<String>,
    /// Other names that the FMU of a component has: a parameter mapping (.ssm) from the structure's
    /// names to the FMU's; the component may be left out where one --fmu is given; repeatable
    #[arg(long = "map", value_name = "[COMPONENT=]FILE")]
    pub maps: Vec<String>,
    /// System structure to take from the packed system: `heavy.ssd` [default: SystemStructure.ssd]
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Outputs of this component may be read again after inputs were set at the same communication
    /// point, although it does not declare on which inputs they depend: they count as depending on
    /// all; repeatable
    #[arg(long, value_name = "COMPONENT")]
    pub feedthrough: Vec<String>,
    /// Interface of a component's FMU that has both: cs for Co-Simulation, me for Model Exchange, whose
    /// states are integrated here with the tolerance of the run; a pattern with `*` names several,
    /// and of a single FMU the name may be left out; repeatable [default: cs, if the FMU has it]
    #[arg(long = "interface", value_name = "[COMPONENT=]INTERFACE")]
    pub interfaces: Vec<String>,
    /// Method by which components of Model Exchange are integrated: explicit, stiff, or fixed:STEP
    /// with equal internal steps of at most STEP s and no tolerance; a pattern with `*` names
    /// several, and without a name all are meant; repeatable [default: explicit, and stiff from
    /// where that takes fewer steps]
    #[arg(long = "solver", value_name = "[COMPONENT=]METHOD")]
    pub solvers: Vec<String>,
    /// Components in processes of their own.
    #[command(flatten)]
    pub isolation: IsolationArgs,
    /// Step of a component, or of all that match a pattern with `*`, such as `emla_*=0.25ms`: the
    /// communication step divided by or multiplied with a whole number; repeatable
    #[arg(long = "rate", value_name = "COMPONENT=TIME")]
    pub rates: Vec<String>,
    /// Solve algebraic loops of declared dependencies by Newton's method, in initialization and,
    /// with the schedules jacobi and gauss-seidel, at every communication point; with standard by
    /// steps repeated from saved states, where outputs without declared dependencies depend on all
    /// inputs
    #[arg(long)]
    pub solve_loops: bool,
    /// Parameter set for the system, in the packed system (`resources/heavy.ssv`) or a file;
    /// repeatable, before all other options
    #[arg(long, value_name = "FILE")]
    pub parameters: Vec<PathBuf>,
}

impl SystemArgs {
    /// Loads the system; without `--system` the one that `default` finds. Its arrays have the sizes
    /// that start values give (`--set`).
    pub fn load(
        &self,
        start_values: &[String],
        default: impl FnOnce() -> Result<PathBuf>,
    ) -> Result<System> {
        let path = self.system.clone().map_or_else(default, Ok)?;
        let place = match (&self.fmu_dir, self.fmi) {
            (folder, Some(3)) => place_of_fmi_3(folder.as_deref(), &path)?,
            (folder, _) => place(folder.as_deref())?,
        };
        let variant = self.variant.as_deref();
        let replaced = self.fmus.iter().map(|text| {
            let (component, file) = split_file(text)
                .with_context(|| format!("--fmu {text}: it must be COMPONENT=FILE"))?;
            Ok((component.to_string(), PathBuf::from(file)))
        });
        let replaced = replaced.collect::<Result<Vec<_>>>()?;
        let mapping = |text: &String| match (split_file(text), replaced.as_slice()) {
            (Some((component, file)), _) => Ok((component.to_string(), PathBuf::from(file))),
            (None, [(component, _)]) => Ok((component.clone(), PathBuf::from(text))),
            (None, _) => {
                bail!("--map {text}: it must be COMPONENT=FILE unless one --fmu is given")
            }
        };
        let maps = self.maps.iter().map(mapping).collect::<Result<Vec<_>>>()?;
        let package = &mut Package::open(&path)?;
        let (chosen, loaded) = (&self.fmu_use()?, &mut BTreeMap::new());
        let system =
            System::from_package(package, variant, &place, &replaced, &maps, chosen, loaded)?;
        if let Some(wanted) = self.fmi {
            for (c, fmu) in system.structure.components.iter().zip(&system.fmus) {
                let (name, version) = (&c.name, fmu.description.fmi.to_string());
                let is_replaced = replaced.iter().any(|(own, _)| own == name);
                ensure!(
                    is_replaced || version.starts_with(&wanted.to_string()),
                    "--fmi {wanted}: the FMU of component `{name}` is of FMI {version}"
                );
            }
        }
        self.changed(system, start_values)
    }

    /// Loads FMUs without a structure; `connections` are those of `--connect`. Refuses options that
    /// choose files or names of a structure.
    pub fn load_fmus(
        &self,
        files: &[PathBuf],
        connections: &[String],
        start_values: &[String],
    ) -> Result<System> {
        let are_chosen = "these FMUs are the files that are named";
        for (is_given, option, why) in [
            (
                self.variant.is_some(),
                "--variant",
                "FMUs have no structures to choose from",
            ),
            (self.fmu_dir.is_some(), "--fmu-dir", are_chosen),
            (self.fmi.is_some(), "--fmi", are_chosen),
            (!self.fmus.is_empty(), "--fmu", are_chosen),
            (
                !self.maps.is_empty(),
                "--map",
                "no structure has other names for their variables",
            ),
        ] {
            ensure!(
                !is_given,
                "{option} is for a system, a packed .ssp or a .ssd: {why}"
            );
        }
        let system = System::from_fmus(files, connections, &self.fmu_use()?)?;
        self.changed(system, start_values)
    }

    /// Refuses those of these options that are given, for commands that make no run, and those of
    /// processes if no instances are made.
    pub fn refuse_running(&self, options: &[(bool, &str)], no_instances: bool) -> Result<()> {
        let own = [
            (!self.isolation.isolate.is_empty(), "--isolate"),
            (self.isolation.call_timeout.is_some(), "--call-timeout"),
            (self.isolation.memory_limit.is_some(), "--memory-limit"),
            (self.isolation.prefers_wasm(), "--prefer"),
        ];
        let own = own.iter().filter(|_| no_instances);
        match options.iter().chain(own).find(|(is_given, _)| *is_given) {
            Some((_, option)) => {
                bail!("{option} says how a run is made, and this command makes none")
            }
            None => Ok(()),
        }
    }

    fn fmu_use(&self) -> Result<FmuUse> {
        self.isolation.clone().fmu_use(self.interfaces.clone())
    }

    /// The system with parameter sets, sizes of arrays and ways of stepping, wherever its FMUs come
    /// from.
    fn changed(&self, system: System, start_values: &[String]) -> Result<System> {
        let mut system = system.with_sizes(None, &self.parameters, start_values)?;
        system.check_fit()?;
        for set in &self.parameters {
            system.apply_set(set)?;
        }
        system.structure.solves_loops = self.solve_loops;
        for name in &self.feedthrough {
            let allowed = system.allow_feedthrough(name);
            allowed.with_context(|| format!("--feedthrough {name}"))?;
        }
        for text in &self.solvers {
            let chosen = system.choose_solver(text);
            chosen.with_context(|| format!("--solver {text}"))?;
        }
        for text in &self.rates {
            let (pattern, step) = parse_rate(text).context("--rate")?;
            let structure = &mut system.structure;
            let names = structure.components.iter().map(|c| &c.name);
            let names = names.filter(|name| matches_pattern(pattern, name));
            let rates = &mut structure.rates;
            let before = rates.len();
            rates.extend(names.map(|name| (name.clone(), step)));
            ensure!(
                rates.len() > before,
                "--rate {text}: the system has no component of this name"
            );
        }
        Ok(system)
    }
}

/// How the system is stepped, and from which values.
#[derive(Args, Clone, Default)]
#[group(skip)] // A program's own command may be called `run`.
pub struct RunArgs {
    /// Communication step H, s [default of cosim: the one that the system structure asks for, else
    /// the smallest that an FMU prefers; else 0.001]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub step: Option<f64>,
    /// Start time, s [default: that of the system's default experiment, else the earliest of its
    /// FMUs]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub start_time: Option<f64>,
    /// Relative tolerance that the FMUs are told [default: the one that each FMU declares, if any]
    #[arg(long, value_name = "TOLERANCE")]
    pub tolerance: Option<f64>,
    /// Stop time, s [default: the end of the motion where the program knows it, else that of the
    /// system's default experiment]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub stop_time: Option<f64>,
    /// Order of stepping
    #[arg(long, value_enum, default_value_t)]
    pub schedule: Schedule,
    /// With --schedule jacobi: pass first time derivatives of continuous signals instead of holding
    /// them
    #[arg(long)]
    pub input_derivatives: bool,
    /// Continuous inputs within a step
    #[arg(long, value_enum, default_value_t)]
    pub between: Between,
    /// Threads that share the components, with the same results; each has its own copies of the
    /// FMUs' libraries [default of cosim run: as many as there are cores if the first steps take
    /// long, else 1]
    #[arg(long, value_name = "NUMBER")]
    pub threads: Option<usize>,
    /// Start value of any variable, repeatable, applied last; an enumeration item may be given by
    /// name, and the component left out where one alone has the variable
    #[arg(long = "set", value_name = "COMPONENT.VARIABLE=VALUE")]
    pub settings: Vec<String>,
    /// Variable that may have values that are not finite numbers, `component.variable` or a pattern
    /// as for --signals; repeatable. Otherwise such a value ends the run, or in an output that no
    /// connection passes on makes the verdict bad
    #[arg(long, value_name = "NAME")]
    pub allow_nonfinite: Vec<String>,
    /// Refuse a system with input connectors that nothing drives or sets, or with connectors that
    /// its FMUs do not have; inputs without a connector keep their start values. Of FMUs without a
    /// structure all inputs must be driven or set
    #[arg(long)]
    pub strict: bool,
    /// End with exit code 2 if the verdict on the result is bad (0: the run is done, 1: it failed)
    #[arg(long)]
    pub check: bool,
}

impl RunArgs {
    /// Fills in a step and a stop time that are not given: those of the system, else of its FMUs.
    /// Returns findings on them.
    pub fn fill_defaults(&mut self, system: &System) -> Verdict {
        let mut verdict = Verdict::default();
        let start = self.start_time.unwrap_or(system.structure.start_time);
        let given = self.stop_time.or(system.structure.stop_time);
        let stop = given.unwrap_or_else(|| system.preferred_stop(start));
        if let (None, Some(chosen)) = (self.step, system.default_step(stop - start)) {
            self.step = Some(chosen.step);
            if chosen.step != STEP {
                verdict.note(chosen.text);
            }
        }
        if given.is_none() {
            verdict.note(format!(
                "no stop time is given: the run ends at t = {} s",
                short(stop)
            ));
            self.stop_time = Some(stop);
        }
        verdict
    }

    /// The experiment on `system` with these arguments.
    pub fn experiment(&self, system: &System) -> Result<Experiment> {
        let schedule = match (self.schedule, self.input_derivatives) {
            (Schedule::Jacobi, true) => Schedule::JacobiDerivatives,
            (_, true) => bail!("--input-derivatives needs --schedule jacobi"),
            (schedule, false) => schedule,
        };
        let mut settings = Vec::new();
        for text in &self.settings {
            let parsed = system.parse_settings(text);
            settings.extend(parsed.with_context(|| format!("--set {text}"))?);
        }
        // Values may name files that the FMUs read.
        let bound = (system.structure.components.iter()).flat_map(|c| &c.parameters);
        let values = bound.map(|p| &p.value);
        for value in values.chain(settings.iter().map(|s| &s.value)) {
            output_file::note_read(Path::new(value))?;
        }
        let (step, start) = (self.step.unwrap_or(STEP), self.start_time);
        let start = start.unwrap_or(system.structure.start_time);
        ensure!(
            start.is_finite(),
            "--start-time {start}: the start must be a finite time in s"
        );
        if let Some(tolerance) = self.tolerance {
            ensure!(
                tolerance > 0.0 && tolerance < 1.0,
                "--tolerance {tolerance}: a relative tolerance must be above 0 and below 1"
            );
        }
        ensure!(
            step.is_finite() && step > 0.0,
            "--step {step}: the communication step must be greater than 0 s"
        );
        let mut stepping = Stepping::new(start, step, schedule);
        stepping.between = self.between;
        Ok(Experiment {
            threads: self.threads.unwrap_or(1),
            stop: self.stop_time,
            tolerance: self.tolerance,
            settings,
            nonfinite: matching_real(system, &self.allow_nonfinite).context("--allow-nonfinite")?,
            ..Experiment::new(stepping)
        })
    }

    /// The gaps of the system structure in this experiment, as findings; with `--strict` errors.
    pub fn judge_gaps(&self, system: &System, experiment: &Experiment) -> Result<Verdict> {
        let gaps = system.find_gaps(&experiment.given(system)?)?;
        gaps.judge(system, experiment.stepping.schedule, self.strict)
    }
}

/// Values for the inputs of a run, and faults of its connections.
#[derive(Args, Clone, Default)]
pub struct InputArgs {
    /// Values over time for inputs that no connection drives: a CSV file whose columns are `time`
    /// and `component.variable`; units are those in FILE.units.csv, where there is one
    #[arg(long, value_name = "FILE")]
    pub input: Option<PathBuf>,
    /// Column of --input for an input, where it is not named after it; only columns that are named
    /// so are then taken; repeatable
    #[arg(long = "input-column", value_name = "INPUT=COLUMN", requires = "input")]
    pub columns: Vec<String>,
    /// Events that alter variables: a scenario of libcosim, as JSON or YAML
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<PathBuf>,
    /// Fault of a connection, named by its input, or of all connections of an output:
    /// bias:NUMBER, gain:NUMBER, override:VALUE, freeze, drop:PROBABILITY, delay:SECONDS or
    /// noise:DEVIATION, from and until a time, s; repeatable, one after the other
    #[arg(long = "fault", value_name = "WIRE=EFFECT[@FROM..UNTIL]")]
    pub faults: Vec<String>,
    /// Short for --fault WIRE=noise:DEVIATION
    #[arg(long, value_name = "WIRE=DEVIATION")]
    pub noise: Vec<String>,
    /// Seed of the random numbers in faults [default: 0]
    #[arg(long)]
    pub seed: Option<u64>,
}

impl InputArgs {
    /// Adds these inputs and faults to an experiment; returns them as findings.
    pub fn add_to(&self, experiment: &mut Experiment, system: &System) -> Result<Verdict> {
        let mut verdict = Verdict::default();
        let pair = |text: &String| {
            let parts = system.split_name(text);
            let parts = parts.map(|(a, b)| (a.into(), b.into()));
            parts.with_context(|| format!("--input-column {text}: it must be INPUT=COLUMN"))
        };
        let columns = self.columns.iter().map(pair).collect::<Result<Vec<_>>>()?;
        if let Some(file) = &self.input {
            experiment.inputs = Some(Arc::new(Table::load(file, system, &columns)?));
        }
        let faults = &mut experiment.faults;
        faults.seed = self.seed.unwrap_or_default();
        for text in &self.faults {
            let added = faults.add(system, text);
            added.with_context(|| format!("--fault {text}"))?;
        }
        for text in &self.noise {
            let (wire, sigma) = system.split_name(text).unwrap_or((text, ""));
            let added = faults.add(system, &format!("{wire}=noise:{sigma}"));
            added.with_context(|| format!("--noise {text}"))?;
        }
        if let Some(seed) = self.seed {
            ensure!(
                faults.is_random(),
                "seed {seed}: it is for faults that draw random numbers, noise and drop; this run has none"
            );
        }
        if let Some(file) = &self.scenario {
            let scenario = scenario::add(file, system, experiment.stepping, faults)?;
            verdict.note(scenario);
        }
        let table = experiment.inputs.as_deref();
        let table = table.map(|table| InputTable::new(system, table));
        let table = table.transpose()?;
        let fed = table.as_ref().map_or(&[][..], InputTable::ports);
        let lines = faults.describe(system, &system.wiring()?, fed);
        (lines.context("--fault")?.into_iter()).for_each(|line| verdict.note(line));
        Ok(verdict)
    }
}

/// Which signals of a run are written.
#[derive(Args, Clone)]
#[command(group = ArgGroup::new("rows").multiple(true))]
pub struct CsvArgs {
    /// Write signals to this CSV file, and their units beside it to NAME.units.csv
    #[arg(long, value_name = "FILE", value_parser = csv_output(), group = "rows")]
    pub csv: Option<PathBuf>,
    /// Signals for --csv in the order of their columns, comma-separated, with * for any text:
    /// `arm.tip.*,*.F`; `*` for all outputs; an array by its name [default: a useful few]
    #[arg(long, value_name = "PATTERNS", requires = "rows")]
    pub signals: Vec<String>,
    /// Time from row to row, s, a multiple of the communication step [default: the communication
    /// step]
    #[arg(
        long,
        value_name = "SECONDS",
        requires = "rows",
        allow_negative_numbers = true
    )]
    pub interval: Option<f64>,
}

impl CsvArgs {
    /// Findings on the signals that are written where none are named.
    pub fn notes(&self, system: &System) -> Result<Verdict> {
        let mut verdict = Verdict::default();
        if self.csv.is_some() && self.signals.iter().all(|pattern| pattern == "*") {
            note_locals(system, &connected(system)?, &mut verdict);
        }
        Ok(verdict)
    }

    /// The signals; where none are named the variables `useful`.
    pub fn ports(
        &self,
        system: &System,
        useful: impl FnOnce() -> Result<Vec<Port>>,
    ) -> Result<Vec<Port>> {
        match self.signals.is_empty() {
            true => useful(),
            false => matching_any(system, &split_lists(system, &self.signals)),
        }
    }

    /// The log file, if one is wanted; without `--signals` of the variables `useful`. With
    /// `has_steps` it has columns for the length and the error of each step.
    pub fn log(
        &self,
        system: &System,
        experiment: &Experiment,
        has_steps: bool,
        useful: impl FnOnce() -> Result<Vec<Port>>,
    ) -> Result<Option<Log>> {
        let Some(path) = &self.csv else {
            return Ok(None);
        };
        let ports = self.ports(system, useful)?;
        let (interval, stepping) = (self.interval, experiment.stepping);
        Log::create(path, system, &ports, interval, stepping, has_steps).map(Some)
    }
}

/// A progress bar over `length` steps or runs; invisible if `hidden`.
pub fn bar(length: u64, unit: &str, hidden: bool) -> ProgressBar {
    if hidden {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    let template = format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{elapsed}} elapsed, {{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Writes to standard output.
pub fn print(text: impl Display) -> Result<()> {
    Ok(output::write(text)?)
}

/// Ends a program with its exit code: 0, 1 after an error, with `check` 2 if the verdict is bad, 128
/// and the number of the signal that ended the run. Prints an error, except that the reader of the output has gone.
pub fn exit(result: Result<Verdict>, check: bool) -> ExitCode {
    let is_closed = |e: &(dyn std::error::Error + 'static)| {
        let error = e.downcast_ref::<io::Error>();
        let error = error.filter(|e| e.kind() == io::ErrorKind::BrokenPipe);
        // Not that of an output file, whose rows are lost: that error has a text of its own.
        error.is_some_and(|e| e.raw_os_error().is_some())
    };
    output::end(match result {
        Ok(verdict) if check && verdict.is_bad() => 2,
        Ok(_) => 0,
        Err(error) if error.chain().any(is_closed) => 0,
        Err(error) => {
            eprintln!("error: {error:#}");
            let interrupted = error.downcast_ref::<Interrupted>();
            interrupted.map_or(1, Interrupted::exit_code)
        }
    })
}
