//! Reads the files of an FMU from its built library, through the function `fmi2ExportFiles` that `fmu_export::export_fmu!` adds.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;

use anyhow::{Context, Result, bail};

/// A file of an FMU: path inside it and content.
pub type FmuFile = (String, Vec<u8>);

type Receive = unsafe extern "C" fn(*mut c_void, *const c_char, *const u8, usize);
type ExportFiles = unsafe extern "C" fn(*mut c_void, Option<Receive>) -> c_int;

#[derive(Default)]
struct Received {
    files: Vec<FmuFile>,
    error: Option<String>,
}

/// All files that the library carries: model description, documentation, icon, resources.
pub fn files(library: &Path) -> Result<Vec<FmuFile>> {
    let name = library.display();
    let mut received = Received::default();
    // SAFETY: a library just built from this workspace; loading it runs no code of its own.
    let loaded = unsafe { libloading::Library::new(library) }
        .with_context(|| format!("{name} cannot be loaded"))?;
    // SAFETY: the symbol has this signature in `fmu_export::export_fmu!`.
    let export = unsafe { loaded.get::<ExportFiles>(b"fmi2ExportFiles\0") };
    let export = export.with_context(|| {
        format!("{name} exports no fmi2ExportFiles; does the crate use export_fmu!?")
    })?;
    // SAFETY: the context is what `receive` expects and outlives the call.
    let status = unsafe { export((&raw mut received).cast(), Some(receive)) };
    if status != 0 || received.error.is_some() {
        bail!(
            "{name}: {}",
            received
                .error
                .unwrap_or_else(|| format!("fmi2ExportFiles returned {status}"))
        );
    }
    Ok(received.files)
}

unsafe extern "C" fn receive(
    context: *mut c_void,
    path: *const c_char,
    bytes: *const u8,
    size: usize,
) {
    // SAFETY: the context given to fmi2ExportFiles, used by nothing else meanwhile.
    let received = unsafe { &mut *context.cast::<Received>() };
    let content = if size == 0 {
        &[]
    } else {
        // SAFETY: `size` readable bytes.
        unsafe { std::slice::from_raw_parts(bytes, size) }
    };
    if path.is_null() {
        received.error = Some(String::from_utf8_lossy(content).into_owned());
    } else {
        // SAFETY: a C string.
        let path = unsafe { CStr::from_ptr(path) }
            .to_string_lossy()
            .into_owned();
        received.files.push((path, content.to_vec()));
    }
}

/// Text of the model description among the files.
pub fn description(files: &[FmuFile]) -> Result<&str> {
    let (_, bytes) = files
        .iter()
        .find(|(path, _)| path == "modelDescription.xml")
        .context("the library has no modelDescription.xml")?;
    std::str::from_utf8(bytes).context("modelDescription.xml is not UTF-8")
}

/// The model identifier in a model description: name of the library inside the FMU, and of the FMU.
pub fn identifier(description: &str) -> Result<String> {
    let after = description
        .split("modelIdentifier=\"")
        .nth(1)
        .context("the model description has no modelIdentifier")?;
    let identifier = after.split('"').next().unwrap_or_default();
    if identifier.is_empty()
        || !identifier
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || c == '_')
    {
        bail!("modelIdentifier `{identifier}` is no C identifier");
    }
    Ok(identifier.to_string())
}

#[cfg(test)]
mod tests {
    use super::identifier;

    #[test]
    fn only_c_identifiers_become_file_names() {
        assert_eq!(
            identifier("<CoSimulation modelIdentifier=\"Emla\" x=\"y\"/>").unwrap(),
            "Emla"
        );
        for bad in [
            "<CoSimulation/>",
            "modelIdentifier=\"\"",
            "modelIdentifier=\"../x\"",
        ] {
            assert!(identifier(bad).is_err(), "{bad}");
        }
    }
}
