//! An FMU opened: unpacked if it is packed, its description read, its library loaded.

use super::functions::Functions;
use crate::library::{Library, resources};
use crate::platform;
use anyhow::{Context, Result};
use fmi_description::{Access, Archive, Description, Variable, library_among};
use std::collections::BTreeSet;
use std::ffi::CString;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A loaded FMU. The unpacked files go with it.
pub struct Fmu {
    /// The C functions.
    pub functions: Functions,
    /// What it says about itself.
    pub description: Description,
    /// fmuResourceLocation or resourcePath; empty for a bare library.
    pub resources: CString,
    _folder: Option<TempDir>,
}

impl Fmu {
    /// Opens a `.fmu` file.
    pub fn open(path: &Path) -> Result<Self> {
        Self::packed(path).with_context(|| path.display().to_string())
    }

    /// Opens an FMU whose files lie in a folder.
    pub fn unpacked(folder: &Path) -> Result<Self> {
        let description = Description::read(&fs::read(folder.join("modelDescription.xml"))?)?;
        let library = library_path(folder, &description)?;
        let resources = resources(folder, description.fmi);
        Ok(Self {
            functions: Functions::load(load(&library)?, &description),
            description,
            resources: CString::new(resources)?,
            _folder: None,
        })
    }

    /// The variable with this value reference, which FMUs made with fmu-export give only once,
    /// whatever its type; of aliases the first.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        let mut variables = self.description.variables.iter();
        variables.find(|v| v.reference == reference)
    }

    /// The types that it has variables of.
    pub fn accesses(&self) -> BTreeSet<Access> {
        self.description
            .variables
            .iter()
            .map(Variable::access)
            .collect()
    }

    fn packed(path: &Path) -> Result<Self> {
        let folder = TempDir::with_prefix("cargo-fmu-")?;
        Archive::open(fs::read(path)?)?.unpack(folder.path())?;
        let mut fmu = Self::unpacked(folder.path())?;
        fmu._folder = Some(folder);
        Ok(fmu)
    }

    /// A library by itself, of which this is known.
    pub fn bare(path: &Path, description: Description) -> Result<Self> {
        Ok(Self {
            functions: Functions::load(load(path)?, &description),
            description,
            resources: CString::default(),
            _folder: None,
        })
    }
}

/// The library for this machine in the folder of an FMU.
fn library_path(folder: &Path, description: &Description) -> Result<PathBuf> {
    let mut names = Vec::new();
    for platform in fs::read_dir(folder.join("binaries"))?.flatten() {
        for file in fs::read_dir(platform.path())
            .into_iter()
            .flatten()
            .flatten()
        {
            let [platform, file] = [platform.file_name(), file.file_name()];
            let [platform, file] = [platform.to_string_lossy(), file.to_string_lossy()];
            names.push(format!("binaries/{platform}/{file}"));
        }
    }
    let names = names.iter().map(String::as_str);
    let (library, _) = library_among(names, description, platform::host()?)?;
    Ok(folder.join(library))
}

fn load(path: &Path) -> Result<Library> {
    Library::open(path).context("the library cannot be loaded")
}
