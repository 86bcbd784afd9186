//! `cargo xtask bench`: builds what is measured, and runs the script `tests/bench/measure.py`. It
//! prints one table of costs, with other engines measured in the same run, or compares instruction
//! counts with the recorded ones, as `test` does too.

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
    /// Only the two ratios that have a target: the coupled step over MuJoCo's RK4 step of the bare
    /// manipulator, and calls of our FMUs over those of one in C
    #[arg(long, conflicts_with_all = ["no_python", "instructions"])]
    ratios: bool,
}

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

/// Whether valgrind is installed, which counts the instructions.
pub fn can_count() -> bool {
    output(Command::new("valgrind").arg("--version")).is_ok()
}

/// Counts and prints instructions of packed FMUs; fails if a count has grown too much.
pub fn check_instructions(workspace: &Workspace, fmus: &[PathBuf]) -> Result<()> {
    let python = Python::provide(workspace)?;
    execute(&mut script(workspace, &python, "instructions", fmus)?)
}

/// Builds all that the script needs; the script with its arguments.
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
