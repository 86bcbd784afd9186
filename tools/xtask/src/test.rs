//! Everything that CI checks, in one run.

use std::path::PathBuf;

use anyhow::{Result, bail};
use cargo_fmu::pack::of_fmi3;
use cargo_fmu::process::execute;
use cargo_fmu::target::{self, Tools};
use cargo_fmu::workspace::Source;

use crate::bench;
use crate::phases::Phases;
use crate::python::Python;
use crate::workspace::{Workspace, is_ci};
use crate::{describe, dist, importers, libclang, pack, torture, web, wheel};

/// Run all checks; the first that fails ends it.
pub fn run(workspace: &Workspace) -> Result<()> {
    let phases = Phases::default();
    let result = checks(workspace, &phases);
    print!("\n{}", phases.table());
    result?;
    println!("all checks passed");
    Ok(())
}

fn checks(workspace: &Workspace, phases: &Phases) -> Result<()> {
    let environment = libclang::provide(workspace)?;
    let lacking = dist::lacking(workspace)?;
    let compile = || compile(workspace, phases, &environment, &lacking);
    // What is fetched from servers waits for them.
    let install = || {
        phases.run("install", || {
            python(workspace)?;
            wheel::install(workspace)?;
            dist::prepare(workspace)
        })?;
        phases.run("build fmi-sim", || {
            importers::fmi_sim(workspace, &environment)
                .map(Some)
                .or_else(|e| skipped(&format!("fmi-sim could not be built: {e:#}")).map(|()| None))
        })
    };
    let (TestInputs { handed_out, fmus }, fmi_sim) = phases.both(compile, install)?;
    let robustness = || {
        phases.run("torture", || torture::check(workspace))?;
        phases.run("instruction counts", || {
            if bench::can_count() {
                return bench::check_instructions(workspace, &fmus);
            }
            skipped("there is no valgrind, so instructions are not counted")
        })?;
        if let Some(made) = handed_out {
            phases.run("run what is handed out", || made.try_out(workspace))?;
        }
        phases.run("Python package", || {
            wheel::check(workspace, &workspace.fmu_dir())
        })
    };
    let outside = || phases.run("pytest", || pytest(workspace, fmi_sim));
    phases.both(robustness, outside).map(drop)
}

/// Programs that the tests from outside run.
const PROGRAMS: [&str; 6] = [
    "cosim",
    "hdrm-fmu",
    "hdrm-fmu-report",
    "hdrm-fmu-surrogate",
    "cargo-fmu",
    "torture",
];

/// What the runs need.
struct TestInputs {
    /// Nothing where it cannot be built.
    handed_out: Option<dist::Handout>,
    /// The FMUs that are tested, of FMI 2.0: those that are handed out, else those for this
    /// machine.
    fmus: Vec<PathBuf>,
}

/// The Rust checks, and everything that is compiled before the runs share the processor. One
/// profile, that of the programs, so that macros and dependencies are compiled once.
fn compile(
    workspace: &Workspace,
    phases: &Phases,
    environment: &[(String, String)],
    lacking: &str,
) -> Result<TestInputs> {
    let cargo = |arguments: &str, more: &[(&str, &str)]| {
        let mut command = workspace.cargo(arguments.split(' '));
        command.envs(environment.iter().cloned());
        execute(command.envs(more.iter().copied()))
    };
    phases.run("format", || cargo("fmt --all --check", &[]))?;
    phases.run("build tests", || {
        cargo("test --release --workspace --locked --no-run", &[])
    })?;
    phases.run("tests", || {
        cargo("test --release --workspace --locked", &[])
    })?;
    phases.run("clippy", || {
        cargo(
            "clippy --release --workspace --all-targets --locked -- -D warnings",
            &[],
        )
    })?;
    phases.run("documentation", || {
        cargo(
            "doc --release --workspace --no-deps --locked",
            &[("RUSTDOCFLAGS", "-D warnings")],
        )
    })?;
    let handed_out = phases.run("build what is handed out", || {
        if lacking.is_empty() {
            return dist::for_ci(workspace).map(Some);
        }
        skipped(&format!("what is handed out cannot be built: {lacking}")).map(|()| None)
    })?;
    let fmus = phases.run("pack", || {
        let sources = ["fmu-oscillator", "fmu-pendulum", "fmu-chassis", "fmu-wheel"]
            .map(|name| Source::Package(name.to_string()));
        let examples = workspace.target.join("fmu-examples");
        pack::fmus(workspace, &sources, "release", &examples)?;
        match &handed_out {
            Some(made) => made.copy(&workspace.fmu_dir()),
            None => pack::suite(workspace, &workspace.fmu_dir()),
        }
    })?;
    phases.run("model descriptions", || describe::check(workspace, &fmus))?;
    phases.run("build programs", || workspace.build_programs(&PROGRAMS))?;
    phases.run("WebAssembly", || {
        let missing = target::WASM.missing(&Tools::default());
        match missing.is_empty() {
            true => web::for_tests(workspace, &of_fmi3(&fmus)?),
            false => skipped(&missing.join("; ")),
        }
    })?;
    Ok(TestInputs { handed_out, fmus })
}

/// A check that cannot be made here: named on a developer's machine, a failure in CI.
fn skipped(why: &str) -> Result<()> {
    if is_ci() {
        bail!("{why}; in CI nothing may be skipped");
    }
    println!("skipped: {why}");
    Ok(())
}

/// The environment of the tests, with what they need.
fn python(workspace: &Workspace) -> Result<Python> {
    let python = Python::provide(workspace)?;
    python.install_file(workspace, "tests", "tests/requirements.txt")?;
    Ok(python)
}

fn pytest(workspace: &Workspace, fmi_sim: Option<PathBuf>) -> Result<()> {
    let python = python(workspace)?;
    let mut command = workspace.command(python.program());
    execute(
        command
            // Two processes, as CI has two cores; tests of one file share what they build. One that
            // crashes ends the run: what would take its place waits for ever (pytest-xdist 3.8 with
            // `loadfile`).
            .args(["-m", "pytest", "tests", "-n", "2", "--dist", "loadfile"])
            .args(["--max-worker-restart", "0", "--durations", "15"])
            .env("FMU_DIR", workspace.fmu_dir())
            .envs(is_ci().then_some(("REPORT_BROWSER", "required")))
            .envs(fmi_sim.map(|program| ("FMI_SIM", program))),
    )
}
