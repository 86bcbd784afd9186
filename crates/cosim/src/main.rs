//! Command line of the co-simulation master.
#![forbid(unsafe_code)]

mod describe;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::parser::ValueSource;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use cosim::cli::{CsvArgs, RunArgs, SystemArgs, bar, exit, print};
use cosim::exchange::{Exchange, Order};
use cosim::input_table::InputTable;
use cosim::package::read;
use cosim::run;
use cosim::signals::connected;
use cosim::system::System;
use cosim::verdict::Verdict;
use fmu_description::Archive;

/// Run a system of FMUs: as its SSP system structure says, or its speed, or its wiring.
#[derive(Parser)]
#[command(version, about, long_about = None)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run the system and print power residuals and speed
    Run(OneRunArgs),
    /// Measure how many times faster than real time the system runs
    Bench(BenchArgs),
    /// Show components, stages of the exchange and power bonds; reports algebraic loops
    Wiring(SystemArgs),
    /// List the variables of FMUs, what the FMUs can do and the platforms that they have libraries
    /// for
    Info(InfoArgs),
}

#[derive(Args)]
struct InfoArgs {
    /// FMUs
    #[arg(required = true, value_name = "FMU")]
    files: Vec<PathBuf>,
}

#[derive(Args)]
struct OneRunArgs {
    /// One or several FMUs in place of a system; or a system, as with --system
    #[arg(value_name = "FILE", conflicts_with = "system")]
    files: Vec<PathBuf>,
    /// Connection between these FMUs, from an output to an input; repeatable
    #[arg(long, value_name = "A.Y=B.U", requires = "files")]
    connect: Vec<String>,
    /// Values over time for inputs that no connection drives: a CSV file whose columns are `time`
    /// and `component.variable`
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    csv: CsvArgs,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
    /// Whether the command line says the step.
    #[arg(skip)]
    is_step_given: bool,
}

#[derive(Args)]
struct BenchArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    csv: CsvArgs,
    /// Repetitions; the median is reported
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Print the numbers as one line of JSON
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let matches = Cli::command().get_matches();
    let mut command = match Cli::from_arg_matches(&matches) {
        Ok(cli) => cli.command,
        Err(error) => error.exit(),
    };
    let of_command = matches.subcommand().map(|(_, matches)| matches);
    if let Command::Run(args) = &mut command {
        let source = of_command.and_then(|matches| matches.value_source("step"));
        args.is_step_given = source == Some(ValueSource::CommandLine);
    }
    // What FMUs print must not get into what this program prints; where that cannot be had, it runs
    // all the same.
    let _ = cosim::output::separate();
    let check = matches!(&command, Command::Run(args) if args.run.check);
    let result = match command {
        Command::Run(args) => run_system(&args),
        Command::Bench(args) => bench(&args),
        Command::Wiring(args) => wiring(&args),
        Command::Info(args) => info(&args),
    };
    exit(result, check)
}

fn load(args: &SystemArgs) -> Result<System> {
    args.load(|| bail!("name a system: --system FILE, a packed .ssp or a .ssd"))
}

/// The system of a run: FMUs by themselves, or a system.
fn system_of(args: &OneRunArgs) -> Result<System> {
    match args.files.as_slice() {
        [] => load(&args.system),
        [file] if file.extension().is_some_and(|e| e == "ssp" || e == "ssd") => {
            let system = Some(file.clone());
            load(&SystemArgs {
                system,
                ..args.system.clone()
            })
        }
        files => System::of_fmus(files, &args.connect),
    }
}

fn run_system(args: &OneRunArgs) -> Result<Verdict> {
    let system = system_of(args)?;
    let mut run = args.run.clone();
    let preferred = run.prefer(&system, args.is_step_given);
    let experiment = run.experiment(&system)?;
    let mut verdict = run.forgotten(&system, &experiment)?;
    verdict.extend(preferred);
    let stop = experiment.stop(&system)?;
    let mut master = experiment.start(&system)?;
    if let Some(file) = &args.input {
        master.feed(InputTable::load(file, &system)?)?;
    }
    let mut log = args.csv.log(&system, &experiment, || connected(&system))?;
    let bar = bar(0, "steps", args.quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let outcome = run::run(&system, master, stop, &progress, |master| {
        log.as_mut().map_or(Ok(()), |log| log.add(master))
    });
    bar.finish_and_clear();
    let outcome = outcome?;
    log.map_or(Ok(()), |log| log.finish())?;
    verdict.extend(outcome.verdict.clone());
    print(format_args!("{}{verdict}", outcome.summary()))?;
    if let Some(path) = &args.csv.csv {
        print(format_args!("signals written to {}\n", path.display()))?;
    }
    Ok(verdict)
}

fn bench(args: &BenchArgs) -> Result<Verdict> {
    let system = load(&args.system)?;
    let experiment = args.run.experiment(&system)?;
    let stop = experiment.stop(&system)?;
    let mut outcomes = Vec::new();
    for _ in 0..args.repeat.max(1) {
        let master = experiment.start(&system)?;
        let mut log = args.csv.log(&system, &experiment, || connected(&system))?;
        outcomes.push(run::run(&system, master, stop, &|_, _| (), |master| {
            log.as_mut().map_or(Ok(()), |log| log.add(master))
        })?);
        log.map_or(Ok(()), |log| log.finish())?;
    }
    outcomes.sort_by(|a, b| a.real_time_factor().total_cmp(&b.real_time_factor()));
    let (worst, best) = (&outcomes[0], &outcomes[outcomes.len() - 1]);
    let median = &outcomes[outcomes.len() / 2];
    let (runs, simulated) = (outcomes.len(), median.simulated);
    let instances = system.structure.components.len();
    let step = experiment.stepping.step;
    let [median, worst, best] = [median, worst, best].map(run::Outcome::real_time_factor);
    if args.json {
        print(format_args!(
            "{{\"real_time_factor\":{{\"median\":{median},\"worst\":{worst},\"best\":{best}}},\"runs\":{runs},\
             \"simulated_s\":{simulated},\"step_s\":{step},\"instances\":{instances}}}\n"
        ))?;
    } else {
        print(format_args!(
            "coupled real-time factor: median {median:.1} of {runs} runs ({worst:.1} to {best:.1}), {simulated:.3} s in steps of {step} s, \
             {instances} instances, one thread\n"
        ))?;
    }
    Ok(Verdict::default())
}

fn info(args: &InfoArgs) -> Result<Verdict> {
    let mut text = String::new();
    for file in &args.files {
        let context = || format!("`{}`", file.display());
        let mut archive = Archive::open(read(file)?).with_context(context)?;
        let description = archive.description().with_context(context)?;
        text += &describe::fmu(&file.display().to_string(), &description, archive.names());
    }
    print(text)?;
    Ok(Verdict::default())
}

fn wiring(args: &SystemArgs) -> Result<Verdict> {
    let system = load(args)?;
    let wiring = system.wiring()?;
    let mut text = String::new();
    for (c, fmu) in system.structure.components.iter().zip(&system.fmus) {
        let (model, count) = (&fmu.description.model, fmu.description.variables.len());
        writeln!(
            text,
            "{}: {} ({model}), {count} variables",
            c.name, c.source
        )?;
    }
    for (title, order) in [
        ("initialization", Order::Initialization),
        ("communication point", Order::Stages),
    ] {
        let exchange = Exchange::new(&wiring, order, |_| true).context(title)?;
        writeln!(text, "\n{title}\n{}", exchange.describe(&wiring).trim_end())?;
    }
    for link in wiring.links.iter().filter(|link| link.bond.is_some()) {
        let (from, to) = (wiring.name(link.from), wiring.name(link.to));
        writeln!(text, "\npower bond {from} -> {to}")?;
    }
    let forgotten = system.forgotten(&[])?;
    for (title, names) in [
        ("connectors that the FMUs do not have", forgotten.connectors),
        (
            "input connectors that nothing drives or sets",
            forgotten.inputs,
        ),
        (
            "inputs that the system does not mention",
            forgotten.unmentioned,
        ),
    ] {
        if !names.is_empty() {
            writeln!(text, "\n{title}: {}", names.join(", "))?;
        }
    }
    print(text)?;
    Ok(Verdict::default())
}
