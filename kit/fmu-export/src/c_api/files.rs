//! The files of an FMU other than its binaries, and how `cargo fmu pack` reads them from a library.

use super::library::Library;
use super::log::c_string;
use crate::core::panic;
use crate::{File, MadeFile, Model};
use std::borrow::Cow;
use std::ffi::{c_char, c_int, c_void};
use std::ptr;

/// Receives one file of the FMU: context, path inside the FMU (NUL-terminated; NULL for an error
/// text), its bytes and their number.
pub type ReceiveFile =
    unsafe extern "C" fn(context: *mut c_void, path: *const c_char, bytes: *const u8, size: usize);

/// A file to pack: its path inside the FMU, and its content.
pub(crate) type Packed = (String, Cow<'static, [u8]>);

/// The files of an FMU with this model description: icon, documentation and resources.
pub(crate) fn files<M: Model>(xml: String, icon: &str) -> Vec<Packed> {
    let info = M::INFO;
    let mut files = vec![("modelDescription.xml".to_owned(), xml.into_bytes().into())];
    if !info.icon.is_empty() {
        files.push((icon.to_owned(), info.icon.into()));
    }
    for (folder, list) in [
        ("documentation", info.documentation),
        ("resources", info.resources),
    ] {
        for File { path, bytes } in list {
            files.push((format!("{folder}/{path}"), (*bytes).into()));
        }
    }
    for MadeFile { path, make } in info.made_resources {
        files.push((format!("resources/{path}"), make().into()));
    }
    files
}

/// Passes all files to `receive`, or the reason why there are none; returns 0 on success, else 1.
///
/// # Safety
/// `receive` may be called with `context`.
pub(crate) unsafe fn export(
    library: &Library,
    context: *mut c_void,
    receive: Option<ReceiveFile>,
    files: fn(&str) -> Result<Vec<Packed>, String>,
) -> c_int {
    let Some(receive) = receive else { return 1 };
    library.silence_panics();
    let made = panic::catch(|| files(library.sizes)).unwrap_or_else(|panic| Err(panic.describe()));
    match made {
        Ok(files) => {
            for (path, bytes) in files {
                // SAFETY: forwarded; path and bytes live until `receive` returns.
                unsafe {
                    receive(
                        context,
                        c_string(&path).as_ptr(),
                        bytes.as_ptr(),
                        bytes.len(),
                    )
                };
            }
            0
        }
        Err(reason) => {
            // SAFETY: as above.
            unsafe { receive(context, ptr::null(), reason.as_ptr(), reason.len()) };
            1
        }
    }
}
