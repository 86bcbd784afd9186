//! The repository's own Python environment in `.venv`: what builds and tests need.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cargo_fmu::process::execute;
use cargo_fmu::target::{Tools, ZIG};

use crate::workspace::Workspace;

/// A virtual environment with pinned packages.
pub struct Python {
    dir: PathBuf,
}

impl Python {
    /// The environment in `.venv`, made where it is missing.
    pub fn provide(workspace: &Workspace) -> Result<Self> {
        Self::at(workspace, workspace.root.join(".venv"))
    }

    /// The environment in a folder, made where it is missing.
    pub fn at(workspace: &Workspace, dir: PathBuf) -> Result<Self> {
        let python = Self { dir };
        if !python.program().is_file() {
            println!("making the Python environment {}", python.dir.display());
            let host = if cfg!(windows) { "python" } else { "python3" };
            execute(
                workspace
                    .command(host)
                    .args(["-m", "venv"])
                    .arg(&python.dir),
            )
            .context("is Python 3 with its venv module installed?")?;
        }
        Ok(python)
    }

    /// Its interpreter.
    pub fn program(&self) -> PathBuf {
        self.dir.join(if cfg!(windows) {
            "Scripts/python.exe"
        } else {
            "bin/python"
        })
    }

    /// The linker for Linux and macOS, installed here.
    pub fn zig(&self, workspace: &Workspace) -> Result<Tools> {
        self.install(workspace, "zig", ZIG)?;
        let folder = self.program().parent().map(Path::to_path_buf);
        Ok(Tools(folder.into_iter().collect()))
    }

    /// Install the pinned requirements of a file of the repository, as [`Python::install`].
    pub fn install_file(&self, workspace: &Workspace, name: &str, file: &str) -> Result<()> {
        let file = workspace.root.join(file);
        let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        self.install(workspace, name, &text)
    }

    /// Install pinned requirements (text of a requirements file), unless just these are installed
    /// under `name`.
    pub fn install(&self, workspace: &Workspace, name: &str, requirements: &str) -> Result<()> {
        let stamp = self.dir.join(format!("{name}.installed.txt"));
        if fs::read_to_string(&stamp).is_ok_and(|installed| installed == requirements) {
            return Ok(());
        }
        println!("installing {name} into {}", self.dir.display());
        let file = self.dir.join(format!("{name}.txt"));
        fs::write(&file, requirements)?;
        let pip = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--requirement",
        ];
        execute(workspace.command(self.program()).args(pip).arg(&file))?;
        fs::write(&stamp, requirements).with_context(|| stamp.display().to_string())
    }
}
