//! Everything that CI checks, in one run.

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::bench::instructions;
use crate::python::Python;
use crate::workspace::{Workspace, execute};
use crate::{describe, importers, libclang, pack, torture};

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
    let fmi_sim = importers::fmi_sim(workspace, &environment)
        .inspect_err(|e| println!("fmi-sim could not be installed, its tests are skipped: {e:#}"));
    step("instruction counts", || {
        if instructions::is_possible() {
            return instructions::check(workspace);
        }
        println!("no valgrind: not counted");
        Ok(())
    })?;
    step("pytest", || pytest(workspace, fmi_sim.ok()))?;
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

fn pytest(workspace: &Workspace, fmi_sim: Option<PathBuf>) -> Result<()> {
    let requirements = workspace.root.join("tests/requirements.txt");
    let requirements =
        fs::read_to_string(&requirements).with_context(|| requirements.display().to_string())?;
    let python = Python::provide(workspace)?;
    python.install(workspace, "tests", &requirements)?;
    let mut command = workspace.command(python.program());
    execute(
        command
            .args(["-m", "pytest", "tests"])
            .env("FMU_DIR", workspace.fmu_dir())
            .envs(fmi_sim.map(|program| ("FMI_SIM", program))),
    )
}
