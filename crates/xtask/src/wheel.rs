//! `cargo xtask wheel`: the Python package `hdrm_fmu` as a wheel, with the packed FMUs inside.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cargo_fmu::notices::Notices;
use cargo_fmu::pack::Platforms;
use cargo_fmu::process::execute;
use cargo_fmu::target::{Tools, ZIG};
use clap::Args;

use crate::python::Python;
use crate::workspace::Workspace;
use crate::{libclang, pack};

/// What compiles the native module and writes the wheel.
const MATURIN: &str = "maturin==1.16.0\n";
/// Environment variable with the program that the package's runs are compared with.
const PROGRAM: &str = "HDRM_FMU";
/// What the notices of the crates in the module are collected for.
const LINUX: &str = "x86_64-unknown-linux-gnu";
/// Files of a folder of packed FMUs that go into the package.
const PACKED: [&str; 2] = ["fmu", "ssp"];

/// Options of `cargo xtask wheel`.
#[derive(Args)]
pub struct Options {
    /// Only put the FMUs and the parameters into the package, as pip needs them before it builds
    #[arg(long)]
    prepare: bool,
    /// Of this folder of packed FMUs [default: they are packed]
    #[arg(long, value_name = "DIR")]
    fmus: Option<PathBuf>,
    /// For any Linux with glibc 2.17 or newer, by zig as the linker
    #[arg(long)]
    manylinux: bool,
    /// Install the wheel for this machine in an environment of its own, and run its tests and its notebook there
    #[arg(long, conflicts_with_all = ["prepare", "manylinux"])]
    check: bool,
    /// Folder for the wheel [default: wheels/ in the cargo target directory]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Build the wheel, or prepare the package.
pub fn run(workspace: &Workspace, caller: &Path, options: &Options) -> Result<()> {
    let fmus = match &options.fmus {
        Some(folder) => caller.join(folder),
        None => {
            let folder = workspace.fmu_dir();
            pack::suite(workspace, &folder)?;
            folder
        }
    };
    if options.check {
        return check(workspace, &fmus);
    }
    if options.prepare {
        libclang::provide(workspace)?;
        return prepare(workspace, &fmus);
    }
    let out = options.out.clone();
    let out = caller.join(out.unwrap_or_else(|| workspace.target.join("wheels")));
    let wheel = build(workspace, &fmus, options.manylinux, &out)?;
    let size = fs::metadata(&wheel)?.len();
    println!("built {} ({} kB)", wheel.display(), size / 1000);
    Ok(())
}

/// Put the packed FMUs and systems of a folder, and the parameter files, into the package, in place of what was there.
pub fn prepare(workspace: &Workspace, fmus: &Path) -> Result<()> {
    let data = workspace.root.join("python/hdrm_fmu/data");
    if data.exists() {
        fs::remove_dir_all(&data)?;
    }
    let parameters = data.join("parameters");
    fs::create_dir_all(&parameters).with_context(|| parameters.display().to_string())?;
    let packed = copy(fmus, &PACKED, &data)?;
    ensure!(packed > 0, "{} holds no packed FMUs", fmus.display());
    copy(&workspace.root.join("parameters"), &["json"], &parameters)?;
    let notices = Notices::new(&workspace.cargo)?;
    for (name, bytes) in notices.files(&workspace.cargo, "hdrm-fmu-python", &[LINUX])? {
        fs::write(data.join(name), bytes)?;
    }
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        fs::copy(workspace.root.join(licence), data.join(licence)).context(licence)?;
    }
    Ok(())
}

/// Copy the files with these suffixes; how many there are.
fn copy(from: &Path, suffixes: &[&str], to: &Path) -> Result<usize> {
    let mut count = 0;
    for entry in fs::read_dir(from).with_context(|| from.display().to_string())? {
        let path = entry?.path();
        let suffix = path.extension().unwrap_or_default().to_string_lossy();
        if let (Some(name), true) = (path.file_name(), suffixes.contains(&suffix.as_ref())) {
            fs::copy(&path, to.join(name)).with_context(|| path.display().to_string())?;
            count += 1;
        }
    }
    Ok(count)
}

/// The wheel with the FMUs of a folder, in `out`: for this machine, or with `manylinux` for any x86-64 Linux with glibc 2.17.
pub fn build(workspace: &Workspace, fmus: &Path, manylinux: bool, out: &Path) -> Result<PathBuf> {
    prepare(workspace, fmus)?;
    let python = Python::provide(workspace)?;
    python.install(workspace, "maturin", MATURIN)?;
    let new = out.join("new");
    if new.exists() {
        fs::remove_dir_all(&new)?;
    }
    let mut command = workspace.command(python.program());
    command.args(["-m", "maturin", "build", "--release", "--locked"]);
    command.args(["--manifest-path", "python/Cargo.toml", "--out"]);
    command.arg(&new).envs(libclang::provide(workspace)?);
    if manylinux {
        python.install(workspace, "zig", ZIG)?;
        let platforms = Platforms::named(&["linux64".to_string()])?;
        let target = platforms.targets.first().context("linux64 is known")?;
        let tools = python.program().parent().map(Path::to_path_buf);
        let tools = Tools(tools.into_iter().collect());
        command.args(["--zig", "--compatibility", "manylinux2014", "--target"]);
        command.arg(target.triple);
        command.env("PATH", tools.search_path()?);
        let (name, arguments) = crate::dist::bindgen_arguments(workspace, target.triple)?;
        command.env(name, arguments);
        for check in ["DEBUG_ASSERTIONS", "OVERFLOW_CHECKS"] {
            command.env(format!("CARGO_PROFILE_RELEASE_{check}"), "false");
        }
    } else {
        command.args(["--compatibility", "linux"]);
    }
    execute(&mut command)?;
    let built = fs::read_dir(&new)?
        .next()
        .context("maturin made no wheel")??;
    let wheel = out.join(built.file_name());
    fs::rename(built.path(), &wheel)?;
    fs::remove_dir(&new)?;
    Ok(wheel)
}

/// Build the wheel for this machine, install it in an environment of its own, and run its tests and its notebook there. The tests compare it
/// with the program that the environment variable `HDRM_FMU` names, else with that of the same source.
pub fn check(workspace: &Workspace, fmus: &Path) -> Result<()> {
    let wheel = build(workspace, fmus, false, &workspace.target.join("wheels"))?;
    let program = match std::env::var_os(PROGRAM) {
        Some(program) => program.into(),
        None => libclang::build_hdrm_fmu(workspace)?,
    };
    let requirements = workspace.root.join("tests/requirements-python.txt");
    let requirements =
        fs::read_to_string(&requirements).with_context(|| requirements.display().to_string())?;
    let python = Python::at(workspace, workspace.target.join("python"))?;
    python.install(workspace, "python-package", &requirements)?;
    let mut install = workspace.command(python.program());
    install.args(["-m", "pip", "install", "--quiet", "--no-deps"]);
    install.args(["--disable-pip-version-check", "--force-reinstall"]);
    execute(install.arg(&wheel))?;
    let mut pytest = workspace.command(python.program());
    pytest.args(["-m", "pytest", "-q", "--durations=5", "--nbmake"]);
    pytest.args(["python/tests", "docs/python.ipynb"]);
    execute(pytest.env(PROGRAM, program))
}
