//! An FMU opened: unpacked if it is packed, its description read, its library loaded.

use crate::functions::Functions;
use anyhow::{Context, Result};
use cargo_fmu::{library, platform};
use fmu_description::{Description, Variable};
use libloading::Library;
use std::ffi::CString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// A loaded FMU. The unpacked files go with it.
pub struct Fmu {
    /// The C functions.
    pub functions: Functions,
    /// What it says about itself.
    pub description: Description,
    /// fmuResourceLocation; empty for a bare library.
    pub resources: CString,
    _folder: Option<Folder>,
}

impl Fmu {
    /// Opens a `.fmu` file, or a library that hands out its own files through fmi2ExportFiles.
    pub fn open(path: &Path) -> Result<Self> {
        if path.extension().is_some_and(|e| e == "fmu") {
            Self::packed(path)
        } else {
            Self::library(path)
        }
        .with_context(|| path.display().to_string())
    }

    /// The variable with this value reference, which FMUs made with fmu-export give only once, whatever its type.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        let mut variables = self.description.variables.iter();
        variables.find(|v| v.reference == reference)
    }

    fn packed(path: &Path) -> Result<Self> {
        let folder = Folder::new(path)?;
        zip::ZipArchive::new(File::open(path)?)?.extract(&folder.0)?;
        let description = fs::read_to_string(folder.0.join("modelDescription.xml"))?;
        let description = Description::parse(&description)?;
        let platform = platform::host()?;
        let name = format!("{}{}", description.identifier, platform.suffix);
        let library = folder.0.join("binaries").join(platform.folder).join(name);
        let resources = format!("file://{}/resources", folder.0.display());
        Ok(Self {
            functions: Functions::load(load(&library)?)?,
            description,
            resources: CString::new(resources)?,
            _folder: Some(folder),
        })
    }

    fn library(path: &Path) -> Result<Self> {
        Ok(Self {
            description: library::description(&library::files(path)?)?,
            functions: Functions::load(load(path)?)?,
            resources: CString::default(),
            _folder: None,
        })
    }
}

fn load(path: &Path) -> Result<Library> {
    // SAFETY: the FMU under test; loading it runs no code of its own.
    unsafe { Library::new(path) }.with_context(|| path.display().to_string())
}

/// A temporary folder, deleted with this value.
struct Folder(PathBuf);

impl Folder {
    fn new(fmu: &Path) -> Result<Self> {
        let stem = fmu.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("torture-{}-{stem}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        fs::create_dir_all(&folder)?;
        Ok(Self(folder))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0); // a leftover in the temporary folder does no harm
    }
}
