//! Measurements: one table of what everything costs, beside other engines measured in the same run;
//! or instruction counts against the recorded ones.

mod borders;
mod callgrind;
mod inputs;
pub mod instructions;
mod table;

use std::fs;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use cargo_fmu::process::output;
use clap::Args;
use inputs::{
    BenchInputs, COUPLED, COUPLED_RECORDED, PROGRAMS, TABLE_ON_ALL_CORES, TABLE_ON_ONE_CORE, build,
    overhead,
};
use serde::Deserialize;
use table::{Measurement, Row};

use crate::pack;
use crate::python::Python;
use crate::workspace::Workspace;

/// MuJoCo and Pinocchio.
const ENGINES: &str = "engines.py";

/// What to measure.
#[derive(Args)]
pub struct Options {
    /// Count instructions with valgrind's callgrind instead of timing, and compare with the
    /// recorded counts
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
    /// Only the two ratios that have an aim: the coupled step beside MuJoCo's RK4 step of the bare
    /// manipulator, and the border beside C
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
    /// `cosim bench --json`: its real-time factor becomes the time of a coupled step, under this
    /// name.
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
    fn run(&mut self) -> Result<Vec<Measurement>> {
        let start = Instant::now();
        let text = output(&mut self.command)?;
        let seconds = start.elapsed().as_secs_f64();
        let program = || self.command.get_program().display().to_string();
        match self.result {
            Measures::Rows => rows(&text).with_context(program),
            Measures::CoupledStep(name) => {
                Ok(vec![coupled_step(name, &text).with_context(program)?])
            }
            Measures::RunTime(name) => Ok(vec![Measurement {
                name: name.to_string(),
                unit: "s".to_string(),
                median: seconds,
                least: seconds,
            }]),
        }
    }
}

fn rows(text: &str) -> Result<Vec<Measurement>> {
    let rows = text.lines().map(|line| {
        serde_json::from_str(line).with_context(|| format!("`{line}` is no measurement in JSON"))
    });
    rows.collect()
}

fn coupled_step(name: &str, text: &str) -> Result<Measurement> {
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
    Ok(Measurement {
        name: name.to_string(),
        unit: "ns".to_string(),
        median: 1e9 * step_s / real_time_factor.median,
        least: 1e9 * step_s / real_time_factor.best,
    })
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
        jobs = vec![coupled_job(workspace, &built, COUPLED)];
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

/// How long a step of the coupled machine takes.
fn coupled_job(workspace: &Workspace, built: &BenchInputs, name: &'static str) -> Job {
    let mut command = built.coupled(workspace);
    command.args(["--stop-time", "10", "--repeat", "3", "--json"]);
    let result = Measures::CoupledStep(name);
    Job { command, result }
}

/// What needs cargo and a C compiler only.
fn all_jobs(workspace: &Workspace, built: &BenchInputs) -> Result<Vec<Job>> {
    let mut jobs: Vec<Job> = Vec::new();
    for name in PROGRAMS {
        jobs.push(workspace.command(built.program(name)?).into());
    }
    jobs.push(coupled_job(workspace, built, COUPLED));
    let mut recorded = coupled_job(workspace, built, COUPLED_RECORDED);
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

/// Scripts of `tests/bench`: other engines, the FMPy master, and what loading costs.
fn python_jobs(workspace: &Workspace, built: &BenchInputs, scripts: &[&str]) -> Result<Vec<Job>> {
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
