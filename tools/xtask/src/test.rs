//! `cargo xtask test`: everything that CI checks, in one run, for CI and developers.

use std::path::PathBuf;

use anyhow::{Result, bail};
use cargo_fmu::pack::fmi3_files;
use cargo_fmu::process::execute;
use cargo_fmu::target::{self, Tools};
use cargo_fmu::workspace::Source;

use crate::phases::Phases;
use crate::programs::torture;
use crate::python::Python;
use crate::workspace::{Workspace, is_ci};
use crate::{bench, cosim_wasm, describe, dist, importers, pack, web, wheel};

/// Runs all checks, with `nightly` also the long ones; the first that fails ends the run.
pub fn run(workspace: &Workspace, nightly: bool) -> Result<()> {
    let phases = Phases::start();
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
    // Downloads mostly wait for servers.
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
    // Compilers use the cores that tests and linkers leave idle.
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

/// Programs that the Python tests run.
const PROGRAMS: [&str; 6] = [
    "cosim",
    "hdrm-fmu",
    "hdrm-fmu-report",
    "hdrm-fmu-surrogate",
    "cargo-fmu",
    "torture",
];

/// What is tested.
struct TestInputs {
    /// The folder that is handed out; none where it cannot be built.
    handed_out: Option<dist::Handout>,
    /// The FMUs of FMI 2.0: those that are handed out, else those for this machine.
    fmus: Vec<PathBuf>,
}

/// Runs cargo with arguments separated by spaces, and with more environment variables.
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

/// Builds what tests in Python and torture need: the handout, FMUs, programs, WebAssembly.
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
    if nightly {
        phases.run("cosim-wasm", || {
            cosim_wasm::check(workspace)?;
            cosim_wasm::build(workspace).map(drop)
        })?;
    }
    phases.run("WebAssembly", || {
        let missing = target::WASM.missing(&Tools::default());
        match missing.is_empty() {
            true => web::for_tests(workspace, &fmi3_files(&fmus)?),
            false => skipped(&missing.join("; ")),
        }
    })?;
    Ok(TestInputs { handed_out, fmus })
}

/// Reports a check that cannot be made here; in CI that is an error.
fn skipped(why: &str) -> Result<()> {
    if is_ci() {
        bail!("{why}; in CI nothing may be skipped");
    }
    println!("skipped: {why}");
    Ok(())
}

/// The Python environment of the tests, with their packages.
pub fn python(workspace: &Workspace) -> Result<Python> {
    let python = Python::provide(workspace)?;
    python.install_file(workspace, "tests", "tests/requirements.txt")?;
    Ok(python)
}

/// Packs the crates that are published, and builds them from their packages.
fn packages(workspace: &Workspace) -> Result<()> {
    let all = workspace.cargo.packages.iter();
    let names = all.filter(|p| p.is_published()).map(|p| p.name.as_str());
    let named = names.flat_map(|name| ["--package", name]);
    execute(workspace.cargo(["package", "--locked"]).args(named))
}

/// Runs the Python tests; with fmi-sim, also those that take minutes.
fn pytest(workspace: &Workspace, fmi_sim: Option<PathBuf>) -> Result<()> {
    let python = python(workspace)?;
    let mut command = workspace.command(python.program());
    // Two processes, as CI has two cores; tests of one file share what they build. A process that
    // crashes ends the run, because its replacement would wait for ever (pytest-xdist 3.8 with
    // `loadfile`).
    command.args(["-m", "pytest", "tests", "-n", "2", "--dist", "loadfile"]);
    command.args(["--max-worker-restart", "0", "--durations", "15"]);
    command.env("FMU_DIR", workspace.fmu_dir());
    command.envs(is_ci().then_some(("REPORT_BROWSER", "required")));
    if let Some(program) = fmi_sim {
        command.args(["-m", ""]).env("FMI_SIM", program);
    }
    execute(&mut command)
}
