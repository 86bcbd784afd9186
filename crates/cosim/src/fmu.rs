//! An unpacked FMU with its library loaded once, shared by all its instances.

use std::io::{Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, anyhow, bail};
use fmi::fmi2::binding::Fmi2Binding;
use fmi::fmi2::import::Fmi2Import;
use fmi::traits::FmiImport;
use fmu_description::{Description, Version};

/// A loaded FMU. The library and the unpacked files live as long as any instance.
pub struct Fmu {
    /// Name for messages: the file it came from.
    pub file: String,
    /// What the model description says.
    pub description: Description,
    /// URI of the unpacked resources.
    pub resources: String,
    pub(crate) api: Fmi2Binding,
    pub(crate) instances: AtomicUsize,
    /// The directory the FMU was unpacked to; removed when dropped, hence after `api`.
    _import: Fmi2Import,
}

impl Fmu {
    /// Unpack and load an FMU from its bytes; `file` is its name for messages.
    pub fn load(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        Self::open(file, bytes).with_context(|| format!("FMU `{file}` cannot be loaded"))
    }

    fn open(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        // Read the description before the `fmi` crate does: its reader panics on XML that ends too early.
        let description = Description::parse(&description_text(&bytes)?)?;
        if description.fmi != Version::Fmi2 {
            bail!("it is of FMI {}, not 2.0", description.fmi);
        }
        let import: Fmi2Import = fmi::import::new(Cursor::new(bytes))?;
        let library = import
            .archive_path()
            .join(import.shared_lib_path(&description.identifier)?);
        if !library.is_file() {
            let platform = library
                .strip_prefix(import.archive_path())
                .unwrap_or(&library)
                .display();
            bail!("it holds no {platform}, the library for this platform");
        }
        let api = import.binding(&description.identifier)?;
        require_functions(&api)?;
        Ok(Arc::new(Self {
            file: file.to_string(),
            resources: import.canonical_resource_path_string(),
            description,
            api,
            instances: AtomicUsize::new(0),
            _import: import,
        }))
    }

    /// Count one more instance, or refuse where the FMU allows only one per process.
    pub(crate) fn register(&self, name: &str) -> Result<()> {
        if self.instances.fetch_add(1, Ordering::SeqCst) > 0
            && self.description.capabilities.only_once
        {
            self.instances.fetch_sub(1, Ordering::SeqCst);
            bail!(
                "{name}: FMU `{}` allows only one instance per process",
                self.file
            );
        }
        Ok(())
    }
}

fn description_text(bytes: &[u8]) -> Result<String> {
    let mut archive =
        zip::ZipArchive::new(Cursor::new(bytes)).context("it is not a ZIP archive")?;
    let mut entry = archive
        .by_name("modelDescription.xml")
        .map_err(|_| anyhow!("it holds no modelDescription.xml"))?;
    let mut text = String::new();
    entry
        .read_to_string(&mut text)
        .context("modelDescription.xml is not UTF-8 text")?;
    Ok(text)
}

/// The binding panics when a missing function is called; ask for all that the master uses when the library is loaded.
fn require_functions(api: &Fmi2Binding) -> Result<()> {
    macro_rules! require {
        ($($name:ident)*) => { $( if api.$name.is_err() { bail!("its library does not export {}", stringify!($name)); } )* };
    }
    require! {
        fmi2GetVersion fmi2GetTypesPlatform fmi2Instantiate fmi2FreeInstance fmi2SetDebugLogging fmi2SetupExperiment
        fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate fmi2GetReal fmi2SetReal fmi2GetInteger fmi2SetInteger
        fmi2GetBoolean fmi2SetBoolean fmi2SetString fmi2DoStep fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives
    }
    Ok(())
}
