//! Finds a Python for the bending plant, an FMU made by pythonfmu with MuJoCo, and restarts this
//! program with Python's library and packages, for commands that run this plant (see `program`).

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};

use anyhow::{Context, Result, bail};
use cosim::cli::find;

use crate::worlds::{BENDING_SYSTEM, MACHINE};

/// Environment variable that is set in the program restarted with Python.
const STARTED: &str = "HDRM_FMU_WITH_PYTHON";
/// Environment variable that names the Python to use.
const PYTHON: &str = "HDRM_FMU_PYTHON";
/// Packages that the bending plant imports.
const PACKAGES: &str = "pythonfmu mujoco numpy";
/// Prints the shared library and the package folders of the Python that runs it.
const PROBE: &str = "
import os, sys, sysconfig
import pythonfmu, mujoco, numpy
of = sysconfig.get_config_var
print(os.path.join(of('LIBDIR') or '', of('INSTSONAME') or of('LDLIBRARY') or ''))
print(os.pathsep.join(path for path in sys.path if path))
";

/// A Python that has the packages.
struct Python {
    program: PathBuf,
    /// Its shared library.
    library: PathBuf,
    /// Its package folders, as `PYTHONPATH`.
    packages: String,
}

/// Restarts this program with Python's library and packages, and returns the exit status of that
/// process; `None` in the restarted program itself. Builds Bending.fmu and its system before, if
/// their scripts are there. Fails without a Python with the packages, or without the system; the
/// message says how to get them.
pub fn with_python() -> Result<Option<ExitStatus>> {
    if env::var_os(STARTED).is_some() {
        return Ok(None);
    }
    let python = Python::find()?;
    python.build()?;
    let mut again = Command::new(env::current_exe()?);
    again.args(env::args_os().skip(1)).env(STARTED, "1");
    again.env("PYTHONPATH", &python.packages);
    if cfg!(target_os = "linux") {
        again.env("LD_PRELOAD", &python.library);
    }
    let status = again.status().context("this program with Python")?;
    Ok(Some(status))
}

impl Python {
    /// The first that works of: the Python named by the environment variable, the active virtual
    /// environment, `.venv` here or in a folder above the program, the system's Python.
    fn find() -> Result<Self> {
        let mut tried = Vec::new();
        for program in candidates() {
            match Self::probe(&program) {
                Ok(found) => return Ok(found),
                Err(error) => tried.push(format!("  {}: {error:#}", program.display())),
            }
        }
        bail!(
            "the bending plant is MuJoCo in Python, and no Python was found that can run it:\n{}\ninstall its packages (`python3 -m venv .venv && \
             .venv/bin/pip install {PACKAGES}`) and Python's shared library (Debian: `apt install libpython3-dev`), or name a Python in the \
             environment variable {PYTHON}",
            tried.join("\n")
        )
    }

    fn probe(program: &Path) -> Result<Self> {
        let output = Command::new(program).args(["-c", PROBE]).output()?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            bail!("{}", text.lines().last().unwrap_or("failed"));
        }
        let text = String::from_utf8(output.stdout)?;
        let (library, packages) = text.trim_end().split_once('\n').context("says nothing")?;
        let library = PathBuf::from(library);
        if cfg!(target_os = "linux") && !library.is_file() {
            bail!("its shared library {} is missing", library.display());
        }
        Ok(Self {
            program: program.into(),
            library,
            packages: packages.into(),
        })
    }

    /// Builds Bending.fmu and its system beside the packed machine, if the scripts are there.
    fn build(&self) -> Result<()> {
        let machine = find(MACHINE)?;
        let folder = machine.parent().context("a file lies in a folder")?;
        let Some(script) = above_the_program("examples/build.py") else {
            let command = format!("python examples/build.py {}", folder.display());
            let hint = format!("make it with `{command}` in this project's sources");
            return find(BENDING_SYSTEM).map(drop).context(hint);
        };
        let mut build = Command::new(&self.program);
        build.arg(script).arg(folder).arg("bending.py");
        build.env("HDRM_FMU", env::current_exe()?);
        let output = build.output().context("examples/build.py")?;
        if !output.status.success() {
            bail!(
                "Bending.fmu cannot be made:\n{}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
        Ok(())
    }
}

fn candidates() -> Vec<PathBuf> {
    if let Some(named) = env::var_os(PYTHON) {
        return vec![named.into()];
    }
    let (within, system) = match cfg!(windows) {
        true => ("Scripts/python.exe", "python"),
        false => ("bin/python", "python3"),
    };
    let active = env::var_os("VIRTUAL_ENV").map(|folder| Path::new(&folder).join(within));
    let local = Path::new(".venv").join(within);
    let local = local.is_file().then_some(local);
    let above = above_the_program(&format!(".venv/{within}"));
    let all = [active, local, above, Some(system.into())];
    all.into_iter().flatten().collect()
}

/// The file at this relative path in one of the folders above the program.
fn above_the_program(path: &str) -> Option<PathBuf> {
    let program = env::current_exe().ok()?;
    let mut files = program.ancestors().skip(1).map(|folder| folder.join(path));
    files.find(|file| file.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A program that is no Python, and one that is not there, are refused by name.
    #[test]
    fn what_is_no_python_is_refused() {
        for program in ["cargo", "no/such/python"] {
            assert!(Python::probe(Path::new(program)).is_err(), "{program}");
        }
    }
}
