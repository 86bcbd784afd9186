//! Packs the suite's FMUs, and the systems that are made of them.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cargo_fmu::pack::Platforms;
use cargo_fmu::workspace::Source;
use fmi_description::entries::{self, Entries};

use crate::variants;
use crate::workspace::{FMU_PROFILE, Workspace, profile};

/// A system structure of the repository and the archive that it becomes.
struct System {
    structure: &'static str,
    archive: &'static str,
    /// Whether variants of the structure are packed beside it.
    varied: bool,
    /// Parameter sets that go with it without being bound.
    sets: &'static [&'static str],
}

/// The systems that are packed.
const SYSTEMS: [System; 5] = [
    System::new("system/SystemStructure.ssd", "Manipulator.ssp").varied(&[]),
    System::new("system/Real.ssd", "Real.ssp").varied(&["resources/real_hiab_xs031.ssv"]),
    System::new("system/Electric.ssd", "Electric.ssp").varied(&[]),
    System::new("system/Testbed.ssd", "Testbed.ssp"),
    System::new("system/RigTestbed.ssd", "RigTestbed.ssp"),
];

/// Packages of the FMUs that the first of them, the paper's, is made of.
pub const PAPER: [&str; 3] = ["fmu-emla", "fmu-hdrm", "fmu-controller"];

impl System {
    const fn new(structure: &'static str, archive: &'static str) -> Self {
        Self {
            structure,
            archive,
            varied: false,
            sets: &[],
        }
    }

    /// With variants, and with these sets beside them.
    const fn varied(mut self, sets: &'static [&'static str]) -> Self {
        (self.varied, self.sets) = (true, sets);
        self
    }
}

/// Pack the suite's FMUs and its systems into `out`, for this machine; the FMUs, in the order of
/// [`Workspace::suite`].
pub fn suite(workspace: &Workspace, out: &Path) -> Result<Vec<PathBuf>> {
    suite_with(workspace, &profile(FMU_PROFILE), &Platforms::default(), out)
}

/// The same with libraries that were built by other arguments of cargo, such as those for a
/// profile, or for other platforms.
pub fn suite_with(
    workspace: &Workspace,
    arguments: &[String],
    platforms: &Platforms,
    out: &Path,
) -> Result<Vec<PathBuf>> {
    let sources = workspace.suite();
    let packed = cargo_fmu::pack::fmus(&workspace.cargo, &sources, arguments, platforms, out)?;
    for system in &SYSTEMS {
        pack_system(workspace, &packed, system, &out.join(system.archive))?;
    }
    Ok(packed)
}

/// Pack the paper's system into `out`, and the FMUs that it needs; these are [`PAPER`].
pub fn paper_with(workspace: &Workspace, arguments: &[String], out: &Path) -> Result<()> {
    let sources = PAPER.map(|name| Source::Package(name.to_string()));
    let host = Platforms::default();
    let packed = cargo_fmu::pack::fmus(&workspace.cargo, &sources, arguments, &host, out)?;
    let system = &SYSTEMS[0];
    pack_system(workspace, &packed, system, &out.join(system.archive))
}

/// Names of the files that [`suite`] writes; a folder may hold other FMUs beside them, such as
/// those of the examples.
pub fn names(workspace: &Workspace) -> Result<Vec<String>> {
    let mut names: Vec<String> = SYSTEMS.iter().map(|s| s.archive.to_string()).collect();
    let descriptions = workspace.root.join("modelDescription");
    for entry in fs::read_dir(&descriptions).with_context(|| descriptions.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|suffix| suffix == "xml") {
            let name = path.with_extension("fmu");
            names.extend(name.file_name().map(|n| n.to_string_lossy().into_owned()));
        }
    }
    Ok(names)
}

/// Pack FMUs, built with a profile for this machine, into `out`; the files written.
pub fn fmus(
    workspace: &Workspace,
    sources: &[Source],
    profile: &str,
    out: &Path,
) -> Result<Vec<PathBuf>> {
    let (profile, host) = (self::profile(profile), Platforms::default());
    cargo_fmu::pack::fmus(&workspace.cargo, sources, &profile, &host, out)
}

/// FMUs of FMI 2.0, and after them those of FMI 3.0, which are packed beside them, in the same
/// order.
pub fn both_versions(fmus: Vec<PathBuf>) -> Result<Vec<PathBuf>> {
    let of_3 = cargo_fmu::pack::fmi3_files(&fmus)?;
    Ok([fmus, of_3].concat())
}

/// An archive of a system structure with the FMUs it names and further parameter sets beside it.
fn pack_system(
    workspace: &Workspace,
    packed: &[PathBuf],
    system: &System,
    path: &Path,
) -> Result<()> {
    let file = workspace.root.join(system.structure);
    let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    let mut structures = Vec::new();
    if system.varied {
        structures = variants::of(&text).with_context(|| file.display().to_string())?;
    }
    structures.push(("SystemStructure.ssd".to_string(), text));
    let mut entries = Entries::new();
    for set in system.sets {
        let from = file.with_file_name(set);
        let bytes = fs::read(&from).with_context(|| from.display().to_string())?;
        entries.insert((*set).to_string(), bytes);
    }
    entries.extend(with_sources(packed, &file, structures)?);
    write(path, &entries)
}

/// Pack into one archive, for a page, the structures of several systems and the FMUs that they
/// name. A page has one of them run at a time.
pub fn worlds(workspace: &Workspace, packed: &[PathBuf], path: &Path) -> Result<()> {
    let mut entries = Entries::new();
    for system in SYSTEMS.iter().filter(|system| system.varied) {
        let file = workspace.root.join(system.structure);
        let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        entries.extend(with_sources(packed, &file, vec![(name.into(), text)])?);
    }
    write(path, &entries)
}

fn write(path: &Path, entries: &Entries) -> Result<()> {
    let size = entries::write(path, entries)?;
    println!("packed {} ({} kB)", path.display(), size / 1000);
    Ok(())
}

/// Structures by name, and what they name: FMUs that have just been packed, else files beside
/// `file`.
fn with_sources(
    packed: &[PathBuf],
    file: &Path,
    structures: Vec<(String, String)>,
) -> Result<Entries> {
    let mut entries = Entries::new();
    for (name, text) in structures {
        for source in text
            .split("source=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
        {
            let fmu = packed
                .iter()
                .find(|p| p.file_name() == Path::new(source).file_name());
            let path = fmu.map_or_else(|| file.with_file_name(source), PathBuf::clone);
            let bytes = fs::read(&path).with_context(|| {
                format!("{} names {source}: {}", file.display(), path.display())
            })?;
            entries.insert(source.to_string(), bytes);
        }
        entries.insert(name, text.into_bytes());
    }
    Ok(entries)
}
