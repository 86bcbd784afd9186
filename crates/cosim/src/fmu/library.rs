//! A loaded shared library, with the libraries beside it that it needs.
#![allow(unsafe_code)]

use std::path::Path;

use anyhow::{Result, anyhow};

/// A library, and those that were loaded for it. It is closed first.
pub struct Library {
    own: libloading::Library,
    _others: Vec<libloading::Library>,
}

impl Library {
    /// Load a library. Where it needs others that lie beside it, these are loaded before.
    ///
    /// # Errors
    /// What the system says of it.
    pub fn load(file: &Path) -> Result<Self> {
        let mut others = Vec::new();
        let first = match open(file) {
            Ok(own) => {
                return Ok(Self {
                    own,
                    _others: others,
                });
            }
            Err(error) => error,
        };
        let mut waiting: Vec<_> = std::fs::read_dir(file.parent().unwrap_or(Path::new(".")))?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path != file && is_library(path))
            .collect();
        // Each may need another one: once more while one was loaded.
        loop {
            let before = waiting.len();
            waiting.retain(|path| open(path).map(|library| others.push(library)).is_err());
            if waiting.is_empty() || waiting.len() == before {
                break;
            }
        }
        match open(file) {
            Ok(own) => Ok(Self {
                own,
                _others: others,
            }),
            Err(_) => Err(anyhow!(
                "its library cannot be loaded: {first}{}",
                remedy(&first.to_string())
            )),
        }
    }

    /// The exported function `name`.
    ///
    /// # Safety
    /// `F` is the type of a pointer to that function.
    pub unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        // SAFETY: as the caller promises.
        unsafe { self.own.get(name.as_bytes()) }.ok().map(|f| *f)
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

/// `libx.so`, `x.so.3`, `x.dll`, `x.dylib`.
fn is_library(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let suffix = std::env::consts::DLL_SUFFIX;
    name.ends_with(suffix) || name.contains(&format!("{suffix}."))
}

#[cfg(not(windows))]
fn open(file: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: the FMU's library or one that came with it, which the caller asked to run.
    unsafe { libloading::Library::new(file) }
}

/// Windows looks for further libraries in the folder of the file, not of the program, where it is
/// asked to.
#[cfg(windows)]
fn open(file: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
    // SAFETY: the FMU's library or one that came with it, which the caller asked to run.
    unsafe { Library::load_with_flags(file, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(Into::into)
}
