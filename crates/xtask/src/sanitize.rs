//! AddressSanitizer and LeakSanitizer on the export layer, the FMUs, their driver and the native master.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::torture::nightly;
use crate::workspace::{Workspace, execute, output};
use crate::{libclang, pack};

/// Name of each FMU and of its library.
const FMUS: [(&str, &str); 3] = [
    ("Emla", "fmu_emla"),
    ("Hdrm", "fmu_hdrm"),
    ("Controller", "fmu_controller"),
];
const PACKAGES: [&str; 10] = [
    "-p",
    "fmu-emla",
    "-p",
    "fmu-hdrm",
    "-p",
    "fmu-controller",
    "-p",
    "torture",
    "-p",
    "cosim",
];
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
    pack::suite(workspace, &workspace.fmu_dir())?;
    let mut fmus = Vec::new();
    for (name, library) in FMUS {
        let packed = workspace.fmu_dir().join(name).with_extension("fmu");
        let out = fmu_dir.join(name).with_extension("fmu");
        pack::with_library(&packed, &built.join(format!("lib{library}.so")), &out)?;
        fmus.push(out);
    }
    let torture = |arguments: &[&str]| {
        println!("==> torture {}", arguments.join(" "));
        execute(
            sanitized(workspace, &built.join("torture"))
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
        coupled(workspace, &built.join("cosim"), &fmu_dir, schedule)?;
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

/// Test the export layer and build everything else, instrumented; the folder of what was built.
fn build(workspace: &Workspace) -> Result<PathBuf> {
    let target = host(workspace)?;
    let environment = libclang::provide(workspace)?;
    let cargo = |arguments: &[&str]| {
        let mut command = nightly(workspace);
        command
            .args(arguments)
            .args(["--target", &target, "--target-dir"]);
        command
            .arg(workspace.target.join("asan"))
            .env("RUSTFLAGS", FLAGS)
            .env("ASAN_OPTIONS", OPTIONS)
            .envs(environment.iter().cloned());
        execute(&mut command)
            .context("needed is the nightly compiler: `rustup toolchain install nightly`")
    };
    cargo(&["test", "--tests", "-p", "fmu-export"])?;
    cargo(&[&["build"], &PACKAGES[..]].concat())?;
    Ok(workspace.target.join("asan").join(&target).join("debug"))
}

/// The target triple of this machine: named, it keeps build scripts and macros free of the sanitizer.
fn host(workspace: &Workspace) -> Result<String> {
    let text = output(workspace.command("rustc").arg("-vV"))?;
    let line = text.lines().find_map(|l| l.strip_prefix("host: "));
    line.map(ToString::to_string)
        .context("rustc -vV names no host")
}
