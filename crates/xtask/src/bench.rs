//! Measurements: one table of what everything costs, beside other engines measured in the same run; or instruction
//! counts against the recorded ones.

pub mod instructions;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use cargo_fmu::library;
use cargo_fmu::process::{execute, output};
use cargo_fmu::workspace::Source;
use clap::Args;

use crate::python::Python;
use crate::workspace::{FMU_PROFILE, Workspace};
use crate::{libclang, pack};

/// Bench programs of the crates (`crates/*/benches`).
const PROGRAMS: [&str; 3] = ["dynamics", "step", "controller"];

/// Ours beside others, by the beginnings of the rows' names; the ratio is theirs over ours.
const COMPARISONS: [(&str, &str); 7] = [
    ("forward dynamics", "Pinocchio"),
    ("forward dynamics", "MuJoCo"),
    ("manipulator step of 1 ms (RK4)", "MuJoCo"),
    (
        "set of 4 + step + get of 4, Rust",
        "set of 4 + step + get of 4, C",
    ),
    ("coupled step of 1 ms, cosim,", "coupled step of 1 ms, FMPy"),
    (
        "coupled step of 1 ms, cosim,",
        "coupled step of 1 ms, cosim with CSV",
    ),
    (TABLE_ON_ALL_CORES, TABLE_ON_ONE_CORE),
];

/// The paper's table, 30 runs; its ratio to the one below is the gain by the cores of the machine.
const TABLE_ON_ALL_CORES: &str = "hdrm-fmu table, all cores";
const TABLE_ON_ONE_CORE: &str = "hdrm-fmu table, one core";

/// What to measure.
#[derive(Args)]
pub struct Options {
    /// Count instructions with valgrind's callgrind instead of timing, and compare with the recorded counts
    #[arg(long)]
    instructions: bool,
    /// With --instructions: record the counts
    #[arg(long, requires = "instructions")]
    record: bool,
    /// Rounds; each goes once through all measurements, and the table holds the medians
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Leave out what needs Python: MuJoCo, Pinocchio, FMPy, load times
    #[arg(long)]
    no_python: bool,
}

/// A program to be run once a round.
struct Job {
    command: Command,
    /// The row that gets its whole time; without a name it prints its rows itself.
    whole: Option<&'static str>,
}

impl From<Command> for Job {
    fn from(command: Command) -> Self {
        Self {
            command,
            whole: None,
        }
    }
}

/// Built programs and packed FMUs.
struct Built {
    programs: BTreeMap<String, PathBuf>,
    cosim: PathBuf,
    hdrm_fmu: PathBuf,
    fmus: PathBuf,
}

/// Values of one row, from all rounds.
#[derive(Default)]
struct Row {
    name: String,
    unit: String,
    medians: Vec<f64>,
    least: f64,
}

/// Measure.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    match options {
        Options { record: true, .. } => return instructions::record(workspace),
        Options {
            instructions: true, ..
        } => return instructions::check(workspace),
        _ => {}
    }
    let built = build(workspace)?;
    let mut jobs = jobs(workspace, &built)?;
    if !options.no_python {
        jobs.extend(python_jobs(workspace, &built)?);
    }
    let mut rows: Vec<Row> = Vec::new();
    for round in 1..=options.rounds.max(1) {
        for Job { command, whole } in &mut jobs {
            eprintln!("round {round}: {}", command.get_program().display());
            let start = Instant::now();
            let text = output(command)?;
            let seconds = start.elapsed().as_secs_f64();
            let printed = text.lines().filter_map(parse);
            let timed = whole.map(|name| (name, "s", seconds, seconds));
            for (name, unit, median, least) in printed.chain(timed) {
                note(&mut rows, name, unit, median, least);
            }
        }
    }
    print!("{}", table(&rows));
    Ok(())
}

fn build(workspace: &Workspace) -> Result<Built> {
    let fmus = workspace.fmu_dir();
    pack::suite(workspace, &fmus)?;
    let targets: Vec<&str> = PROGRAMS.iter().flat_map(|name| ["--bench", name]).collect();
    Ok(Built {
        programs: workspace.build(FMU_PROFILE, &targets, &[])?,
        cosim: libclang::build_cosim(workspace)?,
        hdrm_fmu: libclang::build_hdrm_fmu(workspace)?,
        fmus,
    })
}

impl Built {
    fn program(&self, name: &str) -> Result<&Path> {
        let found = self.programs.get(name).map(PathBuf::as_path);
        found.with_context(|| format!("cargo has built no bench `{name}`"))
    }

    /// `cosim` on the packed system: the cubic trajectory, adaptive.
    fn coupled(&self, workspace: &Workspace, command: &str) -> Command {
        let mut cosim = workspace.command(&self.cosim);
        let system = self.fmus.join("Manipulator.ssp");
        cosim.arg(command).arg("--system").arg(system);
        cosim.args(["--set", "controller.trajectory=cubic"]);
        cosim.args(["--set", "controller.mode=adaptive"]);
        cosim
    }
}

/// What needs cargo and a C compiler only.
fn jobs(workspace: &Workspace, built: &Built) -> Result<Vec<Job>> {
    let mut jobs: Vec<Job> = Vec::new();
    for name in PROGRAMS {
        jobs.push(workspace.command(built.program(name)?).into());
    }
    let mut bare = built.coupled(workspace, "bench");
    bare.args(["--stop-time", "10", "--repeat", "3"]);
    let mut recorded = built.coupled(workspace, "run");
    let csv = workspace.target.join("bench.csv");
    recorded
        .args(["--stop-time", "10", "--quiet", "--csv"])
        .arg(csv);
    jobs.extend([bare, recorded].map(Job::from));
    let table = |threads: Option<&str>, name| {
        let mut command = workspace.command(&built.hdrm_fmu);
        command.args(["table", "--system"]);
        command.arg(built.fmus.join("Manipulator.ssp"));
        command.envs(threads.map(|number| ("RAYON_NUM_THREADS", number)));
        Job {
            command,
            whole: Some(name),
        }
    };
    jobs.extend([
        table(Some("1"), TABLE_ON_ONE_CORE),
        table(None, TABLE_ON_ALL_CORES),
    ]);
    jobs.extend(overhead(workspace)?.map(Job::from));
    Ok(jobs)
}

/// The same FMU from Rust and from C under the same C program.
fn overhead(workspace: &Workspace) -> Result<[Command; 2]> {
    let folder = workspace.target.join("bench");
    fs::create_dir_all(&folder)?;
    let (driver, in_c) = (folder.join("overhead"), folder.join("integrators.so"));
    let sources = workspace.root.join("tests/bench");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_string());
    let compile = |out: &Path, source: &str, options: &[&str]| {
        let mut cc = workspace.command(&compiler);
        cc.args(["-O2", "-o"]).arg(out).arg(sources.join(source));
        execute(cc.args(options))
    };
    compile(&in_c, "integrators.c", &["-shared", "-fPIC"])?;
    compile(&driver, "overhead.c", &["-ldl"])?;
    let example = Source::Example("integrators".to_string());
    let in_rust = workspace.build_fmus(&[example])?.remove(0);
    let files = library::files(&in_rust)?;
    let guid = library::description(&files)?.guid;
    let job = |name: &str, library: &Path| {
        let mut command = workspace.command(&driver);
        command.arg(name).arg(library).arg(&guid);
        command
    };
    Ok([
        job("set of 4 + step + get of 4, Rust (fmu-export)", &in_rust),
        job("set of 4 + step + get of 4, C by hand", &in_c),
    ])
}

/// Other engines, the FMPy master, and what loading costs.
fn python_jobs(workspace: &Workspace, built: &Built) -> Result<Vec<Job>> {
    let folder = workspace.root.join("tests/bench");
    let requirements = fs::read_to_string(folder.join("requirements.txt"))?;
    let python = Python::provide(workspace)?;
    python.install(workspace, "bench", &requirements)?;
    let job = |script: &str| {
        let mut command = workspace.command(python.program());
        command.arg(folder.join(script)).arg(&built.fmus);
        Job::from(command)
    };
    Ok(["engines.py", "fmpy_coupled.py", "footprint.py"]
        .map(job)
        .into())
}

/// Name, unit, median and least value in a line of a bench program or of `cosim`.
fn parse(line: &str) -> Option<(&str, &str, f64, f64)> {
    /// Nanoseconds per step of 1 ms at a real-time factor.
    const NS: f64 = 1e6;
    if let Some(rest) = line.strip_prefix("coupled real-time factor: median ") {
        let median: f64 = rest.split(' ').next()?.parse().ok()?;
        let best: f64 = rest.split(" to ").nth(1)?.split(')').next()?.parse().ok()?;
        return Some((
            "coupled step of 1 ms, cosim, no recording",
            "ns",
            NS / median,
            NS / best,
        ));
    }
    if let Some(rest) = line.strip_suffix(" x real time") {
        let factor: f64 = rest.rsplit(' ').next()?.parse().ok()?;
        let name = "coupled step of 1 ms, cosim with CSV of all outputs";
        return Some((name, "ns", NS / factor, NS / factor));
    }
    let mut fields = line.split('\t');
    let (name, unit) = (fields.next()?, fields.next()?);
    let (median, least) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some((name, unit, median, least))
}

fn note(rows: &mut Vec<Row>, name: &str, unit: &str, median: f64, least: f64) {
    let known = rows.iter().position(|row| row.name == name);
    let at = known.unwrap_or_else(|| {
        rows.push(Row {
            name: name.to_string(),
            unit: unit.to_string(),
            medians: Vec::new(),
            least,
        });
        rows.len() - 1
    });
    let row = &mut rows[at];
    row.medians.push(median);
    row.least = row.least.min(least);
}

impl Row {
    fn median(&self) -> f64 {
        let mut sorted = self.medians.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }
}

fn table(rows: &[Row]) -> String {
    let mut lines = vec![
        machine(),
        format!(
            "| {:<72} | {:>12} | {:>12} | unit |",
            "measurement", "median", "least"
        ),
        format!("|:{:-<72}-|-{:->12}:|-{:->12}:|:-----|", "", "", ""),
    ];
    for row in rows {
        let (name, unit) = (&row.name, &row.unit);
        lines.push(format!(
            "| {name:<72} | {:>12.1} | {:>12.1} | {unit:<4} |",
            row.median(),
            row.least
        ));
    }
    lines.push(String::new());
    for (ours, theirs) in COMPARISONS {
        let Some(base) = rows.iter().find(|row| row.name.starts_with(ours)) else {
            continue;
        };
        for other in rows.iter().filter(|row| row.name.starts_with(theirs)) {
            let (median, least) = (other.median() / base.median(), other.least / base.least);
            lines.push(format!(
                "- {} / {}: {median:.2} (least: {least:.2})",
                other.name, base.name
            ));
        }
    }
    for row in rows.iter().filter(|row| row.name.contains(", cosim")) {
        let (median, best) = (1e6 / row.median(), 1e6 / row.least);
        lines.push(format!(
            "- {}: {median:.0} x real time (best: {best:.0})",
            row.name
        ));
    }
    lines.join("\n") + "\n"
}

/// Processor, load and compiler of this run.
fn machine() -> String {
    let first = |file: &str, key: &str| {
        let text = fs::read_to_string(file).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with(key));
        line.map(|l| l.rsplit(": ").next().unwrap_or(l).to_string())
    };
    let processor = first("/proc/cpuinfo", "model name").unwrap_or_else(|| "unknown".to_string());
    let load = first("/proc/loadavg", "").unwrap_or_default();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let rustc = output(Command::new("rustc").arg("--version")).unwrap_or_default();
    let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
    format!(
        "{processor}, {cores} cores, {os} {arch}, load average at the end: {load}; {}\n",
        rustc.trim()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_all_programs_are_understood() {
        assert_eq!(parse("x, y\tns\t2.5\t1.5"), Some(("x, y", "ns", 2.5, 1.5)));
        let (_, _, median, best) = parse(
            "coupled real-time factor: median 50.0 of 3 runs (40.0 to 80.0), 10.000 s in steps of 0.001 s, 5 instances",
        )
        .unwrap();
        assert_eq!((median, best), (20_000.0, 12_500.0));
        let (_, _, median, _) = parse("10.000 s simulated in 0.250 s: 40 x real time").unwrap();
        assert_eq!(median, 25_000.0);
        assert_eq!(parse("tip error, whole run: RMSE 0.1 mm"), None);
    }

    #[test]
    fn the_table_holds_medians_and_ratios() {
        let mut rows = Vec::new();
        for (ours, theirs) in [(3.0, 30.0), (1.0, 10.0), (2.0, 40.0)] {
            note(&mut rows, "forward dynamics", "ns", ours, ours);
            note(&mut rows, "Pinocchio tree", "ns", theirs, theirs);
        }
        let text = table(&rows);
        assert!(
            text.contains("Pinocchio tree / forward dynamics: 15.00 (least: 10.00)"),
            "{text}"
        );
    }
}
