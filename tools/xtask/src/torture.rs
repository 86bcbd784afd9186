//! Robustness, by the script `tests/robustness.py`: random calls, sanitizers, valgrind, threads,
//! fuzzing and long runs on the FMUs.

use anyhow::Result;
use cargo_fmu::process::execute;
use clap::Args;

use crate::workspace::Workspace;

/// Options of `cargo xtask torture`.
#[derive(Args)]
pub struct Options {
    /// Those of the script; `--help` lists them
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "OPTIONS"
    )]
    options: Vec<String>,
}

/// Do what the options say.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    script(workspace, &options.options)
}

/// What CI does, on the FMUs as they are packed.
pub fn check(workspace: &Workspace) -> Result<()> {
    script(workspace, &["--packed".into()])
}

fn script(workspace: &Workspace, options: &[String]) -> Result<()> {
    let mut script = workspace.command("python3");
    execute(script.arg("tests/robustness.py").args(options))
}
