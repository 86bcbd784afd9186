//! Loads an FMU's shared library and those in its folder that it needs, for `fmu` and `exported`.
use std::ffi::CString;
use std::fs;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::sync::Arc;

use anyhow::{Result, anyhow};
use fmi_description::{Archive, Version};
use libloading::Error;
use output_file::TemporaryFolder;
use tempfile::{Builder, TempPath};

use crate::calls::Exports;
use crate::output;
use crate::under_way::{About, Slot};

static LOADING: About = About::rare("loading the library");
static UNLOADING: About = About::rare("unloading the library");

/// A loaded library. Fields are dropped in their order, after the libraries were closed: its files
/// are removed last.
pub struct Library {
    /// The library, and then those that were loaded for it, to be closed in this order.
    all: Vec<libloading::Library>,
    /// Name for messages.
    name: CString,
    _copy: Option<TempPath>,
    _folder: Option<Arc<TemporaryFolder>>,
}

/// An FMU that is unpacked to a temporary folder, and the path of its library there.
#[derive(Clone)]
pub(crate) struct Unpacked {
    folder: Arc<TemporaryFolder>,
    library: String,
}

impl Unpacked {
    /// Unpacks an archive, in which `library` is the path of the library for this platform.
    pub fn new(archive: &mut Archive, library: String) -> Result<Self> {
        let folder = Arc::new(TemporaryFolder::new()?);
        archive.unpack(folder.path())?;
        Ok(Self { folder, library })
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Path of the library.
    pub fn path(&self) -> PathBuf {
        self.folder().join(&self.library)
    }

    /// Loads the library. What it prints meanwhile is printed with the name `who`.
    pub fn load(&self, who: &str) -> Result<Library> {
        let mut opened = load_named(who, &self.path())?;
        opened._folder = Some(self.folder.clone());
        Ok(opened)
    }

    /// Loads a copy of the library from the same folder, which has its own global variables.
    pub fn copy(&self) -> Result<Library> {
        let library = self.path();
        let name = library.file_name().unwrap_or_default();
        let folder = library.parent().unwrap_or(self.folder());
        let copy = Builder::new().suffix(name).tempfile_in(folder)?;
        let copy = copy.into_temp_path();
        fs::copy(&library, &copy)?;
        let mut opened = Library::open(&copy)?;
        (opened._copy, opened._folder) = (Some(copy), Some(self.folder.clone()));
        Ok(opened)
    }
}

/// Loads a library, with a name for messages. What it prints meanwhile is printed with this name.
pub(crate) fn load_named(who: &str, path: &Path) -> Result<Library> {
    let opened = output::named(who, || Library::open_as(who, path));
    opened.map_err(|error| {
        let remedy = remedy(&error.to_string());
        anyhow!("its library cannot be loaded: {error}{remedy}")
    })
}

/// What to do if functions of Python are missing: libraries of pythonfmu expect them in the
/// program.
fn remedy(error: &str) -> &'static str {
    match error.contains("undefined symbol: Py") || error.contains("undefined symbol: _Py") {
        true => {
            "; it runs in Python, whose library must be in this program: start it with \
             LD_PRELOAD=…/libpython3.X.so (docs/master/cosim-tutorial.md, FMUs of pythonfmu)"
        }
        false => "",
    }
}

/// Paths of the files in the platform folders of an unpacked FMU.
pub(crate) fn binaries(folder: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for platform in fs::read_dir(folder.join("binaries"))?.flatten() {
        let files = fs::read_dir(platform.path()).into_iter().flatten();
        for file in files.flatten() {
            let [platform, file] = [platform.file_name(), file.file_name()];
            let [platform, file] = [platform.to_string_lossy(), file.to_string_lossy()];
            names.push(format!("binaries/{platform}/{file}"));
        }
    }
    Ok(names)
}

impl Library {
    /// Loads a library of an unpacked FMU, if necessary after others in its folder that it needs.
    ///
    /// # Errors
    /// The error of the system at the first attempt.
    pub fn open(file: &Path) -> std::result::Result<Self, Error> {
        let name = file.file_name().unwrap_or_default();
        Self::open_as(&format!("`{}`", name.display()), file)
    }

    /// The same with a name for messages.
    fn open_as(name: &str, file: &Path) -> std::result::Result<Self, Error> {
        let name = CString::new(name).unwrap_or_default();
        let call = Slot::fresh().call_of(&name, &LOADING);
        let opened = Self::open_all(file);
        drop(call);
        Ok(Self {
            all: opened?,
            name,
            _copy: None,
            _folder: None,
        })
    }

    fn open_all(file: &Path) -> std::result::Result<Vec<libloading::Library>, Error> {
        let mut all = Vec::new();
        let first = match open(file) {
            Err(error) => error,
            Ok(own) => return Ok(vec![own]),
        };
        let neighbours = fs::read_dir(file.parent().unwrap_or(Path::new(".")));
        let neighbours = neighbours.into_iter().flatten().flatten();
        let mut waiting: Vec<PathBuf> = neighbours.map(|entry| entry.path()).collect();
        waiting.retain(|path| path != file && is_library(path));
        // A neighbour may need another one: repeat as long as one more could be loaded.
        loop {
            let before = waiting.len();
            waiting.retain(|path| open(path).map(|library| all.push(library)).is_err());
            if waiting.is_empty() || waiting.len() == before {
                break;
            }
        }
        match open(file) {
            Ok(own) => {
                all.insert(0, own);
                Ok(all)
            }
            Err(_) => Err(first),
        }
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        let _call = Slot::fresh().call_of(&self.name, &UNLOADING);
        self.all.clear();
    }
}

impl Exports for Library {
    unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        // SAFETY: as the caller promises.
        unsafe { self.all[0].get(name.as_bytes()) }.ok().map(|f| *f)
    }
}

/// `libx.so`, `x.so.3`, `x.dll`, `x.dylib`.
fn is_library(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let suffix = std::env::consts::DLL_SUFFIX;
    name.ends_with(suffix) || name.contains(&format!("{suffix}."))
}

#[cfg(not(windows))]
fn open(file: &Path) -> std::result::Result<libloading::Library, Error> {
    // SAFETY: the FMU's library or one that came with it, which the caller asked to run.
    unsafe { libloading::Library::new(file) }
}

/// With this flag Windows looks for further libraries in the folder of the file, not of the
/// program.
#[cfg(windows)]
fn open(file: &Path) -> std::result::Result<libloading::Library, Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
    // SAFETY: the FMU's library or one that came with it, which the caller asked to run.
    unsafe { Library::load_with_flags(file, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(Into::into)
}

/// The resources of an FMU in a folder, as its version of FMI passes them: as a URI, or as a path
/// with a separator at its end (FMI 3.0, section 2.3.1).
pub(crate) fn resources(folder: &Path, version: Version) -> String {
    let path = folder.join("resources");
    let path = std::path::absolute(&path).unwrap_or(path);
    match version {
        Version::Fmi2 => uri(&path.to_string_lossy()),
        Version::Fmi3 => format!("{}{MAIN_SEPARATOR}", path.display()),
    }
}

/// A path as a URI (RFC 8089): `file:///home/me/fmu`, `file:///C:/fmu`.
fn uri(path: &str) -> String {
    let path = path.replace('\\', "/");
    let path = path.trim_start_matches("//?/").trim_start_matches('/');
    let mut uri = String::from("file:///");
    for byte in path.bytes() {
        match byte {
            b'/' | b':' | b'-' | b'_' | b'.' | b'~' => uri.push(byte.into()),
            byte if byte.is_ascii_alphanumeric() => uri.push(byte.into()),
            byte => uri += &format!("%{byte:02X}"),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::uri;

    #[test]
    fn paths_become_uris() {
        assert_eq!(uri("/a b/ü.x"), "file:///a%20b/%C3%BC.x");
        assert_eq!(uri(r"C:\a\b"), "file:///C:/a/b");
        assert_eq!(uri(r"\\?\C:\a"), "file:///C:/a");
    }
}
