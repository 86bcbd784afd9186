//! rust-fmi, another importer of FMUs in Rust, and its command line fmi-sim, which `test --nightly`
//! builds and runs. Their bindings are made by bindgen, which loads libclang.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;
use cargo_fmu::process::{execute, output};

use crate::python::Python;
use crate::workspace::Workspace;

/// Version of fmi-sim that `tests/test_importers.py` asks for.
const FMI_SIM: &str = "0.7.0";
/// The Python package with libclang, which is used if the environment names none.
const LIBCLANG: &str = "libclang==18.1.1\n";

/// The program fmi-sim, built once into the target directory (some two minutes); the environment
/// variable `FMI_SIM` names another one.
pub fn fmi_sim(workspace: &Workspace) -> Result<PathBuf> {
    if let Some(path) = std::env::var_os("FMI_SIM") {
        return Ok(path.into());
    }
    let root = workspace.target.join("importers");
    let program = root.join(format!("bin/fmi-sim{}", std::env::consts::EXE_SUFFIX));
    if !program.is_file() {
        println!("building fmi-sim {FMI_SIM} into {}", root.display());
        let install = ["install", "fmi-sim", "--version", FMI_SIM];
        let mut command = cargo(workspace, &install)?;
        command.args(["--locked", "--quiet", "--debug", "--root"]);
        execute(command.arg(&root))?;
    }
    Ok(program)
}

/// Has rust-fmi read and run the packed FMUs of a folder.
pub fn rust_fmi(workspace: &Workspace, fmus: &Path) -> Result<()> {
    let mut command = cargo(workspace, &["test", "--locked", "--manifest-path"])?;
    command.arg("tools/rust-fmi-importer/Cargo.toml");
    execute(command.env("FMU_DIR", fmus))
}

/// A cargo command that finds libclang. All share a build folder, since they build the same crates.
fn cargo(workspace: &Workspace, arguments: &[&str]) -> Result<Command> {
    let mut command = workspace.cargo(arguments.iter().copied());
    command
        .env("CARGO_TARGET_DIR", workspace.target.join("importers/build"))
        .env("CARGO_PROFILE_DEV_DEBUG", "0");
    if std::env::var_os("LIBCLANG_PATH").is_none() {
        let python = Python::provide(workspace)?;
        python.install(workspace, "libclang", LIBCLANG)?;
        let code = "import clang, pathlib; print(pathlib.Path(clang.__file__).parent / 'native')";
        let folder = output(workspace.command(python.program()).args(["-c", code]))?;
        command.env("LIBCLANG_PATH", folder.trim());
        // The compiler's own headers (`stddef.h`), which the Python package does not bring.
        let include = output(workspace.command("cc").arg("-print-file-name=include"))?;
        if Path::new(include.trim()).is_dir() {
            command.env("BINDGEN_EXTRA_CLANG_ARGS", format!("-I{}", include.trim()));
        }
    }
    Ok(command)
}
