//! The program `cosim`: runs systems of FMUs, measures their speed, and shows their wiring and
//! variables.
#![forbid(unsafe_code)]

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail, ensure};
use clap::{Args, Parser, Subcommand};
use cosim::cli::{
    CsvArgs, InputArgs, RunArgs, StepArgs, SystemArgs, bar, claim_outputs, exit, keep_rows, place,
    print, serve_if_asked,
};
use cosim::describe::{self, DescribedFmu};
use cosim::exchange::{Exchange, Order};
use cosim::run::interrupt;
use cosim::run::signals::connected;
use cosim::run::simulate::{self, Experiment};
use cosim::run::verdict::Verdict;
use cosim::schedule::Stepping;
use cosim::stepping::StepControl;
use cosim::structure::package::{Package, read};
use cosim::structure::system::System;
use cosim::structure::{Structure, osp};
use cosim::wiring::probing::probe;
use fmi_description::{Archive, Causality};

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
    Run(Box<OneRunArgs>),
    /// Measure how many times faster than real time the system runs
    Bench(Box<BenchArgs>),
    /// Show components, stages of the exchange and power bonds; reports algebraic loops
    Wiring(Box<WiringArgs>),
    /// List the variables of FMUs and systems, what the FMUs can do and the platforms that they
    /// have libraries for
    Info(InfoArgs),
    /// Write a system of the Open Simulation Platform as a packed system of SSP, with its FMUs
    Convert(ConvertArgs),
}

#[derive(Args)]
struct InfoArgs {
    /// FMUs, and systems: a packed .ssp, a .ssd, an OspSystemStructure.xml or its folder
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Take the FMUs of systems from this directory, by file name
    #[arg(long, value_name = "DIR")]
    fmu_dir: Option<PathBuf>,
    /// System structure to take from packed systems
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Print a list with an object for each file
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct ConvertArgs {
    /// OspSystemStructure.xml, or a folder that holds one
    #[arg(value_name = "FILE")]
    system: PathBuf,
    /// Packed system to write
    #[arg(long, value_name = "FILE.ssp")]
    output: PathBuf,
    /// Take the FMUs from this directory, by file name
    #[arg(long, value_name = "DIR")]
    fmu_dir: Option<PathBuf>,
}

#[derive(Args)]
struct WiringArgs {
    #[command(flatten)]
    system: SystemArgs,
    /// Try in Initialization Mode which inputs act at once on which outputs: a hint, which no run
    /// uses
    #[arg(long = "try")]
    tries: bool,
}

#[derive(Args)]
struct OneRunArgs {
    /// One or several FMUs in place of a system, each a component named after its file, or with a
    /// name; or a system, as with --system
    #[arg(value_name = "[NAME=]FILE", conflicts_with = "system")]
    files: Vec<PathBuf>,
    /// Connection between these FMUs, from an output to an input; repeatable
    #[arg(long, value_name = "A.Y=B.U", requires = "files")]
    connect: Vec<String>,
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    steps: StepArgs,
    #[command(flatten)]
    inputs: InputArgs,
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
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    repeat: u64,
    /// Print the numbers as one line of JSON
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    if let Some(code) = serve_if_asked() {
        return code;
    }
    let command = Cli::parse().command;
    // Signals first: FMUs must not change how they are handled.
    let installed = interrupt::install();
    // Keeps what FMUs print out of this program's output; if that fails, it runs all the same.
    let _ = fmi_import::output::separate();
    let check = match &command {
        Command::Run(args) => args.run.check,
        Command::Bench(args) => args.run.check,
        Command::Wiring(_) | Command::Info(_) | Command::Convert(_) => false,
    };
    let prepared = (installed.map_err(Into::into)).and_then(|()| claim_outputs());
    let result = prepared.and_then(|()| match command {
        Command::Run(args) => run_system(&args),
        Command::Bench(args) => bench(&args),
        Command::Wiring(args) => wiring(&args),
        Command::Info(args) => info(&args),
        Command::Convert(args) => convert(&args),
    });
    exit(result, check)
}

fn load(args: &SystemArgs, start_values: &[String]) -> Result<System> {
    args.load(start_values, || {
        bail!("name a system: --system FILE, a packed .ssp or a .ssd")
    })
}

fn is_system(file: &Path) -> bool {
    let kinds = ["ssp", "ssd", "xml"];
    file.is_dir()
        || file
            .extension()
            .is_some_and(|e| kinds.iter().any(|kind| e == *kind))
}

/// The system of a run: one that is named, or FMUs by themselves.
fn load_system_or_fmus(args: &OneRunArgs) -> Result<System> {
    match args.files.as_slice() {
        [] => load(&args.system, &args.run.settings),
        [file] if is_system(file) => {
            if let Some(connection) = args.connect.first() {
                bail!(
                    "--connect {connection}: it is for FMUs without a structure; `{}` has its own connections",
                    file.display()
                );
            }
            let mut system = args.system.clone();
            system.system = Some(file.clone());
            load(&system, &args.run.settings)
        }
        files => (args.system).load_fmus(files, &args.connect, &args.run.settings),
    }
}

fn run_system(args: &OneRunArgs) -> Result<Verdict> {
    let system = load_system_or_fmus(args)?;
    let (mut experiment, mut verdict) = prepare(&system, &args.run, &args.inputs)?;
    verdict.extend(args.csv.notes(&system)?);
    let mut plan = args.steps.plan(&system, &experiment)?;
    experiment.stepping.repeats = plan.control.repeats();
    if args.run.threads.is_none() && plan.resume.is_none() {
        plan.threads_for = Some(experiment.clone());
    }
    let master = experiment.start_until(&system, plan.told_stop())?;
    let has_steps = plan.control != StepControl::Fixed;
    let useful = || connected(&system);
    let mut log = args.csv.log(&system, &experiment, has_steps, useful)?;
    let bar = bar(0, "steps", args.quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let outcome = simulate::run_plan(&system, master, &plan, &progress, &mut log);
    bar.finish_and_clear();
    let outcome = keep_rows(log, outcome)?;
    verdict.extend(outcome.verdict.clone());
    print(format_args!("{}{verdict}", outcome.summary()))?;
    if let Some(path) = &args.csv.csv {
        print(format_args!("signals written to {}\n", path.display()))?;
    }
    Ok(verdict)
}

/// Steps from which on a run may take long.
const MANY_STEPS: f64 = 5e4;

/// The experiment with these arguments, and the findings before it. Says before a run of many steps
/// why it has so many; the verdict says it again.
fn prepare(system: &System, run: &RunArgs, inputs: &InputArgs) -> Result<(Experiment, Verdict)> {
    let mut run = run.clone();
    let defaults = run.fill_defaults(system);
    let mut experiment = run.experiment(system)?;
    let altered = inputs.add_to(&mut experiment, system)?;
    let mut verdict = run.judge_gaps(system, &experiment)?;
    let Stepping { start, step, .. } = experiment.stepping;
    if (experiment.stop(system)? - start) / step > MANY_STEPS {
        (defaults.findings().iter()).for_each(|finding| eprintln!("{}", finding.text));
    }
    verdict.extend(defaults);
    verdict.extend(altered);
    Ok((experiment, verdict))
}

fn bench(args: &BenchArgs) -> Result<Verdict> {
    let system = load(&args.system, &args.run.settings)?;
    let (experiment, mut verdict) = prepare(&system, &args.run, &InputArgs::default())?;
    let stop = experiment.stop(&system)?;
    let mut outcomes = Vec::new();
    let useful = || connected(&system);
    for _ in 0..args.repeat {
        let master = experiment.start_until(&system, Some(stop))?;
        let mut log = args.csv.log(&system, &experiment, false, useful)?;
        let (plan, progress) = (simulate::Plan::to(stop), |_, _| ());
        let outcome = simulate::run_plan(&system, master, &plan, &progress, &mut log);
        outcomes.push(keep_rows(log, outcome)?);
    }
    outcomes.sort_by(|a, b| a.real_time_factor().total_cmp(&b.real_time_factor()));
    let runs = outcomes.len();
    let [worst, median, best] = [0, runs / 2, runs - 1].map(|k| outcomes[k].real_time_factor());
    let (simulated, step) = (outcomes[runs / 2].simulated, experiment.stepping.step);
    let instances = system.structure.components.len();
    let threads = match experiment.threads {
        1 => "one thread".into(),
        threads => format!("{threads} threads"),
    };
    if args.json {
        print(format_args!(
            "{{\"real_time_factor\":{{\"median\":{median},\"worst\":{worst},\"best\":{best}}},\"runs\":{runs},\
             \"simulated_s\":{simulated},\"step_s\":{step},\"instances\":{instances}}}\n"
        ))?;
    } else {
        print(format_args!(
            "coupled real-time factor: median {median:.1} of {runs} runs ({worst:.1} to {best:.1}), {simulated:.3} s in steps of {step} s, \
             {instances} instances, {threads}\n"
        ))?;
    }
    verdict.extend(outcomes.swap_remove(runs / 2).verdict);
    if verdict.is_bad() {
        eprint!("{verdict}");
    }
    Ok(verdict)
}

fn info(args: &InfoArgs) -> Result<Verdict> {
    let (mut text, mut list) = (String::new(), Vec::new());
    if !args.files.iter().any(|file| is_system(file)) {
        ensure!(
            args.fmu_dir.is_none(),
            "--fmu-dir is for systems; none is named"
        );
        ensure!(
            args.variant.is_none(),
            "--variant is for systems; none is named"
        );
    }
    for path in &args.files {
        let file = path.display().to_string();
        let context = || format!("`{file}`");
        if is_system(path) {
            let (structure, fmus) = read_system(path, args).with_context(context)?;
            list.push(describe::system_json(&file, &structure, &fmus));
            text += &describe::system(&file, &structure, &fmus);
        } else {
            let archive = Archive::open(read(path)?).with_context(context)?;
            let fmu = DescribedFmu::from_archive(file.clone(), archive).with_context(context)?;
            list.push(describe::fmu_json(&fmu));
            text += &describe::fmu(&fmu);
        }
    }
    match args.json {
        true => print(format_args!("{:#}\n", serde_json::Value::from(list)))?,
        false => print(text)?,
    }
    Ok(Verdict::default())
}

/// Reads a structure and the descriptions of its FMUs, each once; loads no library.
fn read_system(path: &Path, args: &InfoArgs) -> Result<(Structure, Vec<DescribedFmu>)> {
    let mut package = Package::open(path)?;
    let place = place(args.fmu_dir.as_deref())?;
    let structure = osp::read(&mut package, args.variant.as_deref(), &place, &[])?;
    let (mut fmus, mut seen) = (Vec::new(), BTreeSet::new());
    for component in &structure.components {
        if !seen.insert(&component.source) {
            continue;
        }
        let context = || format!("FMU of component `{}`", component.name);
        let bytes = place.read(&component.source, &mut package);
        let archive = Archive::open(bytes.with_context(context)?).with_context(context)?;
        let fmu = DescribedFmu::from_archive(component.source.clone(), archive);
        fmus.push(fmu.with_context(context)?);
    }
    Ok((structure, fmus))
}

fn convert(args: &ConvertArgs) -> Result<Verdict> {
    let place = place(args.fmu_dir.as_deref())?;
    let mut package = Package::open(&args.system)?;
    let mut verdict = Verdict::default();
    for remark in osp::convert(&mut package, &place, &args.output)? {
        verdict.note(remark);
    }
    print(format_args!(
        "packed system written to {}\n{verdict}",
        args.output.display()
    ))?;
    Ok(verdict)
}

fn wiring(args: &WiringArgs) -> Result<Verdict> {
    // `--try` makes instances, in processes of their own if that is wanted.
    let solver = [(!args.system.solvers.is_empty(), "--solver")];
    args.system.refuse_running(&solver, !args.tries)?;
    let system = load(&args.system, &[])?;
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
    if !wiring.clocks.is_empty() {
        writeln!(text, "\nticks of clocks, in Event Mode")?;
    }
    for ends in &wiring.clocks {
        let [from, to] = ends.map(|port| wiring.name(port));
        writeln!(text, "  {from} -> {to}")?;
    }
    let mut outputs = connected(&system)?;
    outputs.retain(|port| system.variable(*port).causality == Causality::Output);
    let [early, late] = [false, true].map(|is_late| {
        let own = outputs.iter();
        let own = own.filter(|p| wiring.is_read_once(**p) == is_late);
        own.map(|port| system.name(*port)).collect::<Vec<_>>()
    });
    text += &listed(
        "outputs read at once, after the inputs that they depend on",
        &early,
    );
    text += &listed(
        "outputs read late, right after the step, because they do not declare what they depend on",
        &late,
    );
    if args.tries {
        text += &probed(&system)?;
    }
    for link in wiring.links.iter().filter(|link| link.bond.is_some()) {
        let (from, to) = (wiring.name(link.from), wiring.name(link.to));
        writeln!(text, "\npower bond {from} -> {to}")?;
    }
    for (component, step) in &system.structure.rates {
        writeln!(text, "\n{component} has steps of its own: {step} s")?;
    }
    let gaps = system.find_gaps(&BTreeSet::new())?;
    text += &listed(
        "connectors that the FMUs do not have",
        &gaps.missing_connectors,
    );
    text += &listed(
        "input connectors that nothing drives or sets",
        &gaps.undriven_inputs,
    );
    text += &listed(
        "inputs that the system does not mention",
        &gaps.unmentioned_inputs,
    );
    print(text)?;
    Ok(Verdict::default())
}

/// A paragraph with these names; nothing if there are none.
fn listed(title: &str, names: &[String]) -> String {
    match names.is_empty() {
        true => String::new(),
        false => format!("\n{title}: {}\n", names.join(", ")),
    }
}

/// The outputs of each component that change at once with inputs, as text.
fn probed(system: &System) -> Result<String> {
    let mut text = "\ntried in Initialization Mode (a hint, which no run uses)\n".to_string();
    for (k, component) in system.structure.components.iter().enumerate() {
        let description = &system.fmus[k].description;
        let names = |inputs: &[usize]| {
            let names = inputs
                .iter()
                .map(|i| description.variables[*i].name.as_str());
            match inputs.is_empty() {
                true => "nothing".into(),
                false => Vec::from_iter(names).join(", "),
            }
        };
        let found = probe(system, k).with_context(|| component.name.clone())?;
        for (i, v) in description.variables.iter().enumerate() {
            if v.causality != Causality::Output || !v.access().is_number() {
                continue;
            }
            let acting = found.acting.get(&i);
            let acting: Vec<usize> = acting.into_iter().flatten().copied().collect();
            let declared = |initially| description.declared_feedthrough(i, initially);
            let declared = match (declared(false), declared(true).unwrap_or_default()) {
                (None, _) => "nothing is declared".to_string(),
                (_, inputs) if acting.iter().eq(inputs.iter().collect::<BTreeSet<_>>()) => {
                    "as declared".into()
                }
                (_, inputs) => format!("declared: {}", names(&inputs)),
            };
            let (owner, by) = (&component.name, names(&acting));
            writeln!(text, "  {owner}.{}: changed by {by} ({declared})", v.name)?;
        }
        if !found.refused.is_empty() {
            let refused: Vec<usize> = found.refused.into_iter().collect();
            let (owner, refused) = (&component.name, names(&refused));
            writeln!(text, "  {owner}: refuses other values of {refused}")?;
        }
    }
    Ok(text)
}
