//! `cargo xtask web`: makes the live machine, one HTML file that runs the coupled system in a
//! browser; also for `dist` and `test`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::pack::{Platforms, fmi3_files};
use cargo_fmu::process::execute;
use cargo_fmu::target;
use cargo_fmu::workspace::Source;
use clap::Args;

use crate::workspace::{FMU_PROFILE, Workspace, profile};
use crate::{pack, programs};

/// File name of the master's module, which every page carries.
pub const ENGINE: &str = "cosim_page.wasm";

/// The machine that the FMUs have.
const REFERENCE: &str = "reference";

#[derive(Args)]
pub struct Options {
    /// Cargo profile of the WebAssembly; `fmu-fast` builds faster, runs slower
    #[arg(long, value_name = "PROFILE", default_value = FMU_PROFILE)]
    profile: String,
    /// Machine file, or name of a shipped machine, that the page shows and runs
    #[arg(long, value_name = "FILE|NAME", default_value = REFERENCE)]
    machine: String,
    /// The page [default: web/machine.html in the cargo target directory]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Makes the page of FMUs that are packed for it. Their libraries, which only describe them here,
/// are built the fast way.
pub fn run(workspace: &Workspace, caller: &Path, options: &Options) -> Result<()> {
    let folder = workspace.target.join("web");
    let out = options.out.as_ref().map(|out| caller.join(out));
    let out = out.unwrap_or_else(|| folder.join("machine.html"));
    let (release, host) = (profile("release"), Platforms::default());
    // A name stays one; the program that reads a file runs in another folder.
    let file = caller.join(&options.machine);
    let machine = if file.is_file() {
        &file
    } else {
        Path::new(&options.machine)
    };
    let packed = pack::suite_with(workspace, &release, &host, &folder)?;
    made(
        workspace,
        &fmi3_files(&packed)?,
        &options.profile,
        machine,
        &out,
    )
}

/// Adds WebAssembly to these FMUs of FMI 3.0, in the order of [`Workspace::suite`], and makes their
/// page.
pub fn make(workspace: &Workspace, fmus: &[PathBuf], profile: &str, out: &Path) -> Result<()> {
    made(workspace, fmus, profile, REFERENCE.as_ref(), out)
}

/// As [`make`], of a machine.
fn made(
    workspace: &Workspace,
    fmus: &[PathBuf],
    profile: &str,
    machine: &Path,
    out: &Path,
) -> Result<()> {
    add_wasm(workspace, fmus, profile)?;
    let folder = out.parent().context("the page lies in a folder")?;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let scratch = workspace.target.join("web");
    fs::create_dir_all(&scratch)?;
    let (system, scene) = (scratch.join("machine.ssp"), scratch.join("scene.json"));
    pack::worlds(workspace, fmus, &system)?;
    let drawn = ["machine", "scene", "--out"].map(String::from);
    let hdrm_fmu = workspace.build_programs(&programs::with_started(&drawn))?;
    let mut draw = workspace.command(hdrm_fmu);
    execute(draw.args(&drawn).arg(&scene).arg(machine))?;
    let mut page = cargo_fmu(workspace)?;
    page.arg("web").arg(&system).arg("--out").arg(out);
    page.args(["--page", "studies/machine-page/machine.html"]);
    page.args(["--profile", profile]);
    page.arg("--data").arg(format!("scene={}", scene.display()));
    execute(&mut page)
}

/// Copies these FMUs to `wasm/` of the target directory, adds WebAssembly to the copies, and makes
/// their page: built as those that are handed out, but linked fast.
pub fn for_tests(workspace: &Workspace, fmus: &[PathBuf]) -> Result<()> {
    let folder = workspace.target.join("wasm");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let copy = |fmu: &PathBuf| {
        let to = folder.join(fmu.file_name().unwrap_or_default());
        fs::copy(fmu, &to).with_context(|| fmu.display().to_string())?;
        Ok(to)
    };
    let copies: Vec<_> = fmus.iter().map(copy).collect::<Result<_>>()?;
    let page = workspace.target.join("web/machine.html");
    make(workspace, &copies, "fmu-fast", &page)
}

/// The file of the master's module, which [`make`] builds.
pub fn engine(workspace: &Workspace, profile: &str) -> PathBuf {
    let folder = workspace.target.join(target::WASM.triple);
    folder.join(profile).join(ENGINE)
}

/// Adds WebAssembly to the FMUs of FMI 3.0 of the suite, in its order.
fn add_wasm(workspace: &Workspace, fmus: &[PathBuf], profile: &str) -> Result<()> {
    let mut command = cargo_fmu(workspace)?;
    command.args(["add-wasm", "--profile", profile]);
    for source in workspace.suite() {
        if let Source::Package(name) = source {
            command.args(["--package", &name]);
        }
    }
    execute(command.args(fmus))
}

fn cargo_fmu(workspace: &Workspace) -> Result<Command> {
    let mut command = workspace.command(workspace.build_programs(&["cargo-fmu"])?);
    command.arg("fmu");
    Ok(command)
}
