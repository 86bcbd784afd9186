//! An unpacked FMU with its library loaded once, shared by all its instances.

use std::any::Any;
use std::io::{Cursor, Read};
use std::path::{MAIN_SEPARATOR, Path};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, anyhow, bail};
use fmi::fmi2::binding::Fmi2Binding;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi3::binding::Fmi3Binding;
use fmi::traits::FmiImport;
use fmu_description::{Description, Version};
use tempfile::TempDir;

use crate::batch::{Batch, Layout};

/// A loaded FMU. The library and the unpacked files live as long as any instance.
pub struct Fmu {
    /// Name for messages: the file it came from.
    pub file: String,
    /// What the model description says; arrays of FMI 3.0 by element, which is how a system structure names them.
    pub description: Description,
    /// Where the unpacked resources are, as the version wants it: a URI or a path.
    pub resources: String,
    pub(crate) api: Api,
    pub(crate) layout: Arc<Layout>,
    pub(crate) instances: AtomicUsize,
    /// The directory the FMU was unpacked to; removed when dropped, hence after `api`.
    _import: Box<dyn Any + Send + Sync>,
}

/// The functions of the library.
pub(crate) enum Api {
    Fmi2(Arc<Fmi2Binding>),
    Fmi3(Arc<Fmi3Binding>),
}

impl Fmu {
    /// Unpack and load an FMU from its bytes; `file` is its name for messages.
    pub fn load(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        Self::open(file, bytes).with_context(|| format!("FMU `{file}` cannot be loaded"))
    }

    fn open(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        // Read the description before the `fmi` crate does: its reader panics on XML that ends too early.
        let description = Description::parse(&description_text(&bytes)?)?.by_element();
        let identifier = &description.identifier;
        let (api, resources, import): (_, _, Box<dyn Any + Send + Sync>) = match description.fmi {
            Version::Fmi2 => {
                let (import, api) = unpack_2(bytes, identifier)?;
                require_functions_2(&api)?;
                let resources = import.canonical_resource_path_string();
                (Api::Fmi2(Arc::new(api)), resources, Box::new(import))
            }
            Version::Fmi3 => {
                let (folder, api) = unpack_3(bytes, identifier)?;
                require_functions_3(&api)?;
                let resources = std::path::absolute(folder.path().join("resources"))?;
                let resources = resources.to_str().context("a path that is not UTF-8")?;
                // With a separator at its end (section 2.3.1).
                let resources = format!("{resources}{MAIN_SEPARATOR}");
                (Api::Fmi3(Arc::new(api)), resources, Box::new(folder))
            }
        };
        Ok(Arc::new(Self {
            file: file.to_string(),
            resources,
            api,
            layout: Arc::new(Layout::new(&description)),
            description,
            instances: AtomicUsize::new(0),
            _import: import,
        }))
    }

    /// Variables that are read or written together, by index; all must be of one type that is a number or a truth value.
    pub fn batch(&self, variables: Vec<usize>) -> Result<Batch> {
        let of = |k: &usize| &self.description.variables[*k];
        if let Some(v) = variables.iter().map(of).find(|v| !v.access().is_number()) {
            bail!("{} of FMU `{}` is not a number", v.name, self.file);
        }
        Ok(Batch::new(&self.description, &self.layout, variables))
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

/// Unpack an FMU of FMI 2.0 and load the library for this platform.
fn unpack_2(bytes: Vec<u8>, identifier: &str) -> Result<(Fmi2Import, Fmi2Binding)> {
    let import: Fmi2Import = fmi::import::new(Cursor::new(bytes))?;
    check_library(import.archive_path(), &import.shared_lib_path(identifier)?)?;
    let api = import.binding(identifier)?;
    Ok((import, api))
}

/// The same of FMI 3.0. The `fmi` crate binds the library; its reader of descriptions, which its import asks for, refuses the base unit
/// ampere.
fn unpack_3(bytes: Vec<u8>, identifier: &str) -> Result<(TempDir, Fmi3Binding)> {
    let folder = TempDir::with_prefix("cosim-")?;
    zip::ZipArchive::new(Cursor::new(bytes))?.extract(folder.path())?;
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    let platform = format!("{}-{system}", std::env::consts::ARCH);
    let name = format!("{identifier}{}", std::env::consts::DLL_SUFFIX);
    let library = Path::new("binaries").join(platform).join(name);
    check_library(folder.path(), &library)?;
    let library = folder.path().join(library);
    Ok((folder, load_3(&library)?))
}

#[expect(unsafe_code, reason = "loads a library")]
fn load_3(library: &Path) -> Result<Fmi3Binding> {
    // SAFETY: the FMU's library, which the caller asked to run; loading it runs no code of its own.
    Ok(unsafe { Fmi3Binding::new(library) }?)
}

fn check_library(folder: &Path, library: &Path) -> Result<()> {
    if !folder.join(library).is_file() {
        let platform = library.display();
        bail!("it holds no {platform}, the library for this platform");
    }
    Ok(())
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

macro_rules! require {
    ($api:expr, $($name:ident)*) => {
        $( if $api.$name.is_err() { bail!("its library does not export {}", stringify!($name)); } )*
    };
}

/// The binding panics when a missing function is called; ask for all that the master uses when the library is loaded.
fn require_functions_2(api: &Fmi2Binding) -> Result<()> {
    require! {
        api, fmi2GetVersion fmi2GetTypesPlatform fmi2Instantiate fmi2FreeInstance fmi2SetDebugLogging fmi2SetupExperiment
        fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate fmi2GetReal fmi2SetReal fmi2GetInteger fmi2SetInteger
        fmi2GetBoolean fmi2SetBoolean fmi2SetString fmi2DoStep fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives fmi2GetRealStatus
    }
    Ok(())
}

/// The same for FMI 3.0.
fn require_functions_3(api: &Fmi3Binding) -> Result<()> {
    require! {
        api, fmi3GetVersion fmi3InstantiateCoSimulation fmi3FreeInstance fmi3SetDebugLogging fmi3EnterInitializationMode
        fmi3ExitInitializationMode fmi3EnterEventMode fmi3UpdateDiscreteStates fmi3EnterStepMode fmi3Terminate fmi3DoStep
        fmi3GetOutputDerivatives fmi3GetFloat32 fmi3GetFloat64 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32
        fmi3GetUInt32 fmi3GetInt64 fmi3GetUInt64 fmi3GetBoolean fmi3SetFloat32 fmi3SetFloat64 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16
        fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64 fmi3SetUInt64 fmi3SetBoolean fmi3SetString
    }
    Ok(())
}
