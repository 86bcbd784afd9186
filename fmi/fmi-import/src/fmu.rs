//! [`Fmu`]: an FMU whose library is loaded once for all instances, for master, check and `torture`.

use std::ffi::CString;
use std::sync::Arc;
#[cfg(feature = "native")]
use std::{fs, path::Path};

#[cfg(feature = "native")]
use anyhow::Context;
use anyhow::Result;
use fmi_description::{Access, Archive, Description, Variable};
#[cfg(feature = "native")]
use fmi_description::{Version, library_among};

#[cfg(feature = "native")]
use crate::exported::exported_files;
use crate::functions::Functions;
#[cfg(feature = "native")]
use crate::library::{Library, Unpacked, resources};

/// A library that is loaded in other processes only: it exports nothing here.
#[cfg(feature = "native")]
struct NotLoaded;

#[cfg(feature = "native")]
impl crate::calls::Exports for NotLoaded {
    unsafe fn function<F: Copy>(&self, _: &str) -> Option<F> {
        None
    }
}

/// A loaded FMU. The library and the files that were unpacked for it stay as long as any instance.
pub struct Fmu {
    /// The C functions.
    pub functions: Arc<Functions>,
    /// Its model description.
    pub description: Description,
    /// fmuResourceLocation or resourcePath; empty for a library without an archive.
    pub resources: CString,
    #[cfg(feature = "native")]
    pub(crate) unpacked: Option<Unpacked>,
}

impl Fmu {
    /// Opens a `.fmu` file, or a library made with fmu-export that hands out its own files.
    #[cfg(feature = "native")]
    pub fn open(path: &Path) -> Result<Self> {
        if path.extension().is_none_or(|e| e != "fmu") {
            let files = exported_files(path, Version::Fmi2)?;
            let text = files.get("modelDescription.xml");
            let text = text.context("the library carries no modelDescription.xml")?;
            return Self::from_library(path, Description::read(text)?);
        }
        let open = || {
            let unpacked = Unpacked::new(&mut Archive::open(fs::read(path)?)?, String::new())?;
            let mut fmu = Self::from_folder(unpacked.folder())?;
            fmu.unpacked = Some(unpacked);
            anyhow::Ok(fmu)
        };
        open().with_context(|| path.display().to_string())
    }

    /// Opens an FMU whose files are in a folder, also one without Co-Simulation.
    #[cfg(feature = "native")]
    pub fn from_folder(folder: &Path) -> Result<Self> {
        let bytes = fs::read(folder.join("modelDescription.xml"))?;
        let description = Description::parse_any(&fmi_description::text(&bytes)?)?;
        let names = crate::library::binaries(folder)?;
        let names = names.iter().map(String::as_str);
        let (library, _) = library_among(names, &description, crate::platform::host()?)?;
        let resources = CString::new(resources(folder, description.fmi))?;
        Ok(Self {
            resources,
            ..Self::from_library(&folder.join(library), description)?
        })
    }

    /// Opens a library without an archive, which has this description.
    #[cfg(feature = "native")]
    pub(crate) fn from_library(path: &Path, description: Description) -> Result<Self> {
        let library = Library::open(path).context("the library cannot be loaded")?;
        Ok(Self {
            functions: Functions::load(library, &description),
            description,
            resources: CString::default(),
            unpacked: None,
        })
    }

    /// Opens the archive of the FMU `file`; returns a remark if its library has an unexpected name.
    /// If it is `isolated`, the library is not loaded here.
    ///
    /// # Errors
    /// The archive has no library for this platform, or it cannot be unpacked or loaded.
    #[cfg(feature = "native")]
    pub fn from_archive(
        file: &str,
        archive: &mut Archive,
        description: Description,
        isolated: bool,
    ) -> Result<(Self, Option<fmi_description::Remark>)> {
        let host = fmi_description::platform::host();
        let host = host.context("FMUs have no folder for a platform like this one")?;
        let (path, remark) = archive.library(&description, host)?;
        let unpacked = Unpacked::new(archive, path)?;
        let functions = match isolated {
            true => Functions::load(NotLoaded, &description),
            false => Functions::load(unpacked.load(&format!("FMU `{file}`"))?, &description),
        };
        let fmu = Self {
            functions,
            resources: CString::new(resources(unpacked.folder(), description.fmi))?,
            description,
            unpacked: Some(unpacked),
        };
        Ok((fmu, remark))
    }

    /// Loads a copy of the library, whose global variables are not shared.
    ///
    /// # Errors
    /// The FMU was not opened from an archive, or the copy cannot be written or loaded.
    #[cfg(feature = "native")]
    pub fn load_copy(&self) -> Result<Arc<Functions>> {
        let unpacked = self.unpacked.as_ref().context("it was not unpacked here")?;
        Ok(Functions::load(unpacked.copy()?, &self.description))
    }

    /// Lets the host of WebAssembly compile the module of the FMU `file`.
    ///
    /// # Errors
    /// The FMU has no module, or the host cannot compile it.
    #[cfg(not(feature = "native"))]
    pub fn from_archive(
        file: &str,
        archive: &mut Archive,
        description: Description,
        _isolated: bool,
    ) -> Result<(Self, Option<fmi_description::Remark>)> {
        let (library, resources) = crate::module::Library::load(file, archive, &description)?;
        let fmu = Self {
            functions: Functions::load(library, &description),
            resources: CString::new(resources)?,
            description,
        };
        Ok((fmu, None))
    }

    /// The first variable with this value reference, of whatever type.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        let mut variables = self.description.variables.iter();
        variables.find(|v| v.reference == reference)
    }

    /// The types of its variables.
    pub fn accesses(&self) -> std::collections::BTreeSet<Access> {
        let variables = self.description.variables.iter();
        variables.map(Variable::access).collect()
    }
}
