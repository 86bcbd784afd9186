//! Everything that CI checks, in one run.

use std::path::PathBuf;

use anyhow::{Result, bail};
use cargo_fmu::pack::fmi3_files;
use cargo_fmu::process::execute;
use cargo_fmu::target::{self, Tools};
use cargo_fmu::workspace::Source;

use crate::bench;
use crate::phases::Phases;
use crate::programs::torture;
use crate::python::Python;
use crate::workspace::{Workspace, is_ci};
use crate::{describe, dist, importers, pack, web, wheel};

/// Run all checks, the nightly ones too if asked for; the first that fails ends it.
pub fn run(workspace: &Workspace, nightly: bool) -> Result<()> {
    let phases = Phases::default();
    let result = checks(workspace, &phases, nightly);
    print!("\n{}", phases.table());
    result?;
    println!("all checks passed");
    Ok(())
}

fn checks(workspace: &Workspace, phases: &Phases, nightly: bool) -> Result<()> {
    let build = || {
        phases.run("format", || cargo(workspace, "fmt --all --check", &[]))?;
        phases.run("build tests", || {
            cargo(workspace, &format!("{TESTS} --no-run"), &[])
        })
    };
    // What is fetched from servers waits for them.
    let install = || {
        let lacking = phases.run("install", || {
            python(workspace)?;
            wheel::install(workspace)?;
            dist::prepare(workspace)?;
            dist::lacking(workspace, nightly)
        })?;
        if !nightly {
            return Ok((lacking, None));
        }
        let fmi_sim = phases.run("build fmi-sim", || importers::fmi_sim(workspace))?;
        Ok((lacking, Some(fmi_sim)))
    };
    let ((), (lacking, fmi_sim)) = phases.both(build, install)?;
    // What tests and linkers leave of the processor, compilers use.
    let inputs = || test_inputs(workspace, phases, &lacking, nightly);
    let (inputs, ()) = phases.both(inputs, || rust_checks(workspace, phases))?;
    let TestInputs { handed_out, fmus } = inputs;
    let robustness = || {
        phases.run("torture", || torture(workspace, &["--packed".into()]))?;
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
        })?;
        if nightly {
            phases.run("rust-fmi", || {
                importers::rust_fmi(workspace, &workspace.fmu_dir())
            })?;
            phases.run("packages of the kit", || packages(workspace))?;
        }
        Ok(())
    };
    let outside = || phases.run("pytest", || pytest(workspace, fmi_sim));
    phases.both(robustness, outside).map(drop)
}

/// The tests of the workspace. One profile, that of the programs, so that macros and dependencies
/// are compiled once.
const TESTS: &str = "test --release --workspace --locked";

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

/// A cargo command by its words, with more environment variables.
pub fn cargo(workspace: &Workspace, arguments: &str, more: &[(&str, &str)]) -> Result<()> {
    let mut command = workspace.cargo(arguments.split(' '));
    execute(command.envs(more.iter().copied()))
}

/// The Rust checks, once the tests are built.
fn rust_checks(workspace: &Workspace, phases: &Phases) -> Result<()> {
    phases.run("tests", || cargo(workspace, TESTS, &[]))?;
    phases.run("clippy", || {
        let clippy = "clippy --release --workspace --all-targets --locked -- -D warnings";
        cargo(workspace, clippy, &[])
    })?;
    phases.run("documentation", || {
        let doc = "doc --release --workspace --no-deps --locked";
        cargo(workspace, doc, &[("RUSTDOCFLAGS", "-D warnings")])
    })
}

/// Everything that is compiled before the runs share the processor.
fn test_inputs(
    workspace: &Workspace,
    phases: &Phases,
    lacking: &str,
    nightly: bool,
) -> Result<TestInputs> {
    let handed_out = phases.run("build what is handed out", || {
        if lacking.is_empty() {
            return dist::for_ci(workspace, nightly).map(Some);
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
            true => web::for_tests(workspace, &fmi3_files(&fmus)?),
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
pub fn python(workspace: &Workspace) -> Result<Python> {
    let python = Python::provide(workspace)?;
    python.install_file(workspace, "tests", "tests/requirements.txt")?;
    Ok(python)
}

/// Pack the crates that are published, and build them from their packages.
fn packages(workspace: &Workspace) -> Result<()> {
    let all = workspace.cargo.packages.iter();
    let names = all.filter(|p| p.is_published()).map(|p| p.name.as_str());
    let named = names.flat_map(|name| ["--package", name]);
    execute(workspace.cargo(["package", "--locked"]).args(named))
}

/// The tests from outside; with fmi-sim, those that take minutes too.
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
            .args(
                fmi_sim
                    .is_some()
                    .then_some(["-m", ""])
                    .into_iter()
                    .flatten(),
            )
            .envs(fmi_sim.map(|program| ("FMI_SIM", program))),
    )
}
