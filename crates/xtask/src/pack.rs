//! Packs FMUs and the system: ZIP archives with fixed order and times, so that equal contents give equal files.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use crate::workspace::{Fmu, Workspace};
use crate::{library, variants};

/// System structures of the repository and the archives they become.
const SYSTEMS: [(&str, &str); 2] = [
    ("system/SystemStructure.ssd", "Manipulator.ssp"),
    ("system/Testbed.ssd", "Testbed.ssp"),
];

/// Pack the suite's FMUs and its systems into `out`.
pub fn suite(workspace: &Workspace, out: &Path) -> Result<()> {
    let packed = fmus(workspace, &workspace.suite(), out)?;
    for (structure, archive) in SYSTEMS {
        system(workspace, &packed, structure, &out.join(archive))?;
    }
    Ok(())
}

/// Pack FMUs into `out`; the files written.
pub fn fmus(workspace: &Workspace, targets: &[Fmu], out: &Path) -> Result<Vec<PathBuf>> {
    fs::create_dir_all(out).with_context(|| out.display().to_string())?;
    let built = workspace.build_fmus(targets)?;
    built
        .iter()
        .map(|library| fmu(workspace, library, out))
        .collect()
}

fn fmu(workspace: &Workspace, built: &Path, out: &Path) -> Result<PathBuf> {
    let files = library::files(built)?;
    let identifier = library::identifier(library::description(&files)?)?;
    let mut entries: BTreeMap<String, Vec<u8>> = files.into_iter().collect();
    let (folder, suffix) = platform()?;
    let binary = fs::read(built).with_context(|| built.display().to_string())?;
    entries.insert(format!("binaries/{folder}/{identifier}{suffix}"), binary);
    entries.extend(licences(workspace)?);
    let path = out.join(identifier).with_extension("fmu");
    write_zip(&path, &entries)?;
    println!(
        "packed {} ({} kB)",
        path.display(),
        fs::metadata(&path)?.len() / 1000
    );
    Ok(path)
}

/// A packed FMU with another library in it, which was built otherwise from the same source.
pub fn with_library(packed: &Path, library: &Path, out: &Path) -> Result<()> {
    let mut archive = ZipArchive::new(File::open(packed)?)?;
    let mut entries = BTreeMap::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index)?;
        let name = entry.name()?.into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        if name.starts_with("binaries/") {
            bytes = fs::read(library).with_context(|| library.display().to_string())?;
        }
        entries.insert(name, bytes);
    }
    write_zip(out, &entries)
}

/// Folder in `binaries/` and suffix of the library for the machine this runs on (FMI 2.0.4, section 2.3).
fn platform() -> Result<(&'static str, &'static str)> {
    let folder = match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64" | "aarch64") => "linux64",
        ("macos", "x86_64" | "aarch64") => "darwin64",
        ("windows", "x86_64") => "win64",
        (os, arch) => bail!("FMI 2.0 has no folder for the platform {os} {arch}"),
    };
    Ok((folder, std::env::consts::DLL_SUFFIX))
}

/// The workspace's licence files, below `licenses/`, with the entry point that FMI asks for.
fn licences(workspace: &Workspace) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut found = BTreeMap::new();
    let mut names = Vec::new();
    for entry in fs::read_dir(&workspace.root)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with("LICENSE") {
            found.insert(format!("licenses/{name}"), fs::read(entry.path())?);
            names.push(name);
        }
    }
    if !names.is_empty() {
        names.sort();
        let text = format!(
            "MIT OR Apache-2.0, at your option; the texts: {}\n",
            names.join(", ")
        );
        found.insert("licenses/license.txt".to_string(), text.into_bytes());
    }
    Ok(found)
}

/// An archive of a system structure with the FMUs it names.
fn system(workspace: &Workspace, packed: &[PathBuf], structure: &str, path: &Path) -> Result<()> {
    let file = workspace.root.join(structure);
    let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    let mut structures = variants::of(&text).with_context(|| file.display().to_string())?;
    structures.push(("SystemStructure.ssd".to_string(), text));
    let mut entries = BTreeMap::new();
    for (name, text) in structures {
        for source in text
            .split("source=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
        {
            // An FMU that has just been packed, else a file beside the structure.
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
    write_zip(path, &entries)?;
    println!(
        "packed {} ({} kB)",
        path.display(),
        fs::metadata(path)?.len() / 1000
    );
    Ok(())
}

fn write_zip(path: &Path, entries: &BTreeMap<String, Vec<u8>>) -> Result<()> {
    let mut zip = ZipWriter::new(File::create(path).with_context(|| path.display().to_string())?);
    for (name, bytes) in entries {
        let mode = if name.starts_with("binaries/") {
            0o755
        } else {
            0o644
        };
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(mode);
        zip.start_file(name.as_str(), options)
            .with_context(|| name.clone())?;
        zip.write_all(bytes)?;
    }
    zip.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries are sorted by name and carry one fixed time, so that nothing but their contents decides the archive's bytes.
    #[test]
    fn equal_contents_give_equal_archives() {
        let path = std::env::temp_dir().join(format!("xtask-pack-{}.zip", std::process::id()));
        let entries = BTreeMap::from([
            ("b/x".to_string(), vec![1; 1000]),
            ("a".to_string(), b"text".to_vec()),
        ]);
        write_zip(&path, &entries).unwrap();
        let mut archive = ZipArchive::new(File::open(&path).unwrap()).unwrap();
        let written = (0..archive.len()).map(|k| {
            let entry = archive.by_index(k).unwrap();
            (entry.name().unwrap().into_owned(), entry.last_modified())
        });
        let expected = ["a", "b/x"].map(|name| (name.to_string(), Some(DateTime::default())));
        assert_eq!(written.collect::<Vec<_>>(), expected);
        fs::remove_file(&path).unwrap();
    }
}
