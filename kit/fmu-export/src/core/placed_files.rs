//! Files for `parameter_file` where there is no file system: a WebAssembly host places them in the
//! module through `wasm::files`.

use std::collections::BTreeMap;
use std::io::{self, Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

static PLACED: Mutex<BTreeMap<PathBuf, String>> = Mutex::new(BTreeMap::new());

/// Places a file for all instances of this module, in the place of one that has the same path.
pub(crate) fn place(path: PathBuf, text: String) {
    let mut placed = PLACED.lock().expect("no panic while it was locked");
    placed.insert(path, text);
}

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
