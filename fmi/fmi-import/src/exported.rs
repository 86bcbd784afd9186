//! The files of an FMU that a library made with `fmu_export::export_fmu!` carries, received through
//! its functions `fmi2ExportFiles` and `fmi3ExportFiles`, for `cargo fmu`, `xtask` and `Fmu::open`.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;

use anyhow::{Context, Result, bail};
use fmi_description::{Entries, Version};

use crate::calls::Exports as _;
use crate::library::Library;
use crate::under_way::{About, Slot};

type Receive = unsafe extern "C" fn(*mut c_void, *const c_char, *const u8, usize);
/// The C functions `fmi2ExportFiles` and `fmi3ExportFiles`.
type ExportFiles = unsafe extern "C" fn(*mut c_void, Option<Receive>) -> c_int;

/// Why there is no FMU of this version: a variable has a type that only FMI 3.0 has.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UnsupportedType(String);

#[derive(Default)]
struct ReceivedFiles {
    files: Entries,
    reason: Option<String>,
}

/// All files of the FMU of this version except its binaries. The library must be one that this
/// machine can load.
///
/// # Errors
/// The library cannot be loaded or carries no files; [`UnsupportedType`] if the version of FMI does
/// not have a type that it uses.
pub fn exported_files(library: &Path, version: Version) -> Result<Entries> {
    let function = match version {
        Version::Fmi2 => "fmi2ExportFiles",
        Version::Fmi3 => "fmi3ExportFiles",
    };
    let name = library.display();
    let loaded = Library::open(library).with_context(|| format!("{name} cannot be loaded"))?;
    // SAFETY: `fmu_export::export_fmu!` gives the symbol this signature.
    let export = unsafe { loaded.function::<ExportFiles>(function) };
    let export = export.with_context(|| {
        format!("{name} exports no {function}; does the crate use fmu_export::export_fmu!?")
    })?;
    let who = CString::new(name.to_string()).unwrap_or_default();
    let about = About::rare(function);
    let _call = Slot::fresh().call_of(&who, &about);
    // SAFETY: the function of a library that stays loaded until it has returned.
    unsafe { receive_files(export) }.with_context(|| name.to_string())
}

/// Calls the function, and returns the files that it hands out.
///
/// # Safety
/// `export` must be what `fmu_export::export_fmu!` makes, and callable.
unsafe fn receive_files(export: ExportFiles) -> Result<Entries> {
    let mut received = ReceivedFiles::default();
    // SAFETY: the context is what `receive` expects, and outlives the call.
    let status = unsafe { export((&raw mut received).cast(), Some(receive)) };
    match received.reason {
        Some(reason) if status == 2 => Err(UnsupportedType(reason).into()),
        Some(reason) => bail!("{reason}"),
        None if status != 0 => bail!("the function for the files returned {status}"),
        None => Ok(received.files),
    }
}

unsafe extern "C" fn receive(
    context: *mut c_void,
    path: *const c_char,
    bytes: *const u8,
    size: usize,
) {
    // SAFETY: the context given to fmi2ExportFiles, used by nothing else meanwhile.
    let received = unsafe { &mut *context.cast::<ReceivedFiles>() };
    let content = match size {
        0 => &[],
        // SAFETY: `size` readable bytes.
        _ => unsafe { std::slice::from_raw_parts(bytes, size) },
    };
    if path.is_null() {
        received.reason = Some(String::from_utf8_lossy(content).into_owned());
        return;
    }
    // SAFETY: not NULL, hence a C string.
    let path = unsafe { CStr::from_ptr(path) };
    let path = path.to_string_lossy().into_owned();
    received.files.insert(path, content.to_vec());
}

#[cfg(test)]
mod tests {
    use super::*;

    unsafe extern "C" fn two_files(to: *mut c_void, receive: Option<Receive>) -> c_int {
        let receive = receive.unwrap();
        // SAFETY: a C string and as many bytes as are there; no bytes for an empty file.
        unsafe {
            receive(to, c"a/b.txt".as_ptr(), b"text".as_ptr(), 4);
            receive(to, c"empty".as_ptr(), std::ptr::null(), 0);
        }
        0
    }

    unsafe extern "C" fn refusal(to: *mut c_void, receive: Option<Receive>) -> c_int {
        // SAFETY: no path: the bytes are the reason.
        unsafe { receive.unwrap()(to, std::ptr::null(), b"row `x`".as_ptr(), 7) };
        1
    }

    unsafe extern "C" fn silent_failure(_: *mut c_void, _: Option<Receive>) -> c_int {
        7
    }

    #[test]
    fn files_and_reasons_are_received() {
        // SAFETY: the functions above keep to the contract.
        let (files, refused, failed) = unsafe {
            (
                receive_files(two_files).unwrap(),
                receive_files(refusal).unwrap_err(),
                receive_files(silent_failure).unwrap_err(),
            )
        };
        let expected = [("a/b.txt", b"text".to_vec()), ("empty", vec![])];
        assert_eq!(files, expected.map(|(p, b)| (p.to_string(), b)).into());
        assert_eq!(refused.to_string(), "row `x`");
        assert_eq!(failed.to_string(), "the function for the files returned 7");
    }
}
