//! The shared library of an FMU that was unpacked for it.
#![allow(unsafe_code)]

use anyhow::{Context, Result, anyhow};
use fmu_description::calls::Exports;
use fmu_description::library::{self, resources};
use fmu_description::{Archive, Description, Remark, platform};
use tempfile::TempDir;

use crate::output;

/// A library. What was unpacked is removed after it was closed.
pub struct Library {
    own: library::Library,
    _folder: TempDir,
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
        let failed = |error: &str| {
            let remedy = remedy(error);
            anyhow!("its library cannot be loaded: {error}{remedy}")
        };
        let own = output::named(&format!("FMU `{file}`"), || {
            library::Library::open(&path).map_err(|error| failed(&error.to_string()))
        })?;
        let resources = resources(folder.path(), description.fmi);
        let _folder = folder;
        Ok((Self { own, _folder }, resources, remark))
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
             LD_PRELOAD=…/libpython3.X.so (docs/cosim.md, FMUs of pythonfmu)"
        }
        false => "",
    }
}
