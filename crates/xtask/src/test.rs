//! Everything that CI checks, in one run.

use std::fs;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::python::Python;
use crate::workspace::{Workspace, execute};
use crate::{describe, libclang, pack, torture};

/// Run all checks; the first that fails ends it.
pub fn run(workspace: &Workspace) -> Result<()> {
    let environment = libclang::provide(workspace)?;
    let cargo = |arguments: &[&str], more: &[(&str, &str)]| {
        let mut command = workspace.cargo(arguments.iter().copied());
        execute(
            command
                .envs(environment.iter().cloned())
                .envs(more.iter().copied()),
        )
    };
    step("format", || cargo(&["fmt", "--all", "--check"], &[]))?;
    step("clippy", || {
        cargo(
            &[
                "clippy",
                "--workspace",
                "--all-targets",
                "--locked",
                "--",
                "-D",
                "warnings",
            ],
            &[],
        )
    })?;
    step("tests", || cargo(&["test", "--workspace", "--locked"], &[]))?;
    step("documentation", || {
        cargo(
            &["doc", "--workspace", "--no-deps", "--locked"],
            &[("RUSTDOCFLAGS", "-D warnings")],
        )
    })?;
    step("model descriptions", || describe::run(workspace, true))?;
    step("pack", || pack::suite(workspace, &workspace.fmu_dir()))?;
    step("torture", || torture::check(workspace))?;
    step("pytest", || pytest(workspace))?;
    println!("all checks passed");
    Ok(())
}

fn step(name: &str, check: impl FnOnce() -> Result<()>) -> Result<()> {
    println!("==> {name}");
    let clock = Instant::now();
    check().with_context(|| format!("check `{name}`"))?;
    println!(
        "==> {name}: passed in {:.0} s",
        clock.elapsed().as_secs_f64()
    );
    Ok(())
}

fn pytest(workspace: &Workspace) -> Result<()> {
    let requirements = workspace.root.join("tests/requirements.txt");
    let requirements =
        fs::read_to_string(&requirements).with_context(|| requirements.display().to_string())?;
    let python = Python::provide(workspace)?;
    python.install(workspace, "tests", &requirements)?;
    let mut command = workspace.command(python.program());
    execute(
        command
            .args(["-m", "pytest", "tests"])
            .env("FMU_DIR", workspace.fmu_dir()),
    )
}
