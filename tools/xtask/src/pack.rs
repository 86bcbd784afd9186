//! `cargo xtask pack`: packs the suite's FMUs and the systems made of them; most commands call it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cargo_fmu::pack::Platforms;
use cargo_fmu::workspace::Source;
use fmi_description::entries::{self, Entries};

use crate::variants;
use crate::workspace::{FMU_PROFILE, Workspace, archives, file_name, profile};

/// A system structure of the repository, and the archive that it is packed into.
struct System {
    structure: &'static str,
    archive: &'static str,
    /// Whether variants of the structure are packed with it.
    has_variants: bool,
}

impl System {
    const fn new(structure: &'static str, archive: &'static str, has_variants: bool) -> Self {
        Self {
            structure,
            archive,
            has_variants,
        }
    }
}

/// The systems that are packed; the first is the paper's.
const SYSTEMS: [System; 5] = [
    System::new("system/SystemStructure.ssd", "Manipulator.ssp", true),
    System::new("system/Real.ssd", "Real.ssp", true),
    System::new("system/Electric.ssd", "Electric.ssp", true),
    System::new("system/Testbed.ssd", "Testbed.ssp", false),
    System::new("system/RigTestbed.ssd", "RigTestbed.ssp", false),
];

/// Parameter sets that are packed into an archive although its structure does not bind them.
const UNBOUND_SETS: [(&str, &str); 1] = [("Real.ssp", "resources/real_hiab_xs031.ssv")];

/// Packages of the FMUs in the paper's system.
pub const PAPER: [&str; 3] = ["fmu-emla", "fmu-hdrm", "fmu-controller"];

/// Packs the suite's FMUs and its systems into `out`, for this machine; returns the FMUs, in the
/// order of [`Workspace::suite`].
pub fn suite(workspace: &Workspace, out: &Path) -> Result<Vec<PathBuf>> {
    suite_with(workspace, &profile(FMU_PROFILE), &Platforms::default(), out)
}

/// The same with other arguments of cargo, such as another profile, or for other platforms.
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

/// Packs the paper's system and its FMUs, [`PAPER`], into `out`.
pub fn paper_with(workspace: &Workspace, arguments: &[String], out: &Path) -> Result<()> {
    let sources = PAPER.map(|name| Source::Package(name.to_string()));
    let host = Platforms::default();
    let packed = cargo_fmu::pack::fmus(&workspace.cargo, &sources, arguments, &host, out)?;
    let system = &SYSTEMS[0];
    pack_system(workspace, &packed, system, &out.join(system.archive))
}

/// Names of the files that [`suite`] writes; its folder may hold other FMUs, such as the examples.
pub fn names(workspace: &Workspace) -> Result<Vec<String>> {
    let mut names: Vec<String> = SYSTEMS.iter().map(|s| s.archive.to_string()).collect();
    let descriptions = archives(&workspace.root.join("modelDescription"), "xml")?;
    let fmus = descriptions.iter().map(|path| path.with_extension("fmu"));
    names.extend(fmus.map(|path| file_name(&path)));
    Ok(names)
}

/// Packs FMUs, built with a profile for this machine, into `out`; returns the files.
pub fn fmus(
    workspace: &Workspace,
    sources: &[Source],
    profile: &str,
    out: &Path,
) -> Result<Vec<PathBuf>> {
    let (profile, host) = (self::profile(profile), Platforms::default());
    cargo_fmu::pack::fmus(&workspace.cargo, sources, &profile, &host, out)
}

/// Packs a system structure with its variants and the files that it names.
fn pack_system(
    workspace: &Workspace,
    packed: &[PathBuf],
    system: &System,
    path: &Path,
) -> Result<()> {
    let file = workspace.root.join(system.structure);
    let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    let mut structures = Vec::new();
    if system.has_variants {
        structures = variants::variants(&text).with_context(|| file.display().to_string())?;
    }
    structures.push(("SystemStructure.ssd".to_string(), text));
    let mut entries = Entries::new();
    for (_, set) in UNBOUND_SETS.iter().filter(|s| s.0 == system.archive) {
        let from = file.with_file_name(set);
        let bytes = fs::read(&from).with_context(|| from.display().to_string())?;
        entries.insert((*set).to_string(), bytes);
    }
    entries.extend(with_sources(packed, &file, structures)?);
    write(path, &entries)
}

/// Packs into one archive, for the live page, the structures of several systems and the FMUs that
/// they name. The page runs one of them at a time.
pub fn worlds(workspace: &Workspace, packed: &[PathBuf], path: &Path) -> Result<()> {
    let mut entries = Entries::new();
    for system in SYSTEMS.iter().filter(|system| system.has_variants) {
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

/// Structures by name, with the files that they name: FMUs that have just been packed, else files
/// in the folder of `file`.
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
