//! The shared library of an FMU that was unpacked for it.
#![allow(unsafe_code)]

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, anyhow};
use fmi_description::{Archive, Description, Remark, platform};
use fmi_import::calls::Exports;
use fmi_import::library::{self, resources};
use tempfile::{Builder, TempDir, TempPath};

use crate::io::output;

/// A library. What was unpacked is removed after it was closed.
pub struct Library {
    own: library::Library,
    _copy: Option<TempPath>,
    unpacked: Unpacked,
}

/// The folder of an unpacked FMU, and its library there.
#[derive(Clone)]
pub struct Unpacked {
    folder: Arc<TempDir>,
    library: PathBuf,
}

impl Library {
    /// Unpack the FMU `file` and load its library; where its resources are, as the version wants it:
    /// a URI or a path; what is odd about the library.
    ///
    /// # Errors
    /// It is not for this platform, or what the system says of it.
    pub fn load(
        file: &str,
        archive: &mut Archive,
        description: &Description,
    ) -> Result<(Self, String, Option<Remark>)> {
        let host = platform::host().context("FMUs have no folder for a platform like this one")?;
        let (library, remark) = archive.library(description, host)?;
        let folder = TempDir::with_prefix("cosim-")?;
        archive.unpack(folder.path())?;
        let path = folder.path().join(&library);
        let who = format!("FMU `{file}`");
        let opened = output::named(&who, || library::Library::open(&path));
        let own = opened.map_err(|error| {
            let remedy = remedy(&error.to_string());
            anyhow!("its library cannot be loaded: {error}{remedy}")
        })?;
        let resources = resources(folder.path(), description.fmi);
        let unpacked = Unpacked {
            folder: Arc::new(folder),
            library: path,
        };
        let loaded = Self {
            own,
            _copy: None,
            unpacked,
        };
        Ok((loaded, resources, remark))
    }

    /// Where it is.
    pub fn unpacked(&self) -> Unpacked {
        self.unpacked.clone()
    }
}

impl Unpacked {
    /// A copy of the library beside it, with global variables of its own.
    ///
    /// # Errors
    /// What the system says.
    pub fn copy(&self) -> Result<Library> {
        let name = self.library.file_name().unwrap_or_default();
        let beside = self.library.parent().unwrap_or(self.folder.path());
        let copy = Builder::new().suffix(name).tempfile_in(beside)?;
        let copy = copy.into_temp_path();
        fs::copy(&self.library, &copy)?;
        let own = library::Library::open(&copy)?;
        Ok(Library {
            own,
            _copy: Some(copy),
            unpacked: self.clone(),
        })
    }
}

impl Exports for Library {
    unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        // SAFETY: as the caller promises.
        unsafe { self.own.function(name) }
    }
}

/// What helps where the functions of Python are missing, as pythonfmu leaves them out of its
/// libraries.
fn remedy(error: &str) -> &'static str {
    match error.contains("undefined symbol: Py") || error.contains("undefined symbol: _Py") {
        true => {
            "; it runs in Python, whose library must be in this program: start it with \
             LD_PRELOAD=…/libpython3.X.so (docs/master/cosim-tutorial.md, FMUs of pythonfmu)"
        }
        false => "",
    }
}
