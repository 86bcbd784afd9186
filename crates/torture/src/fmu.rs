//! An FMU opened: unpacked if it is packed, its description read, its library loaded.

use crate::description::Description;
use crate::functions::Functions;
use anyhow::{Context, Result, bail};
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
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

    fn packed(path: &Path) -> Result<Self> {
        let folder = Folder::new(path)?;
        zip::ZipArchive::new(File::open(path)?)?.extract(&folder.0)?;
        let description = fs::read_to_string(folder.0.join("modelDescription.xml"))?;
        let description = Description::parse(&description)?;
        let platform = match std::env::consts::OS {
            "linux" => "linux64",
            "windows" => "win64",
            other => bail!("the driver does not run on {other}"),
        };
        let name = format!("{}{}", description.identifier, std::env::consts::DLL_SUFFIX);
        let library = folder.0.join("binaries").join(platform).join(name);
        let resources = format!("file://{}/resources", folder.0.display());
        Ok(Self {
            functions: Functions::load(load(&library)?)?,
            description,
            resources: CString::new(resources)?,
            _folder: Some(folder),
        })
    }

    fn library(path: &Path) -> Result<Self> {
        let library = load(path)?;
        let text = own_description(&library)?;
        Ok(Self {
            description: Description::parse(&text)?,
            functions: Functions::load(library)?,
            resources: CString::default(),
            _folder: None,
        })
    }
}

fn load(path: &Path) -> Result<Library> {
    // SAFETY: the FMU under test; loading it runs no code of its own.
    unsafe { Library::new(path) }.with_context(|| path.display().to_string())
}

type Receive = unsafe extern "C" fn(*mut c_void, *const c_char, *const u8, usize);

/// The model description that a library made with fmu-export carries.
fn own_description(library: &Library) -> Result<String> {
    unsafe extern "C" fn receive(to: *mut c_void, path: *const c_char, bytes: *const u8, n: usize) {
        // SAFETY: `to` is the text below; path is NULL or a C string, and `bytes` are `n` bytes.
        unsafe {
            if !path.is_null() && CStr::from_ptr(path) == c"modelDescription.xml" {
                let bytes = std::slice::from_raw_parts(bytes, n);
                *to.cast::<String>() = String::from_utf8_lossy(bytes).into_owned();
            }
        }
    }
    let mut text = String::new();
    // SAFETY: the symbol has this signature in fmu-export; the context is what `receive` expects.
    unsafe {
        let export = library.get::<unsafe extern "C" fn(*mut c_void, Option<Receive>) -> c_int>(
            b"fmi2ExportFiles\0",
        )?;
        export((&raw mut text).cast(), Some(receive));
    }
    Ok(text)
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
