//! Importers that the tests use and that are no Python packages.

use std::fs;
use std::path::PathBuf;

use anyhow::Result;
use cargo_fmu::process::execute;

use crate::workspace::Workspace;

/// Version of fmi-sim that `tests/test_importers.py` asks for.
const FMI_SIM: &str = "0.7.0";

/// rust-fmi's command line, built once into the target directory (some two minutes); `FMI_SIM`
/// names another one.
pub fn fmi_sim(workspace: &Workspace, environment: &[(String, String)]) -> Result<PathBuf> {
    if let Some(path) = std::env::var_os("FMI_SIM") {
        return Ok(path.into());
    }
    let root = workspace.target.join("importers");
    let program = root.join(format!("bin/fmi-sim{}", std::env::consts::EXE_SUFFIX));
    if !program.is_file() {
        println!("building fmi-sim {FMI_SIM} into {}", root.display());
        let build = root.join("build");
        let mut command = workspace.cargo(["install", "fmi-sim", "--version", FMI_SIM]);
        command
            .args(["--locked", "--quiet", "--debug", "--root"])
            .arg(&root)
            .arg("--target-dir")
            .arg(&build)
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            .envs(environment.iter().cloned());
        execute(&mut command)?;
        fs::remove_dir_all(&build)?;
    }
    Ok(program)
}
