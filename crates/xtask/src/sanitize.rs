//! AddressSanitizer and LeakSanitizer on the export layer, the FMUs, their driver and the native master.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_fmu::process::execute;
use cargo_fmu::workspace::{Source, artifacts};

use crate::workspace::Workspace;
use crate::{libclang, nightly, pack};

/// The executables carry the sanitizer's functions, which the libraries they load look for among their dynamic symbols.
const FLAGS: &str = "-Zsanitizer=address -Clink-arg=-rdynamic";
/// Everything that is off by default; a report of any kind ends the process with a status of its own.
const OPTIONS: &str = "detect_leaks=1:detect_stack_use_after_return=1:strict_string_checks=1:check_initialization_order=1:\
                       detect_invalid_pointer_pairs=2:exitcode=98";

/// Run it all; the first report ends it.
pub fn run(workspace: &Workspace, calls: usize, seed: u64) -> Result<()> {
    let built = build(workspace)?;
    let fmu_dir = workspace.target.join("asan").join("fmu");
    fs::create_dir_all(&fmu_dir)?;
    let packed = pack::suite(workspace, &workspace.fmu_dir())?;
    let mut fmus = Vec::new();
    for (packed, library) in packed.iter().zip(&built.libraries) {
        let out = fmu_dir.join(packed.file_name().unwrap_or_default());
        pack::with_library(packed, library, &out)?;
        fmus.push(out);
    }
    let torture = |arguments: &[&str]| {
        println!("==> torture {}", arguments.join(" "));
        execute(
            sanitized(workspace, &built.torture)
                .args(arguments)
                .args(&fmus),
        )
    };
    let (calls_text, seed) = (calls.to_string(), seed.to_string());
    torture(&[
        "calls",
        "--calls",
        &calls_text,
        "--batch",
        "5000",
        "--seed",
        &seed,
    ])?;
    torture(&["life", "--instances", "300", "--loads", "3"])?;
    torture(&["threads", "--threads", "4", "--steps", "50"])?;
    for schedule in ["gauss-seidel", "jacobi"] {
        println!("==> cosim run --schedule {schedule}");
        coupled(workspace, &built.cosim, &fmu_dir, schedule)?;
    }
    println!(
        "AddressSanitizer and LeakSanitizer: tests of fmu-export, {calls} random calls, 3 x 300 instances over 3 loads and unloads, 12 \
         threads, 2 coupled runs of 5 instances over the whole trajectory: 0 reports"
    );
    Ok(())
}

/// Five instances over the whole cubic trajectory.
fn coupled(workspace: &Workspace, cosim: &Path, fmu_dir: &Path, schedule: &str) -> Result<()> {
    let mut command = sanitized(workspace, cosim);
    command.args(["run", "--quiet", "--schedule", schedule]);
    if schedule == "jacobi" {
        command.arg("--input-derivatives");
    }
    command.arg("--system");
    command.arg(workspace.root.join("system/SystemStructure.ssd"));
    execute(command.arg("--fmu-dir").arg(fmu_dir))
}

fn sanitized(workspace: &Workspace, program: &Path) -> Command {
    let mut command = workspace.command(program);
    command.env("ASAN_OPTIONS", OPTIONS);
    command
}

/// What was built with the sanitizer.
struct Built {
    torture: PathBuf,
    cosim: PathBuf,
    /// In the order of the suite.
    libraries: Vec<PathBuf>,
}

/// Test the export layer and build everything else, instrumented.
fn build(workspace: &Workspace) -> Result<Built> {
    let target = nightly::host(workspace)?;
    let environment = libclang::provide(workspace)?;
    let cargo = |arguments: &[&str]| {
        let mut command = nightly::cargo(workspace);
        command
            .args(arguments)
            .args(["--target", &target, "--target-dir"]);
        command
            .arg(workspace.target.join("asan"))
            .env("RUSTFLAGS", FLAGS)
            .env("ASAN_OPTIONS", OPTIONS)
            .envs(environment.iter().cloned());
        command
    };
    execute(&mut cargo(&["test", "--tests", "-p", "fmu-export"]))
        .context("needed is the nightly compiler: `rustup toolchain install nightly`")?;
    let suite = workspace.suite();
    let mut build = cargo(&["build", "-p", "torture", "-p", "cosim"]);
    for source in &suite {
        if let Source::Package(name) = source {
            build.args(["-p", name]);
        }
    }
    let built = artifacts(&mut build)?;
    let program = |name: &str| {
        let found = built
            .iter()
            .find(|a| a.name() == name && a.executable.is_some());
        let file = found.and_then(|a| a.executable.clone());
        file.with_context(|| format!("cargo has built no program `{name}`"))
    };
    let libraries: Vec<_> = suite.iter().filter_map(|s| s.library(&built)).collect();
    ensure!(
        libraries.len() == suite.len(),
        "cargo has not built the libraries of all FMUs"
    );
    Ok(Built {
        torture: program("torture")?,
        cosim: program("cosim")?,
        libraries,
    })
}
