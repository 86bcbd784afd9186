//! An unpacked FMU with its library loaded once, shared by all its instances.

pub(crate) mod functions;
mod library;

use std::io::{Cursor, Read};
use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, anyhow, bail, ensure};
use fmu_description::{Description, Version};
use tempfile::TempDir;
use zip::ZipArchive;

use crate::batch::{Batch, Layout};
use functions::{Functions2, Functions3};
use library::Library;

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
    /// What is odd about the archive or its description, but does no harm.
    pub remarks: Vec<String>,
    /// Where the FMU was unpacked to; removed when dropped, hence after `api`.
    _folder: TempDir,
}

/// The functions of the library.
pub(crate) enum Api {
    Fmi2(Arc<Functions2>),
    Fmi3(Arc<Functions3>),
}

impl Fmu {
    /// Unpack and load an FMU from its bytes; `file` is its name for messages.
    pub fn load(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        Self::open(file, bytes).with_context(|| format!("FMU `{file}` cannot be loaded"))
    }

    fn open(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        let mut archive = ZipArchive::new(Cursor::new(bytes)).context("it is not a ZIP archive")?;
        let description = Description::parse(&description_text(&mut archive)?)?.by_element();
        let folder = TempDir::with_prefix("cosim-")?;
        unpack(&mut archive, folder.path())?;
        let mut remarks = Vec::new();
        let identifier = &description.identifier;
        let library = library(folder.path(), description.fmi, identifier, &mut remarks)?;
        let library = Library::load(&library)?;
        let resources = std::path::absolute(folder.path().join("resources"))?;
        let (api, resources) = match description.fmi {
            Version::Fmi2 => (
                Api::Fmi2(Arc::new(Functions2::of(library))),
                uri(&resources)?,
            ),
            Version::Fmi3 => {
                let path = resources.to_str().context("a path that is not UTF-8")?;
                // With a separator at its end (section 2.3.1).
                let path = format!("{path}{MAIN_SEPARATOR}");
                (Api::Fmi3(Arc::new(Functions3::of(library))), path)
            }
        };
        Ok(Arc::new(Self {
            file: file.to_string(),
            resources,
            api,
            layout: Arc::new(Layout::new(&description)),
            description,
            instances: AtomicUsize::new(0),
            remarks,
            _folder: folder,
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

/// Unpack an archive whose entries all stay in the folder.
fn unpack(archive: &mut ZipArchive<Cursor<Vec<u8>>>, folder: &Path) -> Result<()> {
    for k in 0..archive.len() {
        let mut entry = archive.by_index(k)?;
        let name = entry.name()?.into_owned();
        let Some(path) = entry.enclosed_name() else {
            bail!("its entry `{name}` would lie outside the folder it is unpacked to");
        };
        ensure!(!entry.is_symlink(), "its entry `{name}` is a link");
        let path = folder.join(path);
        if entry.is_dir() {
            std::fs::create_dir_all(path)?;
            continue;
        }
        std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
        let mut file = std::fs::File::create(&path)?;
        std::io::copy(&mut entry, &mut file).with_context(|| format!("its entry `{name}`"))?;
    }
    Ok(())
}

/// The library for this platform: named after the identifier, else the only one in the folder of the platform.
fn library(
    folder: &Path,
    fmi: Version,
    identifier: &str,
    remarks: &mut Vec<String>,
) -> Result<PathBuf> {
    use std::env::consts::{ARCH, DLL_SUFFIX, OS};
    let system = match (fmi, OS) {
        (_, "macos") => "darwin",
        (Version::Fmi2, "windows") => "win",
        (_, other) => other,
    };
    let bits = if cfg!(target_pointer_width = "64") {
        64
    } else {
        32
    };
    let platform = match fmi {
        Version::Fmi2 => format!("binaries/{system}{bits}"),
        Version::Fmi3 => format!("binaries/{ARCH}-{system}"),
    };
    let named = folder
        .join(&platform)
        .join(format!("{identifier}{DLL_SUFFIX}"));
    if named.is_file() {
        return Ok(named);
    }
    let entries = std::fs::read_dir(folder.join(&platform))
        .into_iter()
        .flatten();
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut libraries = files.filter(|f| f.to_string_lossy().ends_with(DLL_SUFFIX));
    match (libraries.next(), libraries.next()) {
        (Some(only), None) => {
            let name = only.file_name().unwrap_or_default().to_string_lossy();
            remarks.push(format!(
                "its library is {platform}/{name}; it should be named after the model identifier, `{identifier}`"
            ));
            Ok(only)
        }
        _ => {
            bail!("it holds no {platform}/{identifier}{DLL_SUFFIX}, the library for this platform")
        }
    }
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

fn description_text(archive: &mut ZipArchive<Cursor<Vec<u8>>>) -> Result<String> {
    let entry = archive.by_name("modelDescription.xml");
    let mut entry = entry.map_err(|_| anyhow!("it holds no modelDescription.xml"))?;
    let mut text = String::new();
    entry
        .read_to_string(&mut text)
        .context("modelDescription.xml is not UTF-8 text")?;
    Ok(text)
}
