//! An FMU with its library loaded once, shared by all its instances.

use std::ffi::CString;
use std::sync::Arc;
#[cfg(feature = "native")]
use std::{fs, path::Path};

#[cfg(feature = "native")]
use anyhow::Context;
use anyhow::Result;
#[cfg(feature = "native")]
use fmi_description::library_among;
use fmi_description::{Access, Archive, Description, Variable};

use crate::functions::Functions;
#[cfg(feature = "native")]
use crate::library::{Library, Unpacked, resources};

/// A loaded FMU. The library, and the files that were unpacked for it, live as long as any
/// instance.
pub struct Fmu {
    /// The C functions.
    pub functions: Arc<Functions>,
    /// What it says about itself.
    pub description: Description,
    /// fmuResourceLocation or resourcePath; empty for a bare library.
    pub resources: CString,
    /// The folder that it was unpacked to for this.
    #[cfg(feature = "native")]
    pub(crate) unpacked: Option<Unpacked>,
}

impl Fmu {
    /// Opens a `.fmu` file, or a library made with fmu-export that hands out its own files.
    #[cfg(feature = "native")]
    pub fn open(path: &Path) -> Result<Self> {
        if path.extension().is_none_or(|e| e != "fmu") {
            return Self::bare(path, crate::exported::description(path)?);
        }
        let open = || {
            let unpacked = Unpacked::new(&mut Archive::open(fs::read(path)?)?, String::new())?;
            let mut fmu = Self::unpacked(unpacked.folder())?;
            fmu.unpacked = Some(unpacked);
            anyhow::Ok(fmu)
        };
        open().with_context(|| path.display().to_string())
    }

    /// Opens an FMU whose files lie in a folder.
    #[cfg(feature = "native")]
    pub fn unpacked(folder: &Path) -> Result<Self> {
        let description = Description::read(&fs::read(folder.join("modelDescription.xml"))?)?;
        let names = crate::library::binaries(folder)?;
        let names = names.iter().map(String::as_str);
        let (library, _) = library_among(names, &description, crate::platform::host()?)?;
        let resources = CString::new(resources(folder, description.fmi))?;
        Ok(Self {
            resources,
            ..Self::bare(&folder.join(library), description)?
        })
    }

    /// A library by itself, of which this is known.
    #[cfg(feature = "native")]
    pub fn bare(path: &Path, description: Description) -> Result<Self> {
        let library = Library::open(path).context("the library cannot be loaded")?;
        Ok(Self {
            functions: Functions::load(library, &description),
            description,
            resources: CString::default(),
            unpacked: None,
        })
    }

    /// Opens the archive of the FMU `file`; what is odd about its library, but does no harm.
    ///
    /// # Errors
    /// What is wrong with the archive, the description or the library, or what the system says.
    #[cfg(feature = "native")]
    pub fn from_archive(
        file: &str,
        archive: &mut Archive,
        description: Description,
    ) -> Result<(Self, Option<fmi_description::Remark>)> {
        let host = fmi_description::platform::host();
        let host = host.context("FMUs have no folder for a platform like this one")?;
        let (path, remark) = archive.library(&description, host)?;
        let unpacked = Unpacked::new(archive, path)?;
        let library = unpacked.load(&format!("FMU `{file}`"))?;
        let fmu = Self {
            functions: Functions::load(library, &description),
            resources: CString::new(resources(unpacked.folder(), description.fmi))?,
            description,
            unpacked: Some(unpacked),
        };
        Ok((fmu, remark))
    }

    /// The functions of a copy of its library: global variables are not shared.
    ///
    /// # Errors
    /// It was not opened from an archive, or what the system says.
    #[cfg(feature = "native")]
    pub fn copied(&self) -> Result<Arc<Functions>> {
        let unpacked = self.unpacked.as_ref().context("it was not unpacked here")?;
        Ok(Functions::load(unpacked.copy()?, &self.description))
    }

    /// Has the host of WebAssembly compile the module of the FMU `file`.
    ///
    /// # Errors
    /// The FMU has no module, or what the host says of it.
    #[cfg(not(feature = "native"))]
    pub fn from_archive(
        file: &str,
        archive: &mut Archive,
        description: Description,
    ) -> Result<(Self, Option<fmi_description::Remark>)> {
        let (library, resources) = crate::module::Library::load(file, archive, &description)?;
        let fmu = Self {
            functions: Functions::load(library, &description),
            resources: CString::new(resources)?,
            description,
        };
        Ok((fmu, None))
    }

    /// The variable with this value reference, which FMUs made with fmu-export give only once,
    /// whatever its type; of aliases the first.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        let mut variables = self.description.variables.iter();
        variables.find(|v| v.reference == reference)
    }

    /// The types that it has variables of.
    pub fn accesses(&self) -> std::collections::BTreeSet<Access> {
        self.description
            .variables
            .iter()
            .map(Variable::access)
            .collect()
    }
}
