//! The same commit gives the same bytes wherever it is built.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Result, ensure};
use cargo_fmu::process::execute;

use super::folder::{CHECKSUMS, Dist};
use crate::workspace::Workspace;

/// Build the committed source in another folder with a target directory of its own, and compare the
/// checksums.
pub fn compare(workspace: &Workspace, first: &Dist, without_experiments: bool) -> Result<()> {
    let place = std::env::temp_dir().join(format!("hdrm-dist-{}", std::process::id()));
    let mut clone = Command::new("git");
    clone
        .args(["clone", "--quiet"])
        .arg(&workspace.root)
        .arg(&place);
    execute(&mut clone)?;
    let other = place.join("target/dist");
    let mut command = Command::new("cargo");
    command.current_dir(&place).env_remove("CARGO_TARGET_DIR");
    command.args(["xtask", "dist"]);
    for target in &first.targets {
        command.args(["--platform", target.platform.folder]);
    }
    if without_experiments {
        command.arg("--without-experiments");
    }
    let built = execute(&mut command);
    let compared = built.and_then(|()| {
        let read = |folder: &Path| fs::read_to_string(folder.join(CHECKSUMS));
        let (mine, theirs) = (read(&first.folder)?, read(&other)?);
        let differing: Vec<_> = mine
            .lines()
            .filter(|l| !theirs.lines().any(|t| t == *l))
            .collect();
        ensure!(
            differing.is_empty(),
            "built again from the same commit in {}, these files differ:\n{}",
            other.display(),
            differing.join("\n")
        );
        println!(
            "built again in {}: the same {} files",
            place.display(),
            mine.lines().count()
        );
        Ok(())
    });
    if compared.is_ok() {
        fs::remove_dir_all(&place)?;
    }
    compared
}
