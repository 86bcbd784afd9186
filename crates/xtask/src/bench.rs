//! Measurements: one table of what everything costs, beside other engines measured in the same run; or instruction
//! counts against the recorded ones.

mod borders;
pub mod instructions;
mod table;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use cargo_fmu::process::{execute, output};
use cargo_fmu::workspace::Source;
use cargo_fmu::{archive, library, platform};
use clap::Args;
use serde::Deserialize;
use table::{Measured, Row};

use crate::pack;
use crate::python::Python;
use crate::workspace::{FMU_PROFILE, Workspace};

/// Bench programs of the crates (`crates/*/benches`).
const PROGRAMS: [&str; 3] = ["dynamics", "step", "controller"];

/// MuJoCo and Pinocchio.
const ENGINES: &str = "engines.py";

/// The coupled machine under the native master.
const COUPLED: &str = "coupled step of 1 ms, cosim, no recording";
const COUPLED_RECORDED: &str = "coupled step of 1 ms, cosim with CSV";

/// The paper's table, 30 runs; its ratio to the one below is the gain by the cores of the machine.
const TABLE_ON_ALL_CORES: &str = "hdrm-fmu table, all cores";
const TABLE_ON_ONE_CORE: &str = "hdrm-fmu table, one core";

/// Three calls at the border, which cost what the border costs.
const BORDER_IN_RUST: &str = "set of 4 + step + get of 4, Rust (fmu-export)";
const BORDER_IN_C: &str = "set of 4 + step + get of 4, C by hand";

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
    /// Only the two ratios that have an aim: the coupled step beside MuJoCo's RK4 step of the bare manipulator, and the border beside C
    #[arg(long, conflicts_with_all = ["no_python", "instructions"])]
    ratios: bool,
}

/// A program to be run once a round.
struct Job {
    command: Command,
    result: Measures,
}

/// How the result of a program becomes rows of the table.
enum Measures {
    /// It prints a line of JSON for each row.
    Rows,
    /// `cosim bench --json`: its real-time factor becomes the time of a coupled step, under this name.
    CoupledStep(&'static str),
    /// Its whole run time, under this name.
    RunTime(&'static str),
}

impl From<Command> for Job {
    fn from(command: Command) -> Self {
        Self {
            command,
            result: Measures::Rows,
        }
    }
}

impl Job {
    fn run(&mut self) -> Result<Vec<Measured>> {
        let start = Instant::now();
        let text = output(&mut self.command)?;
        let seconds = start.elapsed().as_secs_f64();
        let program = || self.command.get_program().display().to_string();
        match self.result {
            Measures::Rows => rows(&text).with_context(program),
            Measures::CoupledStep(name) => {
                Ok(vec![coupled_step(name, &text).with_context(program)?])
            }
            Measures::RunTime(name) => Ok(vec![Measured {
                name: name.to_string(),
                unit: "s".to_string(),
                median: seconds,
                least: seconds,
            }]),
        }
    }
}

fn rows(text: &str) -> Result<Vec<Measured>> {
    let rows = text.lines().map(|line| {
        serde_json::from_str(line).with_context(|| format!("`{line}` is no measurement in JSON"))
    });
    rows.collect()
}

fn coupled_step(name: &str, text: &str) -> Result<Measured> {
    #[derive(Deserialize)]
    struct Coupled {
        real_time_factor: Factor,
        step_s: f64,
    }
    #[derive(Deserialize)]
    struct Factor {
        median: f64,
        best: f64,
    }
    let Coupled {
        real_time_factor,
        step_s,
    } = serde_json::from_str(text)?;
    Ok(Measured {
        name: name.to_string(),
        unit: "ns".to_string(),
        median: 1e9 * step_s / real_time_factor.median,
        least: 1e9 * step_s / real_time_factor.best,
    })
}

/// Built programs and packed FMUs.
struct Built {
    programs: BTreeMap<String, PathBuf>,
    cosim: PathBuf,
    hdrm_fmu: PathBuf,
    /// The suite.
    fmus: Vec<PathBuf>,
    /// Where it lies, with its systems.
    folder: PathBuf,
}

/// Measure.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let fmus = pack::suite(workspace, &workspace.fmu_dir())?;
    match options {
        Options { record: true, .. } => return instructions::record(workspace, fmus),
        Options {
            instructions: true, ..
        } => return instructions::check(workspace, fmus),
        _ => {}
    }
    let mut jobs: Vec<Job>;
    if options.ratios {
        let built = build(workspace, fmus, &[])?;
        jobs = vec![built.coupled_step(workspace, COUPLED)];
        jobs.extend(overhead(workspace)?.map(Job::from));
        jobs.extend(python_jobs(workspace, &built, &[ENGINES])?);
    } else {
        let built = build(workspace, fmus, &PROGRAMS)?;
        jobs = all_jobs(workspace, &built)?;
        if !options.no_python {
            let scripts = [ENGINES, "fmpy_coupled.py", "footprint.py"];
            jobs.extend(python_jobs(workspace, &built, &scripts)?);
        }
    }
    let mut rows: Vec<Row> = Vec::new();
    for round in 1..=options.rounds.max(1) {
        for job in &mut jobs {
            eprintln!("round {round}: {}", job.command.get_program().display());
            for measured in job.run()? {
                table::note(&mut rows, measured);
            }
        }
    }
    print!("{}", table::table(&rows));
    Ok(())
}

/// Build these bench programs of the crates, and the other programs, for packed FMUs.
fn build(workspace: &Workspace, fmus: Vec<PathBuf>, programs: &[&str]) -> Result<Built> {
    let folder = fmus.first().and_then(|fmu| fmu.parent());
    let folder = folder.context("no FMU was packed")?.to_path_buf();
    let targets: Vec<&str> = programs.iter().flat_map(|name| ["--bench", name]).collect();
    Ok(Built {
        programs: match targets.is_empty() {
            true => BTreeMap::new(),
            false => workspace.build(FMU_PROFILE, &targets)?,
        },
        cosim: workspace.build_programs(&["cosim"])?,
        hdrm_fmu: workspace.build_programs(&["hdrm-fmu"])?,
        fmus,
        folder,
    })
}

impl Built {
    fn program(&self, name: &str) -> Result<&Path> {
        let found = self.programs.get(name).map(PathBuf::as_path);
        found.with_context(|| format!("cargo has built no bench `{name}`"))
    }

    /// `cosim bench` on the packed system: the cubic trajectory, adaptive.
    fn coupled(&self, workspace: &Workspace) -> Command {
        let mut cosim = workspace.command(&self.cosim);
        let system = self.folder.join("Manipulator.ssp");
        cosim.args(["bench", "--system"]).arg(system);
        cosim.args(["--set", "controller.trajectory=cubic"]);
        cosim.args(["--set", "controller.mode=adaptive"]);
        cosim
    }

    /// How long a step of it takes.
    fn coupled_step(&self, workspace: &Workspace, name: &'static str) -> Job {
        let mut command = self.coupled(workspace);
        command.args(["--stop-time", "10", "--repeat", "3", "--json"]);
        let result = Measures::CoupledStep(name);
        Job { command, result }
    }
}

/// What needs cargo and a C compiler only.
fn all_jobs(workspace: &Workspace, built: &Built) -> Result<Vec<Job>> {
    let mut jobs: Vec<Job> = Vec::new();
    for name in PROGRAMS {
        jobs.push(workspace.command(built.program(name)?).into());
    }
    jobs.push(built.coupled_step(workspace, COUPLED));
    let mut recorded = built.coupled_step(workspace, COUPLED_RECORDED);
    recorded.command.args(["--signals", "*", "--csv"]);
    recorded.command.arg(workspace.target.join("bench.csv"));
    jobs.push(recorded);
    let table = |threads: Option<&str>, name| {
        let mut command = workspace.command(&built.hdrm_fmu);
        command.args(["table", "--system"]);
        command.arg(built.folder.join("Manipulator.ssp"));
        command.envs(threads.map(|number| ("RAYON_NUM_THREADS", number)));
        let result = Measures::RunTime(name);
        Job { command, result }
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
    let in_c = compiled(workspace, "integrators.c", &["-shared", "-fPIC"])?;
    let driver = compiled(workspace, "overhead.c", &["-ldl"])?;
    let in_rust = Source::Example("integrators".to_string());
    let in_rust = workspace.build_fmus(&[in_rust])?.remove(0);
    let guid = library::description(&library::files(&in_rust)?)?.guid;
    let job = |name: &str, library: &Path| {
        let mut command = workspace.command(&driver);
        command.arg(name).arg(library).arg(&guid);
        command
    };
    Ok([job(BORDER_IN_RUST, &in_rust), job(BORDER_IN_C, &in_c)])
}

/// The C program that makes instances of packed FMUs: the name of each, and the command.
fn instantiation(workspace: &Workspace, fmus: &[PathBuf]) -> Result<Vec<(String, Command)>> {
    let driver = compiled(workspace, "overhead.c", &["-ldl"])?;
    let job = |fmu: &PathBuf| {
        let library = library_in(workspace, fmu)?;
        let description = library::description(&library::files(&library)?)?;
        let mut command = workspace.command(&driver);
        command.arg(&description.model).arg(library);
        command.arg(description.guid);
        Ok((description.model, command))
    };
    fmus.iter().map(job).collect()
}

/// The library for this machine in a packed FMU, unpacked.
fn library_in(workspace: &Workspace, fmu: &Path) -> Result<PathBuf> {
    let entries = archive::read(fmu)?;
    let folder = format!("binaries/{}/", platform::host()?.folder);
    let library = entries
        .iter()
        .find_map(|(name, bytes)| Some((name.strip_prefix(&folder)?, bytes)));
    let (name, bytes) = library.with_context(|| format!("{folder} in {}", fmu.display()))?;
    let folder = workspace.target.join("bench");
    fs::create_dir_all(&folder)?;
    let path = folder.join(name);
    fs::write(&path, bytes).with_context(|| path.display().to_string())?;
    Ok(path)
}

/// A C source of `tests/bench`, compiled.
fn compiled(workspace: &Workspace, source: &str, options: &[&str]) -> Result<PathBuf> {
    let folder = workspace.target.join("bench");
    fs::create_dir_all(&folder)?;
    let program = folder.join(Path::new(source).with_extension("out"));
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_string());
    let mut cc = workspace.command(&compiler);
    cc.args(["-O2", "-o"]).arg(&program);
    cc.arg(workspace.root.join("tests/bench").join(source));
    execute(cc.args(options))?;
    Ok(program)
}

/// Scripts of `tests/bench`: other engines, the FMPy master, and what loading costs.
fn python_jobs(workspace: &Workspace, built: &Built, scripts: &[&str]) -> Result<Vec<Job>> {
    let folder = workspace.root.join("tests/bench");
    let requirements = fs::read_to_string(folder.join("requirements.txt"))?;
    let python = Python::provide(workspace)?;
    python.install(workspace, "bench", &requirements)?;
    let job = |script: &str| {
        let mut command = workspace.command(python.program());
        command.arg(folder.join(script)).arg(&built.folder);
        Job::from(command)
    };
    Ok(scripts.iter().map(|script| job(script)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_and_anything_else_is_an_error() {
        let line = r#"{"name":"x, y","unit":"ns","median":2.5,"least":1.5}"#;
        let [row] = &rows(line).unwrap()[..] else {
            panic!("one row");
        };
        assert_eq!(
            (row.name.as_str(), row.median, row.least),
            ("x, y", 2.5, 1.5)
        );
        assert!(rows("2.5 ns").is_err());
        let text = r#"{"real_time_factor":{"median":50.0,"worst":40.0,"best":80.0},"runs":3,"simulated_s":10,"step_s":0.001,"instances":5}"#;
        let step = coupled_step("step", text).unwrap();
        assert_eq!((step.median, step.least), (20_000.0, 12_500.0));
    }
}
