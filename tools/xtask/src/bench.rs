//! Measurements, made by the script `tests/bench/measure.py` of what is built here: one table of
//! what everything costs, beside other engines measured in the same run; or instruction counts
//! against the recorded ones.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::process::{execute, output};
use cargo_fmu::workspace::Source;
use clap::Args;
use fmi_import::platform;

use crate::pack;
use crate::python::Python;
use crate::workspace::{FMU_PROFILE, Workspace};

/// Bench programs of the crates (`machine/*/benches`).
const PROGRAMS: [&str; 3] = ["dynamics", "step", "controller"];

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
    /// Leave out what needs Python packages: MuJoCo, Pinocchio, FMPy, load times
    #[arg(long)]
    no_python: bool,
    /// Only the two ratios that have an aim: the coupled step beside MuJoCo's RK4 step of the bare
    /// manipulator, and the border beside C
    #[arg(long, conflicts_with_all = ["no_python", "instructions"])]
    ratios: bool,
}

/// Measure.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let fmus = pack::suite(workspace, &workspace.fmu_dir())?;
    let python = Python::provide(workspace)?;
    let what = if options.instructions {
        "instructions"
    } else {
        if !options.no_python {
            python.install_file(workspace, "bench", "tests/bench/requirements.txt")?;
        }
        "time"
    };
    let mut script = script(workspace, &python, what, &fmus)?;
    script.args(["--rounds", &options.rounds.to_string()]);
    script.args(options.record.then_some("--record"));
    script.args(options.ratios.then_some("--ratios"));
    script.args(options.no_python.then_some("--no-python"));
    execute(&mut script)
}

/// Whether there is a valgrind to count instructions with.
pub fn can_count() -> bool {
    output(Command::new("valgrind").arg("--version")).is_ok()
}

/// Count instructions on packed FMUs, print, compare; fails where a count has grown too much.
pub fn check_instructions(workspace: &Workspace, fmus: &[PathBuf]) -> Result<()> {
    let python = Python::provide(workspace)?;
    execute(&mut script(workspace, &python, "instructions", fmus)?)
}

/// The script, with all that it needs built.
fn script(workspace: &Workspace, python: &Python, what: &str, fmus: &[PathBuf]) -> Result<Command> {
    let work = workspace.target.join("bench");
    let example = [Source::Example("integrators".into())];
    let integrators = pack::fmus(workspace, &example, FMU_PROFILE, &work)?;
    let mut script = workspace.command(python.program());
    script.args(["tests/bench/measure.py", what]);
    script.args(["--platform", platform::host()?.folder]);
    for fmu in fmus {
        script.arg("--fmu").arg(fmu);
    }
    let targets: Vec<_> = PROGRAMS.iter().flat_map(|name| ["--bench", name]).collect();
    let built = workspace.build(FMU_PROFILE, &targets)?;
    for name in PROGRAMS {
        let file = built.get(name);
        let file = file.with_context(|| format!("cargo has built no bench `{name}`"))?;
        script.args(["--program", &format!("{name}={}", file.display())]);
    }
    for name in ["cosim", "hdrm-fmu"] {
        let program = workspace.build_programs(&[name])?;
        script.arg(format!("--{name}")).arg(program);
    }
    script.arg("--integrators").arg(&integrators[0]);
    script.arg("--work").arg(work);
    Ok(script)
}
