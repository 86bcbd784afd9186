//! The folder that `cargo xtask dist` makes, and the files in it; its listing and checks read them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cargo_fmu::pack::FMI3_FOLDER;
use cargo_fmu::target::Target;

/// Name of the list of checksums, in the form of `sha256sum`.
pub const CHECKSUMS: &str = "SHA256SUMS";

pub struct Dist {
    pub folder: PathBuf,
    pub targets: Vec<&'static Target>,
    /// File names of the FMUs, in the order of `Workspace::suite`.
    pub suite: Vec<String>,
    /// Programs by platform folder and name; also those that only the checks need.
    pub programs: BTreeMap<(&'static str, String), PathBuf>,
}

impl Dist {
    /// The FMUs of FMI 2.0.
    pub fn fmus(&self) -> Result<Vec<PathBuf>> {
        archives(&self.folder, "fmu")
    }

    /// The FMUs of FMI 3.0.
    pub fn fmus_3(&self) -> Result<Vec<PathBuf>> {
        archives(&self.folder.join(FMI3_FOLDER), "fmu")
    }

    pub fn systems(&self) -> Result<Vec<PathBuf>> {
        archives(&self.folder, "ssp")
    }
}

/// The files with this suffix in a folder itself, sorted by name.
fn archives(folder: &Path, suffix: &str) -> Result<Vec<PathBuf>> {
    let mut all = files(folder)?;
    let is_one = |path: &PathBuf| {
        path.parent() == Some(folder) && path.extension().is_some_and(|e| e == suffix)
    };
    all.retain(is_one);
    Ok(all)
}

/// All files below a folder, sorted by name.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        match path.is_dir() {
            true => found.extend(files(&path)?),
            false => found.push(path),
        }
    }
    found.sort();
    Ok(found)
}

pub fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
