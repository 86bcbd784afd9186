//! The shared library of an FMU, with the libraries beside it that it needs.
#![allow(unsafe_code)]

use std::path::{MAIN_SEPARATOR, Path};

use anyhow::{Context, Result, anyhow};
use fmu_description::{Archive, Description, Remark, Version, platform};
use tempfile::TempDir;

use crate::output;

/// A library, and those that were loaded for it. It is closed first, and what was unpacked is
/// removed last.
pub struct Library {
    own: libloading::Library,
    _others: Vec<libloading::Library>,
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
        let resources = std::path::absolute(folder.path().join("resources"))?;
        let library = output::named(&format!("FMU `{file}`"), || Self::open(folder, &library))?;
        let resources = match description.fmi {
            Version::Fmi2 => uri(&resources)?,
            Version::Fmi3 => {
                let path = resources.to_str().context("a path that is not UTF-8")?;
                // With a separator at its end (section 2.3.1).
                format!("{path}{MAIN_SEPARATOR}")
            }
        };
        Ok((library, resources, remark))
    }

    /// Load a library of an unpacked FMU. Where it needs others that lie beside it, these are loaded
    /// before.
    fn open(folder: TempDir, file: &str) -> Result<Self> {
        let file = &folder.path().join(file);
        let mut others = Vec::new();
        let first = match open(file) {
            Ok(own) => {
                return Ok(Self {
                    own,
                    _others: others,
                    _folder: folder,
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
                _folder: folder,
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

/// A folder as the URI that FMI 2.0 wants.
fn uri(folder: &Path) -> Result<String> {
    let path = folder.to_str().context("a path that is not UTF-8")?;
    let mut uri = String::from("file://");
    if !path.starts_with('/') {
        uri.push('/'); // file:///C:/…
    }
    for byte in path.bytes() {
        match byte {
            b'\\' if cfg!(windows) => uri.push('/'),
            b'/' | b':' | b'-' | b'_' | b'.' | b'~' => uri.push(byte.into()),
            byte if byte.is_ascii_alphanumeric() => uri.push(byte.into()),
            byte => uri += &format!("%{byte:02X}"),
        }
    }
    Ok(uri)
}
