//! Tries the folder that is handed out, for `dist` and `test`, by the script `tests/handed_out.py`:
//! runs its programs and FMUs, builds it again, installs its wheel.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::process::execute;

use super::folder::Dist;
use super::listing::Listing;
use crate::workspace::Workspace;

/// The script with one of its commands.
fn script(workspace: &Workspace, command: &str) -> Command {
    let mut script = workspace.command("python3");
    script.args(["tests/handed_out.py", command]);
    script
}

/// Install what the runs for [`super::CI_PLATFORMS`] need. What cannot be had here is listed when
/// it is missing.
pub fn prepare(workspace: &Workspace) -> Result<()> {
    let mut script = script(workspace, "prepare");
    execute(script.arg("--work").arg(folder(workspace)))
}

fn folder(workspace: &Workspace) -> PathBuf {
    workspace.target.join("dist-check")
}

/// Runs what can be run here, on this machine, in an old Debian, under Wine and QEMU, and compares
/// the numbers. Runs that are not possible here are listed.
pub fn run(workspace: &Workspace, dist: &Dist, listing: &mut Listing) -> Result<()> {
    let work = folder(workspace);
    fs::create_dir_all(&work).with_context(|| work.display().to_string())?;
    let lines = work.join("listing.txt");
    let mut script = script(workspace, "run");
    script.arg(&dist.folder).arg("--work").arg(&work);
    script.arg("--listing").arg(&lines);
    script.args(platforms(dist));
    for ((platform, name), path) in &dist.programs {
        let program = format!("{platform}/{name}={}", path.display());
        script.args(["--program", &program]);
    }
    let check = workspace.build_programs(&["cargo-fmu"])?;
    let done = execute(script.arg("--cargo-fmu").arg(check));
    listing.add_runs(&fs::read_to_string(&lines).with_context(|| lines.display().to_string())?)?;
    done
}

/// Builds the committed source again in another folder, and compares the checksums.
pub fn build_again(workspace: &Workspace, dist: &Dist, without_experiments: bool) -> Result<()> {
    let mut script = script(workspace, "again");
    script.arg(&dist.folder).args(platforms(dist));
    script.args(without_experiments.then_some("--without-experiments"));
    execute(&mut script)
}

fn platforms(dist: &Dist) -> impl Iterator<Item = &'static str> {
    let targets = dist.targets.iter();
    targets.flat_map(|target| ["--platform", target.platform.folder])
}

/// Installs a wheel in an empty environment and runs its demo with an empty search path: here, and
/// a wheel for any Linux also in an old Debian.
pub fn try_wheel(workspace: &Workspace, wheel: &Path) -> Result<()> {
    let mut script = script(workspace, "wheel");
    script.arg(wheel);
    script
        .arg("--work")
        .arg(workspace.target.join("wheel-trial"));
    execute(&mut script)
}
