//! What is measured, built: bench programs, the suite's FMUs, programs in C.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::process::execute;
use cargo_fmu::workspace::Source;
use cargo_fmu::{archive, library, platform};

use crate::workspace::{FMU_PROFILE, Workspace};

/// Bench programs of the crates (`crates/*/benches`).
pub const PROGRAMS: [&str; 3] = ["dynamics", "step", "controller"];

/// The coupled machine under the native master.
pub const COUPLED: &str = "coupled step of 1 ms, cosim, no recording";
pub const COUPLED_RECORDED: &str = "coupled step of 1 ms, cosim with CSV";

/// The paper's table, 30 runs; its ratio to the one below is the gain by the cores of the machine.
pub const TABLE_ON_ALL_CORES: &str = "hdrm-fmu table, all cores";
pub const TABLE_ON_ONE_CORE: &str = "hdrm-fmu table, one core";

/// Three calls at the border, which cost what the border costs.
pub const BORDER_IN_RUST: &str = "set of 4 + step + get of 4, Rust (fmu-export)";
pub const BORDER_IN_C: &str = "set of 4 + step + get of 4, C by hand";

/// BenchInputs programs and packed FMUs.
pub struct BenchInputs {
    pub programs: BTreeMap<String, PathBuf>,
    pub cosim: PathBuf,
    pub hdrm_fmu: PathBuf,
    /// The suite.
    pub fmus: Vec<PathBuf>,
    /// Where it lies, with its systems.
    pub folder: PathBuf,
}

/// Build these bench programs of the crates, and the other programs, for packed FMUs.
pub fn build(workspace: &Workspace, fmus: Vec<PathBuf>, programs: &[&str]) -> Result<BenchInputs> {
    let folder = fmus.first().and_then(|fmu| fmu.parent());
    let folder = folder.context("no FMU was packed")?.to_path_buf();
    let targets: Vec<&str> = programs.iter().flat_map(|name| ["--bench", name]).collect();
    Ok(BenchInputs {
        programs: match targets.is_empty() {
            true => BTreeMap::new(),
            false => workspace.build(FMU_PROFILE, &targets)?,
        },
        cosim: workspace.build_programs(&["cosim"])?,
        hdrm_fmu: workspace.build_programs(&["hdrm-fmu"])?,
        fmus,
        folder,
    })
}

impl BenchInputs {
    pub fn program(&self, name: &str) -> Result<&Path> {
        let found = self.programs.get(name).map(PathBuf::as_path);
        found.with_context(|| format!("cargo has built no bench `{name}`"))
    }

    /// `cosim bench` on the packed system: the cubic trajectory, adaptive.
    pub fn coupled(&self, workspace: &Workspace) -> Command {
        let mut cosim = workspace.command(&self.cosim);
        let system = self.folder.join("Manipulator.ssp");
        cosim.args(["bench", "--system"]).arg(system);
        cosim.args(["--set", "controller.trajectory=cubic"]);
        cosim.args(["--set", "controller.mode=adaptive"]);
        cosim
    }
}

/// The same FMU from Rust and from C under the same C program.
pub fn overhead(workspace: &Workspace) -> Result<[Command; 2]> {
    let in_c = compiled(workspace, "integrators.c", &["-shared", "-fPIC"])?;
    let driver = compiled(workspace, "overhead.c", &["-ldl"])?;
    let in_rust = Source::Example("integrators".to_string());
    let in_rust = workspace.build_fmus(&[in_rust])?.remove(0);
    let guid = library::description(&library::files(&in_rust)?)?.guid;
    let job = |name: &str, library: &Path| {
        let mut command = workspace.command(&driver);
        command.arg(name).arg(library).arg(&guid);
        command
    };
    Ok([job(BORDER_IN_RUST, &in_rust), job(BORDER_IN_C, &in_c)])
}

/// The C program that makes instances of packed FMUs: the name of each, and the command.
pub fn instantiation(workspace: &Workspace, fmus: &[PathBuf]) -> Result<Vec<(String, Command)>> {
    let driver = compiled(workspace, "overhead.c", &["-ldl"])?;
    let job = |fmu: &PathBuf| {
        let library = library_in(workspace, fmu)?;
        let description = library::description(&library::files(&library)?)?;
        let mut command = workspace.command(&driver);
        command.arg(&description.model).arg(library);
        command.arg(description.guid);
        Ok((description.model, command))
    };
    fmus.iter().map(job).collect()
}

/// The library for this machine in a packed FMU, unpacked.
pub fn library_in(workspace: &Workspace, fmu: &Path) -> Result<PathBuf> {
    let entries = archive::read(fmu)?;
    let folder = format!("binaries/{}/", platform::host()?.folder);
    let library = entries
        .iter()
        .find_map(|(name, bytes)| Some((name.strip_prefix(&folder)?, bytes)));
    let (name, bytes) = library.with_context(|| format!("{folder} in {}", fmu.display()))?;
    let folder = workspace.target.join("bench");
    fs::create_dir_all(&folder)?;
    let path = folder.join(name);
    fs::write(&path, bytes).with_context(|| path.display().to_string())?;
    Ok(path)
}

/// A C source of `tests/bench`, compiled.
pub fn compiled(workspace: &Workspace, source: &str, options: &[&str]) -> Result<PathBuf> {
    let folder = workspace.target.join("bench");
    fs::create_dir_all(&folder)?;
    let program = folder.join(Path::new(source).with_extension("out"));
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_string());
    let mut cc = workspace.command(&compiler);
    cc.args(["-O2", "-o"]).arg(&program);
    cc.arg(workspace.root.join("tests/bench").join(source));
    execute(cc.args(options))?;
    Ok(program)
}
