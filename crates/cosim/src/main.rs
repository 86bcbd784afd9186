//! Command line of the co-simulation master.
#![forbid(unsafe_code)]

mod evaluation;
mod reporting;

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::{Args, Parser, Subcommand, ValueEnum};
use cosim::exchange::Exchange;
use cosim::master::{Grid, Schedule, Setting};
use cosim::noise::Noise;
use cosim::run::{Experiment, Outcome, parse_setting};
use cosim::signals::Signals;
use cosim::system::System;
use cosim::table;
use indicatif::{ProgressBar, ProgressStyle};

/// Run systems of FMUs: coupled experiments, the robustness table, the speed, the wiring.
#[derive(Parser)]
#[command(version, about, long_about = None)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run one experiment and print tip error, power residuals and speed
    Run(RunArgs),
    /// Run one trajectory with the three controllers and print their tip RMSE beside the paper's
    Compare(CompareArgs),
    /// Tip RMSE for parameter errors, noise and loads x trajectories x controllers, for inertia errors beside the paper's
    Table(evaluation::TableArgs),
    /// Write the evaluation as one HTML file with tables, plots and a 3-D animation
    Report(reporting::ReportArgs),
    /// One-axis experiment: lift and tilt actuator against load emulators that replay the forces of the machine
    Testbed(evaluation::TestbedArgs),
    /// Stability proof in numbers: accompanying functions, bound and excess, gain conditions
    Stability(evaluation::StabilityArgs),
    /// Energy of each actuator: electrical, losses by kind, work, regeneration, efficiency
    Energy(evaluation::EnergyArgs),
    /// Long run with a reference that never ends: memory, time, tracking and estimates; fails where one of them does not endure
    Endurance(evaluation::EnduranceArgs),
    /// Measure how many times faster than real time the coupled system runs, without recording
    Bench(BenchArgs),
    /// Show components, stages of the exchange and power bonds; reports algebraic loops
    Wiring(SystemArgs),
}

#[derive(Args)]
struct SystemArgs {
    /// System: a packed .ssp, or a .ssd with --fmu-dir [default: fmu/Manipulator.ssp in the cargo target directory]
    #[arg(long, value_name = "FILE")]
    system: Option<PathBuf>,
    /// Take the FMUs from this directory, by file name
    #[arg(long, value_name = "DIR")]
    fmu_dir: Option<PathBuf>,
    /// System structure to take from the packed system: `triangular_pd.ssd` [default: SystemStructure.ssd]
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Parameter set for the system, in the packed system (`resources/triangular.ssv`) or a file; repeatable, before all other options
    #[arg(long, value_name = "FILE")]
    parameters: Vec<PathBuf>,
}

#[derive(Args)]
struct GridArgs {
    /// Communication step H, s
    #[arg(long, default_value_t = 1e-3, value_name = "SECONDS")]
    step: f64,
    /// Stop time, s [default: the end of the motion where the controller tells it, else the default experiment of the system]
    #[arg(long, value_name = "SECONDS")]
    stop_time: Option<f64>,
    /// Order of stepping
    #[arg(long, value_enum, default_value_t = ScheduleArg::GaussSeidel)]
    schedule: ScheduleArg,
    /// With --schedule jacobi: pass first time derivatives of continuous signals instead of holding them
    #[arg(long)]
    input_derivatives: bool,
    /// Start value of any variable, repeatable, applied last; an enumeration item may be given by name
    #[arg(long = "set", value_name = "COMPONENT.VARIABLE=VALUE", value_parser = parse_setting)]
    settings: Vec<Setting>,
}

#[derive(Clone, Copy, ValueEnum)]
enum ScheduleArg {
    /// Components one after the other in the order of the system; later ones get the mean force of the step
    GaussSeidel,
    /// All components at once from the values at the communication point
    Jacobi,
}

#[derive(Args)]
struct ConditionArgs {
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular", "external"])]
    trajectory: Option<String>,
    /// Controller
    #[arg(long, value_parser = ["adaptive", "modular", "pd"])]
    mode: Option<String>,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR")]
    inertia_scale: Option<f64>,
}

#[derive(Args)]
struct RunArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    grid: GridArgs,
    /// Write signals at every communication point to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Signals for --csv, comma-separated, * as wildcard: `hdrm.tip.*,*.F` [default: all outputs]
    #[arg(long, value_delimiter = ',', value_name = "PATTERNS", requires = "csv")]
    signals: Vec<String>,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct CompareArgs {
    #[command(flatten)]
    system: SystemArgs,
    /// Reference trajectory
    #[arg(long, value_parser = ["cubic", "triangular"], default_value = "cubic")]
    trajectory: String,
    /// Factor on mass and inertia of every body of the manipulator (the controller keeps nominal ones)
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    inertia_scale: f64,
    #[command(flatten)]
    grid: GridArgs,
    /// Write all outputs of each run to TRAJECTORY_CONTROLLER.csv in this directory
    #[arg(long, value_name = "DIR")]
    csv_dir: Option<PathBuf>,
}

#[derive(Args)]
struct BenchArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    grid: GridArgs,
    /// Repetitions; the median is reported
    #[arg(long, default_value_t = 5)]
    repeat: usize,
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Run(args) => run(&args),
        Command::Compare(args) => compare(&args),
        Command::Table(args) => evaluation::tables(&args),
        Command::Report(args) => reporting::report(&args),
        Command::Testbed(args) => evaluation::run_testbed(&args),
        Command::Stability(args) => evaluation::run_stability(&args),
        Command::Energy(args) => evaluation::run_energy(&args),
        Command::Endurance(args) => evaluation::run_endurance(&args),
        Command::Bench(args) => bench(&args),
        Command::Wiring(args) => wiring(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

impl SystemArgs {
    fn load(&self) -> Result<System> {
        let path = self.system.clone().unwrap_or_else(|| {
            let target = std::env::var_os("CARGO_TARGET_DIR")
                .map_or_else(|| PathBuf::from("target"), PathBuf::from);
            target.join("fmu/Manipulator.ssp")
        });
        let hint = || {
            if self.system.is_none() {
                "run `cargo xtask pack` first, or name a --system"
            } else {
                "the system"
            }
        };
        let mut system =
            System::load_variant(&path, self.variant.as_deref(), self.fmu_dir.as_deref())
                .with_context(hint)?;
        self.parameters
            .iter()
            .try_for_each(|set| system.apply_set(set))?;
        Ok(system)
    }
}

impl GridArgs {
    fn grid(&self, system: &System) -> Result<Grid> {
        let schedule = match (self.schedule, self.input_derivatives) {
            (ScheduleArg::GaussSeidel, true) => {
                anyhow::bail!("--input-derivatives needs --schedule jacobi")
            }
            (ScheduleArg::GaussSeidel, false) => Schedule::GaussSeidel,
            (ScheduleArg::Jacobi, false) => Schedule::Jacobi,
            (ScheduleArg::Jacobi, true) => Schedule::JacobiDerivatives,
        };
        Ok(Grid {
            start: system.structure.start_time,
            step: self.step,
            schedule,
        })
    }
}

fn experiment(system: &System, conditions: &ConditionArgs, grid: &GridArgs) -> Result<Experiment> {
    let mut settings = Vec::new();
    let scale = conditions.inertia_scale.map(|s| s.to_string());
    for (variable, value) in [
        ("trajectory", &conditions.trajectory),
        ("mode", &conditions.mode),
        ("inertia_scale", &scale),
    ] {
        if let Some(value) = value {
            settings.push(system.setting(variable, value)?);
        }
    }
    settings.extend(grid.settings.iter().cloned());
    Ok(Experiment {
        grid: grid.grid(system)?,
        stop: grid.stop_time,
        settings,
        noise: Noise::default(),
    })
}

fn run(args: &RunArgs) -> Result<()> {
    let system = args.system.load()?;
    let experiment = experiment(&system, &args.conditions, &args.grid)?;
    let outcome = shown(
        &system,
        &experiment,
        &args.signals,
        args.csv.as_deref(),
        args.quiet,
    )?;
    print!("{}", outcome.summary());
    if let Some(path) = &args.csv {
        println!("signals written to {}", path.display());
    }
    Ok(())
}

/// Run with a progress bar and, where asked for, a CSV file.
fn shown(
    system: &System,
    experiment: &Experiment,
    patterns: &[String],
    csv: Option<&Path>,
    quiet: bool,
) -> Result<Outcome> {
    let mut signals = Signals::choose(system, patterns)?;
    let file = match csv {
        Some(path) => Some((
            &mut signals,
            BufWriter::with_capacity(1 << 16, create(path)?),
        )),
        None => None,
    };
    let bar = if quiet {
        ProgressBar::hidden()
    } else {
        bar(0, "steps")
    };
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let outcome = experiment.run(system, progress, file);
    bar.finish_and_clear();
    outcome
}

fn create(path: &Path) -> Result<File> {
    File::create(path).with_context(|| format!("`{}` cannot be written", path.display()))
}

fn compare(args: &CompareArgs) -> Result<()> {
    let system = args.system.load()?;
    let scale = args.inertia_scale.to_string();
    let mut rows = Vec::new();
    for mode in table::MODES {
        eprintln!(
            "{} trajectory, controller {mode}, inertia x {scale}",
            args.trajectory
        );
        let conditions = ConditionArgs {
            trajectory: Some(args.trajectory.clone()),
            mode: Some(mode.into()),
            inertia_scale: Some(args.inertia_scale),
        };
        let experiment = experiment(&system, &conditions, &args.grid)?;
        let csv = args
            .csv_dir
            .as_ref()
            .map(|dir| dir.join(format!("{}_{mode}.csv", args.trajectory)));
        rows.push((
            mode,
            shown(&system, &experiment, &[], csv.as_deref(), false)?,
            csv,
        ));
    }
    println!(
        "\ntip error over the {} trajectory, inertia x {scale}, H = {} s, in mm",
        args.trajectory, args.grid.step
    );
    println!(
        "{:<12}{:>10}{:>10}{:>14}{:>16}",
        "controller", "RMSE", "max", "paper, RMSE", "x real time"
    );
    for (mode, outcome, _) in &rows {
        let tip = outcome
            .tip
            .context("the system has no output `tip_error_norm`")?
            .motion;
        let paper = table::paper(&args.trajectory, args.inertia_scale, mode)
            .map_or("-".into(), |m| format!("{:.1}", 1e3 * m));
        println!(
            "{mode:<12}{:>10.4}{:>10.4}{paper:>14}{:>16.0}",
            1e3 * tip.rms(),
            1e3 * tip.max,
            outcome.real_time_factor()
        );
    }
    for (.., csv) in &rows {
        if let Some(path) = csv {
            println!("signals written to {}", path.display());
        }
    }
    Ok(())
}

fn bench(args: &BenchArgs) -> Result<()> {
    let system = args.system.load()?;
    let experiment = experiment(&system, &args.conditions, &args.grid)?;
    let (mut factors, mut simulated) = (Vec::new(), 0.0);
    for _ in 0..args.repeat.max(1) {
        let outcome =
            experiment.run(&system, |_, _| (), None::<(&mut Signals, BufWriter<File>)>)?;
        factors.push(outcome.real_time_factor());
        simulated = outcome.simulated;
    }
    factors.sort_by(f64::total_cmp);
    let (median, worst, best) = (
        factors[factors.len() / 2],
        factors[0],
        factors[factors.len() - 1],
    );
    println!(
        "coupled real-time factor: median {median:.1} of {} runs ({worst:.1} to {best:.1}), {simulated:.3} s in steps of {} s, {} instances, one thread",
        factors.len(),
        experiment.grid.step,
        system.structure.components.len()
    );
    Ok(())
}

fn wiring(args: &SystemArgs) -> Result<()> {
    let system = args.load()?;
    let wiring = system.wiring()?;
    for (c, fmu) in system.structure.components.iter().zip(&system.fmus) {
        println!(
            "{}: {} ({}), {} variables",
            c.name,
            c.source,
            fmu.description.model,
            fmu.description.variables.len()
        );
    }
    for (title, initialization) in [("initialization", true), ("communication point", false)] {
        println!(
            "\n{title}\n{}",
            Exchange::new(&wiring, initialization, |_| true)?
                .describe(&wiring)
                .trim_end()
        );
    }
    for link in wiring.links.iter().filter(|link| link.bond.is_some()) {
        println!(
            "\npower bond {} -> {}",
            wiring.name(link.from),
            wiring.name(link.to)
        );
    }
    Ok(())
}

fn bar(length: u64, unit: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let template = format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{elapsed}} elapsed, {{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
