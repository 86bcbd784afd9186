//! Command line of the co-simulation master.
#![forbid(unsafe_code)]

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::{Args, Parser, Subcommand};
use cosim::cli::{CsvArgs, RunArgs, SystemArgs, bar, exit, print};
use cosim::exchange::{Exchange, Order};
use cosim::run;
use cosim::system::System;
use cosim::verdict::Verdict;
use cosim::wiring::Port;

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
}

#[derive(Args)]
struct OneRunArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    csv: CsvArgs,
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
    let command = Cli::parse().command;
    let check = matches!(&command, Command::Run(args) if args.run.check);
    let result = match command {
        Command::Run(args) => run_system(&args),
        Command::Bench(args) => bench(&args),
        Command::Wiring(args) => wiring(&args),
    };
    exit(result, check)
}

fn load(args: &SystemArgs) -> Result<System> {
    args.load(|| bail!("name a system: --system FILE, a packed .ssp or a .ssd"))
}

fn run_system(args: &OneRunArgs) -> Result<Verdict> {
    let system = load(&args.system)?;
    let experiment = args.run.experiment(&system)?;
    let mut verdict = args.run.forgotten(&system, &experiment)?;
    let stop = experiment.stop(&system)?;
    let master = experiment.start(&system)?;
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

/// The outputs that connections pass on: what is written where no signals are named.
fn connected(system: &System) -> Result<Vec<Port>> {
    let mut ports: Vec<Port> = system.wiring()?.links.iter().map(|l| l.from).collect();
    ports.sort();
    ports.dedup();
    Ok(ports)
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
