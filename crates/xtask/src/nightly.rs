//! The nightly compiler, which sanitizers and fuzzing need.

use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::process::{execute, output};

use crate::workspace::Workspace;

/// Its cargo, in the root folder.
pub fn cargo(workspace: &Workspace) -> Command {
    let mut command = workspace.command("rustup");
    command.args(["run", "nightly", "cargo"]);
    command.env_remove("CARGO").env_remove("RUSTUP_TOOLCHAIN");
    command
}

/// Provides a component of the nightly toolchain through rustup, which does nothing where it is
/// installed.
pub fn component(workspace: &Workspace, name: &str) -> Result<()> {
    let mut rustup = workspace.command("rustup");
    rustup.args(["component", "add", "--toolchain", "nightly", name]);
    execute(&mut rustup)
        .context("this needs the nightly compiler: `rustup toolchain install nightly`")
}

/// The target triple of this machine: named, it keeps build scripts and macros free of sanitizers.
pub fn host(workspace: &Workspace) -> Result<String> {
    let text = output(workspace.command("rustc").arg("-vV"))?;
    let line = text.lines().find_map(|l| l.strip_prefix("host: "));
    line.map(ToString::to_string)
        .context("rustc -vV names no host")
}
