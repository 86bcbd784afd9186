//! Subcommands of the evaluation: robustness tables, testbed, stability and endurance in numbers.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::endurance::{self, Excursion, Part};
use crate::experiment::vary;
use crate::machine_file::MachineFile;
use crate::robustness::{self, STUDIES, Study};
use crate::tip::TipError;
use crate::worlds::{self, World};
use crate::{laws, rig_testbed, stability, table, testbed};
use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use cosim::cli::{bar, print};
use cosim::csv::CsvFile;
use cosim::run::Experiment;
use cosim::system::{Setting, System};
use cosim::verdict::Verdict;
use serde_json::{Value, json};

use super::MachineArgs;
use super::worlds::{compare, in_the_loop};

#[derive(Args)]
pub struct TableArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Plant and sensors that the controllers are compared on
    #[arg(long, value_enum, default_value_t = World::Ideal)]
    pub world: World,
    /// What is varied, repeatable [default: inertia; in the other worlds rivals]
    #[arg(long = "study", value_enum)]
    studies: Vec<StudyArg>,
    /// First seed: of the three of the noise study, of those of the real world
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Machines drawn by seed [default: 20 of the real world, 5 of the bending one]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: Option<u64>,
    /// Laws to compare, repeatable; by their names in the table [default: all of the study]
    #[arg(long = "law", value_name = "NAME")]
    pub laws: Vec<String>,
    /// Also write the cells of the inertia study, or the runs of a comparison of laws, to this CSV file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Also write all cells to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Args)]
pub struct TestbedArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Testbed: a packed .ssp [default: Testbed.ssp beside the system]
    #[arg(long, value_name = "FILE")]
    testbed: Option<PathBuf>,
    /// Testbed of actuators as built: a packed .ssp [default: RigTestbed.ssp beside the system]
    #[arg(long, value_name = "FILE")]
    rig_testbed: Option<PathBuf>,
    /// Time constant of the loads, s
    #[arg(long, default_value_t = 0.02, value_name = "SECONDS")]
    lag: f64,
    /// Write reference and measurement of each axis (s, m, m/s, N) to TRAJECTORY_AXIS.csv in this directory
    #[arg(long, value_name = "DIR")]
    csv_dir: Option<PathBuf>,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Args)]
pub struct StabilityArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Plant and sensors; real: by which cause the bound is exceeded
    #[arg(long, value_enum, default_value_t = World::Ideal)]
    world: World,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.4)]
    inertia_scale: f64,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Args)]
pub struct EnduranceArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Communication steps; 10000000 of 1 ms are 2.8 h of simulated time
    #[arg(long, default_value_t = 1_000_000)]
    steps: u64,
    /// Edges of the box that the tip moves through, from its start on, m, world frame
    #[arg(long, default_values_t = [-0.2, 0.2, 0.2], num_args = 3, value_names = ["X", "Y", "Z"], allow_negative_numbers = true)]
    edges: Vec<f64>,
    /// Period of the motion along X, s; those along Y and Z are sqrt(2) and 1.618 times as long
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS")]
    period: f64,
    /// Controller
    #[arg(long, value_parser = laws::MODES, default_value = "adaptive")]
    mode: String,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.2)]
    inertia_scale: f64,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum StudyArg {
    /// The paper's table: mass and inertia of all bodies
    Inertia,
    /// Motor and transmission parameters, each and together
    Motor,
    /// Payload alone
    Payload,
    /// Sensor noise
    Noise,
    /// Unknown wrench on the tip
    TipLoad,
    /// All of the above
    All,
    /// All modes of the controller, with and without integral: known error, the plant's tip, orientation, rho
    Rivals,
    /// Adaptation x disturbance observer x integral of the voltage law x integral of the tip's error
    Ablation,
    /// The rivals with integral at several rates of it
    IntegralRate,
    /// In the real world: what its parameter set changes, taken back one at a time
    Changes,
    /// In the real world: what was tried and is not in its parameter set, added one at a time
    Tried,
    /// In the real world: with and without force sensor, speeds known or estimated, other delays
    Sensors,
    /// In the real world: physics, hybrid and network under the shipped law and the paper's, on the nominal machine
    Surrogate,
}

impl StudyArg {
    /// Whether it is about what only the real world has.
    fn is_of_real_world(self) -> bool {
        use StudyArg::{Changes, Sensors, Surrogate, Tried};
        matches!(self, Changes | Tried | Sensors | Surrogate)
    }

    /// Whether it compares control laws over the cases of a world.
    fn compares_laws(self) -> bool {
        matches!(
            self,
            Self::Rivals
                | Self::Ablation
                | Self::IntegralRate
                | Self::Changes
                | Self::Tried
                | Self::Sensors
        )
    }

    fn name(self) -> String {
        let value = self.to_possible_value().expect("no value is skipped");
        value.get_name().to_owned()
    }
}

impl TableArgs {
    /// The studies asked for, else those of the world.
    fn wanted(&self) -> Vec<StudyArg> {
        match (&self.studies[..], self.world) {
            ([], World::Ideal) => vec![StudyArg::Inertia],
            ([], World::Real | World::Bending) => vec![StudyArg::Rivals],
            (studies, _) => studies.to_vec(),
        }
    }

    fn wants(&self, study: StudyArg) -> bool {
        let wanted = self.wanted();
        wanted.contains(&study) || wanted.contains(&StudyArg::All)
    }

    fn studies(&self) -> Vec<Study> {
        let arg = |study| match study {
            Study::Motor => StudyArg::Motor,
            Study::Payload => StudyArg::Payload,
            Study::Noise => StudyArg::Noise,
            Study::TipLoad => StudyArg::TipLoad,
        };
        STUDIES
            .into_iter()
            .filter(|s| self.wants(arg(*s)))
            .collect()
    }
}

/// Robustness tables and comparisons of laws; fails when a cell failed, after the others have been printed.
pub fn tables(args: &TableArgs) -> Result<Verdict> {
    let (system, base, verdict) = args.machine.load_world(args.world)?;
    let mut failed = 0;
    let mut found = conditions(&system, &base);
    let comparisons = args.wanted().into_iter().filter(|s| s.compares_laws());
    let comparisons: Vec<_> = comparisons.collect();
    for study in args.wanted() {
        let fits = match args.world {
            World::Ideal => !study.is_of_real_world(),
            World::Real => study.compares_laws() || study == StudyArg::Surrogate,
            World::Bending => study.compares_laws() && !study.is_of_real_world(),
        };
        let (name, world) = (study.name(), args.world.to_possible_value());
        let world = world.expect("no value is skipped");
        anyhow::ensure!(
            fits,
            "--study {name} is not of the {} world",
            world.get_name()
        );
    }
    if !comparisons.is_empty() {
        let usual = match args.world {
            World::Bending => worlds::BENDING_SEEDS,
            World::Ideal | World::Real => worlds::REAL_SEEDS,
        };
        let seeds = args.seed..args.seed + args.seeds.unwrap_or(usual);
        let cases = worlds::cases(args.world, &system, seeds)?;
        for study in comparisons {
            found[study.name()] = compare(args, &system, &base, cases.list(), study)?;
        }
    }
    if args.wanted().contains(&StudyArg::Surrogate) {
        found["surrogate"] = in_the_loop(&system, &base)?;
    }
    if args.wants(StudyArg::Inertia) {
        let bar = bar(table::CELLS as u64, "runs", false);
        let cells = table::run(&system, &base, || bar.inc(1))?;
        bar.finish_and_clear();
        print(table::text(&cells) + "\n")?;
        if let Some(path) = &args.csv {
            let mut file = create(path)?;
            table::write_csv(&cells, &mut file)
                .and_then(|()| Ok(file.flush()?))
                .with_context(|| path.display().to_string())?;
        }
        failed += cells.iter().filter(|c| c.result.is_err()).count();
        found["inertia"] = cells.iter().map(inertia_json).collect();
    }
    for study in args.studies() {
        let cases = study.cases(&system, &base, args.seed)?;
        let bar = bar(robustness::count(&cases) as u64, "runs", false);
        let cells = robustness::run(&system, &base, study, &cases, || bar.inc(1))?;
        bar.finish_and_clear();
        print(robustness::text(&cells) + "\n")?;
        failed += cells.iter().filter(|c| c.result.is_err()).count();
        found[study.name()] = cells.iter().map(cell_json).collect();
    }
    write_json(args.json.as_deref(), &found)?;
    anyhow::ensure!(failed == 0, "{failed} cells failed");
    Ok(verdict)
}

/// The one-axis experiment.
pub fn run_testbed(args: &TestbedArgs) -> Result<Verdict> {
    anyhow::ensure!(
        args.lag.is_finite() && args.lag >= 0.0,
        "--lag must be finite and not negative"
    );
    let (machine, base, verdict) = args.machine.load()?;
    let path = args
        .testbed
        .clone()
        .unwrap_or_else(|| machine.path.with_file_name("Testbed.ssp"));
    let bed = args.machine.beside(&path)?;
    let run = |trials: &[testbed::Trial]| -> Result<Vec<testbed::Axis>> {
        let runs = testbed::run(&machine, &bed, &base, args.lag, trials);
        let axes: Result<Vec<_>> = runs.into_iter().collect();
        Ok(axes?.into_iter().flatten().collect())
    };
    let axes = run(&[testbed::CHECK])?;
    let lag = format!("load emulators with a lag of {} ms\n", 1e3 * args.lag);
    print(lag + &testbed::text(&axes))?;
    let unknown = run(&testbed::UNKNOWN_LOAD)?;
    print(format!("\n{}", testbed::unknown_load_text(&unknown)))?;
    let path = args
        .rig_testbed
        .clone()
        .unwrap_or_else(|| machine.path.with_file_name(rig_testbed::SYSTEM));
    let bed = args.machine.beside(&path)?;
    let rigs = rig_testbed::run(&machine, &bed, &base, args.lag, &testbed::UNKNOWN_LOAD)?;
    print(format!("\n{}", rig_testbed::text(&rigs)))?;
    for axis in &axes {
        if let Some(dir) = &args.csv_dir {
            write_course(
                axis,
                &dir.join(format!("{}_{}.csv", axis.trajectory, axis.axis)),
            )?;
        }
    }
    let mut found = conditions(&machine, &base);
    found["lag_s"] = args.lag.into();
    found["testbed"] = serde_json::to_value(&axes)?;
    found["testbed_unknown_load"] = serde_json::to_value(&unknown)?;
    found["testbed_rigs"] = serde_json::to_value(&rigs)?;
    write_json(args.json.as_deref(), &found)?;
    Ok(verdict)
}

fn write_course(axis: &testbed::Axis, path: &Path) -> Result<()> {
    let names = ["x desired", "x", "x_dot desired", "x_dot", "F desired", "F"];
    let mut file = CsvFile::create(path, &names.map(String::from))?;
    let course = &axis.course;
    for (k, t) in course.time.iter().enumerate() {
        let [x, v, f] =
            [&course.position, &course.velocity, &course.force].map(|c| [c[0][k], c[1][k]]);
        file.row(*t, &[x[0], x[1], v[0], v[1], f[0], f[1]])?;
    }
    file.finish()
}

/// Accompanying functions, bound and gain conditions.
pub fn run_stability(args: &StabilityArgs) -> Result<Verdict> {
    anyhow::ensure!(
        args.world != World::Bending,
        "--world bending: the accompanying functions need the plant's inertias, which only the ideal and the real world tell"
    );
    let (system, base, verdict) = args.machine.load_world(args.world)?;
    if args.world == World::Real {
        let rungs = stability::causes(&system, &base, args.inertia_scale)?;
        print(stability::causes_text(&rungs))?;
        let mut found = conditions(&system, &base);
        found["causes"] = serde_json::to_value(&rungs)?;
        write_json(args.json.as_deref(), &found)?;
        return Ok(verdict);
    }
    let bar = bar(stability::RUNS, "runs", false);
    let runs = stability::run(&system, &base, args.inertia_scale, || bar.inc(1));
    bar.finish_and_clear();
    let runs: Vec<_> = runs.into_iter().collect::<Result<_>>()?;
    let scale = format!("inertia x {}\n", args.inertia_scale);
    print(scale + &stability::text(&runs))?;
    let emla = MachineFile::of(&system, &base.settings)?.machine.emla.lift;
    let compliance = stability::compliance(&system, &base, &emla)?;
    print(runs[0].gains.unfitted_text(compliance, emla.L_d))?;
    let mut found = conditions(&system, &base);
    found["inertia_scale"] = args.inertia_scale.into();
    found["stability"] = serde_json::to_value(&runs)?;
    write_json(args.json.as_deref(), &found)?;
    Ok(verdict)
}

/// A long coupled run.
pub fn run_endurance(args: &EnduranceArgs) -> Result<Verdict> {
    let (system, base, verdict) = args.machine.load()?;
    anyhow::ensure!(
        base.stop.is_none(),
        "--stop-time: the length of the run is given by --steps"
    );
    let experiment = vary(
        &system,
        &base,
        &[
            ("mode", &args.mode),
            ("inertia_scale", &args.inertia_scale),
            ("lyapunov.inertia_scale", &args.inertia_scale),
        ],
    )?;
    let excursion = Excursion::new([args.edges[0], args.edges[1], args.edges[2]], args.period)?;
    print(Part::titles() + "\n")?;
    let each = |part: &Part| print(part.row() + "\n");
    let endurance = endurance::run(&system, &experiment, &excursion, args.steps, each)?;
    print(endurance.summary())?;
    endurance.check()?;
    Ok(verdict)
}

/// What the numbers were made under.
pub(super) fn conditions(system: &System, base: &Experiment) -> Value {
    let setting = |s: &Setting| format!("{}={}", system.name(s.port), s.value);
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "step_s": base.stepping.step,
        "schedule": format!("{:?}", base.stepping.schedule),
        "settings": base.settings.iter().map(setting).collect::<Vec<_>>(),
    })
}

fn inertia_json(c: &table::Cell) -> Value {
    let mut cell = json!({
        "trajectory": c.trajectory, "mode": c.mode, "inertia_scale": c.scale, "paper_adaptive_rmse_m": c.paper,
    });
    put_result(&mut cell, &c.result);
    cell
}

fn cell_json(c: &robustness::Cell) -> Value {
    let mut cell = json!({
        "trajectory": c.trajectory, "mode": c.mode, "case": c.case, "target_adaptive_rmse_m": c.study.target(),
    });
    put_result(&mut cell, &c.result);
    cell
}

fn put_result(cell: &mut Value, result: &Result<TipError>) {
    match result {
        Ok(tip) => {
            cell["rmse_m"] = tip.motion.rms().into();
            cell["max_m"] = tip.motion.max.into();
        }
        Err(error) => cell["error"] = format!("{error:#}").into(),
    }
}

pub fn create(path: &Path) -> Result<BufWriter<File>> {
    let file = File::create(path);
    let file = file.with_context(|| format!("`{}` cannot be written", path.display()))?;
    Ok(BufWriter::new(file))
}

pub fn write_json(path: Option<&Path>, value: &Value) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let mut file = create(path)?;
    serde_json::to_writer_pretty(&mut file, value)?;
    writeln!(file)?;
    file.flush().with_context(|| path.display().to_string())
}
