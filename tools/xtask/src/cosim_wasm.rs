//! The program `cosim-wasm`, whose crate is a workspace of its own, since wasmtime is many packages:
//! for `cargo xtask cosim-wasm`, `test --nightly` and `dist`.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use cargo_fmu::process::execute;

use crate::workspace::Workspace;

/// Name of the program, of its package and of its build folder.
pub const PROGRAM: &str = "cosim-wasm";

/// Its workspace.
pub fn workspace(workspace: &Workspace) -> Result<cargo_fmu::workspace::Workspace> {
    let folder = workspace.root.join("master").join(PROGRAM);
    let mut own = cargo_fmu::workspace::Workspace::containing(&folder)?;
    own.target = workspace.target.join(PROGRAM);
    Ok(own)
}

/// Builds it for this machine, next to `cosim`; its file.
pub fn build(workspace: &Workspace) -> Result<PathBuf> {
    let own = self::workspace(workspace)?;
    run(workspace, "build --release --locked")?;
    let [built, to] = [&own.target, &workspace.target].map(|all| all.join("release").join(PROGRAM));
    fs::create_dir_all(workspace.target.join("release"))?;
    fs::copy(&built, &to).with_context(|| to.display().to_string())?;
    Ok(to)
}

/// Formatting and clippy, which those of the other workspace leave out.
pub fn check(workspace: &Workspace) -> Result<()> {
    run(workspace, "fmt --check")?;
    run(
        workspace,
        "clippy --release --locked --all-targets -- -D warnings",
    )
}

fn run(workspace: &Workspace, arguments: &str) -> Result<()> {
    let own = self::workspace(workspace)?;
    let mut command = workspace.cargo(arguments.split(' '));
    command.current_dir(&own.root);
    execute(command.env("CARGO_TARGET_DIR", &own.target))
}
