//! `cargo xtask wheel`: makes a wheel of the Python package `hdrm_fmu`; also for `dist` and `test`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use anyhow::{Context, Result, ensure};
use cargo_fmu::notices::Notices;
use cargo_fmu::pack::Platforms;
use cargo_fmu::process::execute;
use cargo_fmu::target::{Target, Tools, private_folders};
use clap::Args;
use fmi_description::entries;
use fmi_import::portability;

use crate::python::Python;
use crate::workspace::{FMU_PROFILE, Workspace, archives, file_name, files, profile};
use crate::{dist, pack};

/// The program that compiles the native module and writes the wheel.
const MATURIN: &str = "maturin==1.16.0\n";
/// Environment variable with the program that the package's runs are compared with.
const PROGRAM: &str = "HDRM_FMU";
/// The target whose crates' notices go into a wheel for this machine.
const LINUX: &str = "x86_64-unknown-linux-gnu";
/// Platforms of wheels for other machines; the FMUs in each hold libraries for all of these.
const PLATFORMS: [&str; 2] = ["linux64", "win64"];
/// The platform whose wheel `cargo xtask dist` hands out; the others have never been installed
/// anywhere.
pub const HANDED_OUT_FOR: &str = "linux64";
/// The profile of programs that are handed out, as environment variables for maturin.
const HANDED_OUT: [(&str, &str); 3] = [
    ("CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS", "false"),
    ("CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS", "false"),
    ("CARGO_PROFILE_RELEASE_STRIP", "symbols"),
];
/// What the packed suite is made from, besides the folders `fmu-*`.
const MADE_FROM: [&str; 8] = [
    "Cargo.lock",
    "Cargo.toml",
    "actuator-table",
    "fmi",
    "kit",
    "machine",
    "parameters",
    "system",
];
/// The profile of a package that pip builds.
const PIP_PROFILE: &str = "pip";
/// Package of the native module.
const MODULE: &str = "hdrm-fmu-python";
/// The library that a module for Windows needs; every Python 3 brings it.
const PYTHON_DLL: &str = "python3.dll";

#[derive(Args)]
pub struct Options {
    /// Only put the FMUs and the parameters into the package, as pip needs them before it builds
    #[arg(long)]
    prepare: bool,
    /// Pack the FMUs without optimisation of whole programs; those in the build folder are taken if
    /// they are newer than their sources
    #[arg(long, conflicts_with_all = ["fmus", "manylinux", "windows"])]
    quick: bool,
    /// Of this folder of packed FMUs, such as that of `cargo xtask dist` [default: they are packed]
    #[arg(long, value_name = "DIR")]
    fmus: Option<PathBuf>,
    /// For any x86-64 Linux with glibc 2.17 or newer (manylinux2014), by zig as the linker
    #[arg(long)]
    manylinux: bool,
    /// For Windows (win_amd64), by the MinGW linker
    #[arg(long)]
    windows: bool,
    /// Install the wheel for this machine in an environment of its own, and run its tests and its
    /// notebook there
    #[arg(long, conflicts_with_all = ["prepare", "manylinux", "windows"])]
    check: bool,
    /// Install a finished wheel in an empty environment and run its demo with nothing in the search
    /// path: here, and one for any Linux in an old Debian too
    #[arg(long, value_name = "WHEEL", conflicts_with_all = ["prepare", "manylinux", "windows", "check"])]
    trial: Option<PathBuf>,
    /// Folder for the wheel [default: wheels/ in the cargo target directory]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Builds wheels, or does what the options say instead.
pub fn run(workspace: &Workspace, caller: &Path, options: &Options) -> Result<()> {
    if let Some(wheel) = &options.trial {
        return dist::try_wheel(workspace, &caller.join(wheel));
    }
    let chosen = PLATFORMS
        .into_iter()
        .zip([options.manylinux, options.windows]);
    let targets = chosen.filter(|(_, is_chosen)| *is_chosen);
    let targets = targets.map(|(folder, _)| Target::named(folder));
    let targets = targets.collect::<Result<Vec<_>>>()?;
    let fmus = match &options.fmus {
        Some(folder) => caller.join(folder),
        None if options.quick => quickly_packed(workspace)?,
        None => packed(workspace, !targets.is_empty())?,
    };
    if options.check {
        return check(workspace, &fmus);
    }
    if options.prepare {
        return prepare(workspace, &fmus, LINUX);
    }
    let out = options.out.clone();
    let out = caller.join(out.unwrap_or_else(|| workspace.target.join("wheels")));
    let targets = match targets.is_empty() {
        true => vec![None],
        false => targets.into_iter().map(Some).collect(),
    };
    for target in targets {
        build(workspace, &fmus, target, &out)?;
    }
    Ok(())
}

/// Packs the suite for this machine, or in another folder for all machines of [`PLATFORMS`];
/// returns the folder.
fn packed(workspace: &Workspace, is_portable: bool) -> Result<PathBuf> {
    if !is_portable {
        let folder = workspace.fmu_dir();
        pack::suite(workspace, &folder)?;
        return Ok(folder);
    }
    let mut platforms = Platforms::named(&PLATFORMS.map(String::from))?;
    platforms.tools = Python::provide(workspace)?.zig(workspace)?;
    let folder = workspace.target.join("fmu-portable");
    pack::suite_with(workspace, &profile(FMU_PROFILE), &platforms, &folder)?;
    Ok(folder)
}

/// The folder of the suite for this machine, packed with [`PIP_PROFILE`] unless it is packed and newer
/// than all that it is made from.
fn quickly_packed(workspace: &Workspace) -> Result<PathBuf> {
    let folder = workspace.fmu_dir();
    let names = pack::names(workspace)?;
    let packed = names.iter().map(|name| changed(&folder.join(name)));
    if let Ok(packed) = packed.collect::<Result<Vec<_>>>() {
        let suite = fs::read_dir(&workspace.root)?.collect::<Result<Vec<_>, _>>()?;
        let suite = suite.iter().map(|entry| entry.file_name());
        let suite = suite.filter(|name| name.to_string_lossy().starts_with("fmu-"));
        let made_from = MADE_FROM.into_iter().map(Into::into).chain(suite);
        let sources = made_from.map(|name| last_changed(&workspace.root.join(name)));
        let newest = sources.collect::<Result<Vec<_>>>()?.into_iter().max();
        if packed.into_iter().min() > newest {
            println!("taking the FMUs that are in {}", folder.display());
            return Ok(folder);
        }
    }
    let mut arguments = profile(PIP_PROFILE).to_vec();
    // With the module, so that what it shares with the FMUs has the same features and is compiled once.
    arguments.extend(["--package".into(), MODULE.into()]);
    pack::suite_with(workspace, &arguments, &Platforms::default(), &folder)?;
    Ok(folder)
}

/// When a file was changed.
fn changed(path: &Path) -> Result<SystemTime> {
    let data = fs::metadata(path).with_context(|| path.display().to_string())?;
    Ok(data.modified()?)
}

/// When a file, or the last of a folder's files, was changed.
fn last_changed(path: &Path) -> Result<SystemTime> {
    if path.is_file() {
        return changed(path);
    }
    let times = files(path)?;
    let times = times.iter().map(|file| changed(file));
    let times = times.collect::<Result<Vec<_>>>()?;
    times
        .into_iter()
        .max()
        .with_context(|| path.display().to_string())
}

/// Replaces the package's data: the packed FMUs and systems of a folder, the parameter files, and
/// the notices of the crates in the native module for a compiler's target.
fn prepare(workspace: &Workspace, fmus: &Path, triple: &str) -> Result<()> {
    let data = workspace.root.join("python/hdrm_fmu/data");
    if data.exists() {
        fs::remove_dir_all(&data)?;
    }
    let parameters = data.join("parameters");
    fs::create_dir_all(&parameters).with_context(|| parameters.display().to_string())?;
    for name in pack::names(workspace)? {
        let from = fmus.join(&name);
        fs::copy(&from, data.join(&name)).with_context(|| from.display().to_string())?;
    }
    for from in archives(&workspace.root.join("parameters"), "json")? {
        let to = parameters.join(file_name(&from));
        fs::copy(&from, to).with_context(|| from.display().to_string())?;
    }
    let notices = Notices::new(&workspace.cargo)?;
    for (name, bytes) in notices.files(&workspace.cargo, MODULE, &[triple])? {
        fs::write(data.join(name), bytes)?;
    }
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        fs::copy(workspace.root.join(licence), data.join(licence)).context(licence)?;
    }
    Ok(())
}

/// Builds the wheel with the FMUs of a folder into `out`: for this machine or a platform. Refuses a
/// module or an FMU that would not run on every machine of the platform.
pub fn build(
    workspace: &Workspace,
    fmus: &Path,
    target: Option<&Target>,
    out: &Path,
) -> Result<PathBuf> {
    if let Some(target) = target {
        check_libraries(workspace, fmus, target)?;
    }
    prepare(workspace, fmus, target.map_or(LINUX, |t| t.triple))?;
    let python = builder(workspace)?;
    let new = out.join("new");
    if new.exists() {
        fs::remove_dir_all(&new)?;
    }
    let mut command = workspace.command(python.program());
    command.args(["-m", "maturin", "build", "--release", "--locked"]);
    command.args(["--manifest-path", "python/Cargo.toml", "--out"]);
    command.arg(&new);
    match target {
        Some(target) => for_target(workspace, &python, target, &mut command)?,
        None => {
            command.args(["--compatibility", "linux"]);
        }
    }
    execute(&mut command)?;
    let built = fs::read_dir(&new)?.next();
    let built = built.context("maturin made no wheel")??;
    if let Some(target) = target {
        check_wheel(workspace, &built.path(), target)?;
    }
    let wheel = out.join(built.file_name());
    fs::rename(built.path(), &wheel)?;
    fs::remove_dir(&new)?;
    let size = fs::metadata(&wheel)?.len();
    println!("built {} ({} kB)", wheel.display(), size / 1000);
    Ok(wheel)
}

/// Has maturin build for a platform, with the flags and profile of programs that are handed out.
fn for_target(
    workspace: &Workspace,
    python: &Python,
    target: &Target,
    maturin: &mut Command,
) -> Result<()> {
    let mut tools = Tools::default();
    if target.needs_zig() {
        tools = python.zig(workspace)?;
        maturin.args(["--zig", "--compatibility", "manylinux2014"]);
    }
    let build = target.build(&workspace.cargo, &tools)?;
    let set = build
        .get_envs()
        .filter_map(|(name, value)| Some((name, value?)));
    maturin.envs(set).envs(HANDED_OUT);
    maturin.args(["--target", target.triple]);
    Ok(())
}

/// Refuses FMUs without a library that runs on every machine of a platform.
fn check_libraries(workspace: &Workspace, fmus: &Path, target: &Target) -> Result<()> {
    let folder = format!("binaries/{}/", target.platform.folder);
    let names = pack::names(workspace)?;
    for name in names.iter().filter(|name| name.ends_with(".fmu")) {
        let path = fmus.join(name);
        let entries = entries::read(&path)?;
        let library = entries.iter().find(|(name, _)| name.starts_with(&folder));
        let shown = path.display();
        let (_, library) = library.with_context(|| format!("{shown} has nothing in {folder}"))?;
        let faults = target.faults(library, &workspace.cargo)?;
        ensure!(
            faults.is_empty(),
            "{shown}: its library {}",
            faults.join("; it ")
        );
    }
    Ok(())
}

/// Refuses a wheel whose module would not run on every machine of the platform that has Python, or
/// that names folders of this machine. Its FMUs have been checked before.
fn check_wheel(workspace: &Workspace, wheel: &Path, target: &Target) -> Result<()> {
    let entries = entries::read(wheel)?;
    let module = entries
        .iter()
        .find(|(name, _)| name.starts_with("hdrm_fmu/_native"));
    let (name, module) = module.with_context(|| format!("{} has no module", wheel.display()))?;
    let mut faults = target.faults(module, &workspace.cargo)?;
    faults.retain(|fault| !fault.contains(PYTHON_DLL));
    ensure!(faults.is_empty(), "{name} {}", faults.join("; it "));
    let folders = private_folders(&workspace.cargo)?;
    let is_archive = |name: &str| name.ends_with(".fmu") || name.ends_with(".ssp");
    for (name, bytes) in entries.iter().filter(|(name, _)| !is_archive(name)) {
        let named = portability::folders_in(bytes, &folders);
        ensure!(named.is_empty(), "{name} names {}", named.join(", "));
    }
    Ok(())
}

/// The environment that builds the package.
fn builder(workspace: &Workspace) -> Result<Python> {
    let python = Python::provide(workspace)?;
    python.install(workspace, "maturin", MATURIN)?;
    Ok(python)
}

/// Installs the environments that build and test the package, before anything else uses them.
pub fn install(workspace: &Workspace) -> Result<()> {
    builder(workspace)?;
    environment(workspace).map(drop)
}

/// The environment that tests the package.
fn environment(workspace: &Workspace) -> Result<Python> {
    let python = Python::at(workspace, workspace.target.join("python"))?;
    python.install_file(workspace, "python-package", "tests/requirements-python.txt")?;
    Ok(python)
}

/// Builds the wheel for this machine, installs it in its own environment, and runs its tests and
/// its notebook there. The tests compare it with the programs in the folder of the one that the
/// variable `HDRM_FMU` names; without it, with programs built from the same source.
pub fn check(workspace: &Workspace, fmus: &Path) -> Result<()> {
    let wheel = build(workspace, fmus, None, &workspace.target.join("wheels"))?;
    let program = match std::env::var_os(PROGRAM) {
        Some(program) => program.into(),
        None => workspace.build_programs(&["hdrm-fmu", "cosim"])?,
    };
    let python = environment(workspace)?;
    let mut install = workspace.command(python.program());
    install.args(["-m", "pip", "install", "--quiet", "--no-deps"]);
    install.args(["--disable-pip-version-check", "--force-reinstall"]);
    execute(install.arg(&wheel))?;
    let mut pytest = workspace.command(python.program());
    pytest.args(["-m", "pytest", "-q", "--durations=5", "--nbmake"]);
    pytest.args(["python/tests", "docs/studies/python.ipynb"]);
    execute(pytest.env(PROGRAM, program))
}
