//! An FMU opened: unpacked if it is packed, its description read, its library loaded.

use super::functions::Functions;
use crate::{library, platform};
use anyhow::{Context, Result};
use fmu_description::{Description, Variable, Version};
use libloading::Library;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use std::ffi::CString;
use std::fs::{self, File};
use std::path::{MAIN_SEPARATOR, Path};
use tempfile::TempDir;

/// What a path inside a URI need not encode.
const PLAIN: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'/')
    .remove(b':')
    .remove(b'-')
    .remove(b'.')
    .remove(b'_')
    .remove(b'~');

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
    /// Opens a `.fmu` file, or a library that hands out its own files through fmi2ExportFiles.
    pub fn open(path: &Path) -> Result<Self> {
        if path.extension().is_some_and(|e| e == "fmu") {
            Self::packed(path)
        } else {
            Self::library(path)
        }
        .with_context(|| path.display().to_string())
    }

    /// Opens an FMU whose files lie in a folder.
    pub fn unpacked(folder: &Path) -> Result<Self> {
        let description = fs::read_to_string(folder.join("modelDescription.xml"))?;
        let description = Description::parse(&description)?;
        let library = folder.join(library_path(&description)?);
        let resources = folder.join("resources");
        let resources = match description.fmi {
            Version::Fmi2 => uri(&resources),
            Version::Fmi3 => format!("{}{MAIN_SEPARATOR}", resources.display()),
        };
        Ok(Self {
            functions: Functions::load(load(&library)?, &description)?,
            description,
            resources: CString::new(resources)?,
            _folder: None,
        })
    }

    /// The variable with this value reference, which FMUs made with fmu-export give only once, whatever its type; of aliases the first.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        let mut variables = self.description.variables.iter();
        variables.find(|v| v.reference == reference)
    }

    fn packed(path: &Path) -> Result<Self> {
        let folder = TempDir::with_prefix("cargo-fmu-")?;
        zip::ZipArchive::new(File::open(path)?)?.extract(folder.path())?;
        let mut fmu = Self::unpacked(folder.path())?;
        fmu._folder = Some(folder);
        Ok(fmu)
    }

    fn library(path: &Path) -> Result<Self> {
        let description = library::description(&library::files(path)?)?;
        Ok(Self {
            functions: Functions::load(load(path)?, &description)?,
            description,
            resources: CString::default(),
            _folder: None,
        })
    }
}

/// Where the library for this machine lies.
pub fn library_path(description: &Description) -> Result<String> {
    let platform = platform::host()?;
    match description.fmi {
        Version::Fmi2 => platform.path(&description.identifier),
        Version::Fmi3 => Ok(platform.path_3(&description.identifier)),
    }
}

/// A path as a URI (RFC 8089): `file:///home/me/fmu`, `file:///C:/fmu`.
fn uri(path: &Path) -> String {
    let path = path.to_string_lossy().replace('\\', "/");
    let path = path.trim_start_matches("//?/").trim_start_matches('/');
    format!("file:///{}", utf8_percent_encode(path, PLAIN))
}

fn load(path: &Path) -> Result<Library> {
    // SAFETY: the FMU under test; loading it runs no code of its own.
    unsafe { Library::new(path) }.context("the library cannot be loaded")
}

#[cfg(test)]
mod tests {
    use super::uri;
    use std::path::Path;

    #[test]
    fn paths_become_uris() {
        assert_eq!(uri(Path::new("/a b/ü.x")), "file:///a%20b/%C3%BC.x");
        assert_eq!(uri(Path::new(r"C:\a\b")), "file:///C:/a/b");
        assert_eq!(uri(Path::new(r"\\?\C:\a")), "file:///C:/a");
    }
}
