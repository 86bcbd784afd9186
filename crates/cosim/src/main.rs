//! Command line of the co-simulation master.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::{Args, Parser, Subcommand};
use cosim::cli::{RunArgs, SystemArgs, bar, create, exit};
use cosim::exchange::Exchange;
use cosim::run;
use cosim::signals::{CsvLog, Signals, matching, titles};
use cosim::system::System;

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
    Run(SignalArgs),
    /// Measure how many times faster than real time the system runs, without recording
    Bench(BenchArgs),
    /// Show components, stages of the exchange and power bonds; reports algebraic loops
    Wiring(SystemArgs),
}

#[derive(Args)]
struct SignalArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: RunArgs,
    /// Write signals at every communication point to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Signals for --csv, comma-separated, * as wildcard: `mass.*,*.F` [default: all outputs]
    #[arg(long, value_delimiter = ',', value_name = "PATTERNS", requires = "csv")]
    signals: Vec<String>,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct BenchArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: RunArgs,
    /// Repetitions; the median is reported
    #[arg(long, default_value_t = 5)]
    repeat: usize,
}

fn main() -> ExitCode {
    exit(match Cli::parse().command {
        Command::Run(args) => run_system(&args),
        Command::Bench(args) => bench(&args),
        Command::Wiring(args) => wiring(&args),
    })
}

fn load(args: &SystemArgs) -> Result<System> {
    args.load(|| bail!("name a system: --system FILE.ssp, or --system FILE.ssd --fmu-dir DIR"))
}

fn run_system(args: &SignalArgs) -> Result<()> {
    let system = load(&args.system)?;
    let experiment = args.run.experiment(&system)?;
    let stop = experiment.stop(&system)?;
    let master = experiment.start(&system)?;
    let bar = bar(0, "steps", args.quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let ports = matching(&system, &args.signals)?;
    let outcome = match &args.csv {
        None => run::run(master, stop, &progress, |_| Ok(()))?,
        Some(path) => {
            let mut signals = Signals::new(&system, &ports)?;
            let mut log = CsvLog::new(create(path)?, &titles(&system, &ports))?;
            let outcome = run::run(master, stop, &progress, |master| {
                log.row(master.time(), signals.read(master)?)
            })?;
            log.finish()?;
            outcome
        }
    };
    bar.finish_and_clear();
    print!("{}", outcome.summary());
    if let Some(path) = &args.csv {
        println!("signals written to {}", path.display());
    }
    Ok(())
}

fn bench(args: &BenchArgs) -> Result<()> {
    let system = load(&args.system)?;
    let experiment = args.run.experiment(&system)?;
    let stop = experiment.stop(&system)?;
    let (mut factors, mut simulated) = (Vec::new(), 0.0);
    for _ in 0..args.repeat.max(1) {
        let master = experiment.start(&system)?;
        let outcome = run::run(master, stop, &|_, _| (), |_| Ok(()))?;
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
        experiment.stepping.step,
        system.structure.components.len()
    );
    Ok(())
}

fn wiring(args: &SystemArgs) -> Result<()> {
    let system = load(args)?;
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
