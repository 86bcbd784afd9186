//! Python environments with the packages that builds, tests and benches need: the repository's own
//! in `.venv`, and others.

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
    /// The environment in `.venv`, made if it is missing.
    pub fn provide(workspace: &Workspace) -> Result<Self> {
        Self::at(workspace, workspace.root.join(".venv"))
    }

    /// The environment in a folder, made if it is missing.
    pub fn at(workspace: &Workspace, dir: PathBuf) -> Result<Self> {
        let python = Self { dir };
        if !python.program().is_file() {
            println!("making the Python environment {}", python.dir.display());
            let host = if cfg!(windows) { "python" } else { "python3" };
            let mut venv = workspace.command(host);
            execute(venv.args(["-m", "venv"]).arg(&python.dir))
                .context("is Python 3 with its venv module installed?")?;
        }
        Ok(python)
    }

    /// Its interpreter.
    pub fn program(&self) -> PathBuf {
        let windows = cfg!(windows).then_some("Scripts/python.exe");
        self.dir.join(windows.unwrap_or("bin/python"))
    }

    /// The linker for Linux and macOS, installed here.
    pub fn zig(&self, workspace: &Workspace) -> Result<Tools> {
        self.install(workspace, "zig", ZIG)?;
        let folder = self.program().parent().map(Path::to_path_buf);
        Ok(Tools(folder.into_iter().collect()))
    }

    /// Installs the pinned requirements of a file of the repository, as [`Python::install`] does.
    pub fn install_file(&self, workspace: &Workspace, name: &str, file: &str) -> Result<()> {
        let file = workspace.root.join(file);
        let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        self.install(workspace, name, &text)
    }

    /// Installs pinned requirements (the text of a requirements file), unless the same text has
    /// been installed as `name` before.
    pub fn install(&self, workspace: &Workspace, name: &str, requirements: &str) -> Result<()> {
        let stamp = self.dir.join(format!("{name}.installed.txt"));
        if fs::read_to_string(&stamp).is_ok_and(|installed| installed == requirements) {
            return Ok(());
        }
        println!("installing {name} into {}", self.dir.display());
        let file = self.dir.join(format!("{name}.txt"));
        fs::write(&file, requirements)?;
        let mut pip = workspace.command(self.program());
        pip.args(["-m", "pip", "install", "--quiet"]);
        pip.args(["--disable-pip-version-check", "--requirement"]);
        execute(pip.arg(&file))?;
        fs::write(&stamp, requirements).with_context(|| stamp.display().to_string())
    }
}
