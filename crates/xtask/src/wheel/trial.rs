//! `cargo xtask wheel --trial`: the wheel as those get it who have Python and nothing else.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_fmu::process::execute;

use crate::dist::userland::{CERTIFICATES, Userland};
use crate::workspace::Workspace;

/// Pictures that the demo draws.
const FIGURES: [&str; 2] = ["tip.png", "energy.png"];
/// A picture with axes and a curve is no smaller, bytes.
const PICTURE: u64 = 20_000;

/// Install a wheel in an empty environment and run its demo, here and, if it is for any Linux, in
/// an old Debian.
pub fn run(workspace: &Workspace, wheel: &Path) -> Result<()> {
    let folder = workspace.target.join("wheel-trial");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    here(workspace, wheel, &folder.join("here"))?;
    if wheel.to_string_lossy().contains("manylinux") {
        old_debian(wheel, &folder)?;
    }
    Ok(())
}

fn here(workspace: &Workspace, wheel: &Path, folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    let empty = folder.join("empty");
    fs::create_dir_all(&empty)?;
    let venv = folder.join("venv");
    execute(workspace.command("python3").args(["-m", "venv"]).arg(&venv))?;
    let python = venv.join("bin/python");
    execute(workspace.command(&python).args(INSTALL).arg(wheel))?;
    let mut demo = Command::new(&python);
    demo.env_clear().env("PATH", &empty).env("HOME", folder);
    execute(demo.args(DEMO).arg(folder))?;
    check_figures(folder)?;
    println!("the wheel runs in an empty environment, with nothing in the search path");
    Ok(())
}

fn old_debian(wheel: &Path, folder: &Path) -> Result<()> {
    let userland = Userland::with_python(folder)?;
    let home = userland.file("trial");
    if home.exists() {
        fs::remove_dir_all(&home)?;
    }
    fs::create_dir_all(&home)?;
    let name = wheel.file_name().context("a wheel is a file")?;
    fs::copy(wheel, home.join(name))?;
    execute(
        userland
            .command("/usr/bin/python3.9")
            .args(["-m", "venv", "/trial/venv"]),
    )?;
    let mut install = userland.command("/trial/venv/bin/python");
    install.env("PIP_CERT", Path::new("/").join(CERTIFICATES));
    execute(install.args(INSTALL).arg(Path::new("/trial").join(name)))?;
    let mut demo = userland.command("/trial/venv/bin/python");
    execute(demo.env("HOME", "/trial").args(DEMO).arg("/trial"))?;
    check_figures(&home)?;
    println!("the wheel runs in {}", userland.name);
    Ok(())
}

const INSTALL: [&str; 4] = ["-m", "pip", "install", "--quiet"];
const DEMO: [&str; 4] = ["-m", "hdrm_fmu", "demo", "--out"];

fn check_figures(folder: &Path) -> Result<()> {
    for name in FIGURES {
        let figure = folder.join(name);
        let size = fs::metadata(&figure)
            .with_context(|| figure.display().to_string())?
            .len();
        ensure!(size > PICTURE, "{} has {size} bytes only", figure.display());
    }
    Ok(())
}
