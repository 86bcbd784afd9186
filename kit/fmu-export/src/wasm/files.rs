//! Files of a WebAssembly module, which has no file system: its host places them.

use std::collections::BTreeMap;
use std::io::{self, Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::Mutex;

static PLACED: Mutex<BTreeMap<PathBuf, String>> = Mutex::new(BTreeMap::new());

/// The text of a file that the host has placed.
pub(crate) fn read(path: &Path) -> io::Result<String> {
    let placed = PLACED.lock().expect("no panic while it was locked");
    placed.get(path).cloned().ok_or_else(|| {
        let reason = "a WebAssembly module has no files but those that its host places there";
        Error::new(ErrorKind::NotFound, reason)
    })
}

/// Whether the host has placed a file there.
pub(crate) fn exists(path: &Path) -> io::Result<bool> {
    Ok(read(path).is_ok())
}

/// Places a file for all instances of this module, in the place of one that has the same path;
/// 0 if all is well, 1 if path or contents are not UTF-8.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmu_place_file(
    path: *const u8,
    path_size: usize,
    bytes: *const u8,
    size: usize,
) -> i32 {
    let text = |bytes: *const u8, size: usize| match size {
        0 => Ok(String::new()),
        // SAFETY: the host gives as many bytes as it says.
        _ => String::from_utf8(unsafe { slice::from_raw_parts(bytes, size) }.to_vec()),
    };
    let (Ok(path), Ok(text)) = (text(path, path_size), text(bytes, size)) else {
        return 1;
    };
    let mut placed = PLACED.lock().expect("no panic while it was locked");
    placed.insert(path.into(), text);
    0
}
