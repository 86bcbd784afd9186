//! The files that this process reads and those that it is to write: an output never replaces an
//! input, nor another output, whatever names, links or hard links they are given by.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Error};
use std::path::{Path, PathBuf, absolute};
use std::sync::{Mutex, PoisonError};

use crate::place::{Place, folder_of, named};

/// Absolute paths in use, and whether they are to be written.
static IN_USE: Mutex<BTreeMap<PathBuf, bool>> = Mutex::new(BTreeMap::new());

/// Says that this process, or an FMU in it, reads a file.
///
/// # Errors
/// It is [claimed](claim) as an output.
pub fn note_read(path: &Path) -> io::Result<()> {
    // What is no regular file can be read and written at once.
    if !path.is_file() {
        return Ok(());
    }
    if let Some(output) = same(path, true) {
        let (file, output) = (path.display(), output.display());
        return Err(Error::other(format!(
            "`{file}` is read, and the output `{output}` would replace it; name another file for the output"
        )));
    }
    note(path, false)
}

/// Says beforehand that an output is to be written to a path: what is wrong is told before the
/// work, not after it.
///
/// # Errors
/// The path is a folder, or in none; this process reads the file; another output goes there.
pub fn claim(path: &Path) -> io::Result<()> {
    let found = fs::metadata(path);
    if found.is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Ok(());
    }
    let claimed = Place::find(path).and_then(|place| {
        let Place::File(file) = place else {
            return Ok(());
        };
        let folder = folder_of(&file);
        if !folder.is_dir() {
            let text = format!("there is no folder `{}`", folder.display());
            return Err(Error::other(text));
        }
        refuse_read(&file)?;
        match same(&file, true) {
            Some(_) => Err(Error::other("another output goes to the same file")),
            None => note(&file, true),
        }
    });
    claimed.map_err(|error| named(path, &error))
}

/// An error if this process reads the file.
pub(crate) fn refuse_read(file: &Path) -> io::Result<()> {
    same(file, false).map_or(Ok(()), |_| {
        Err(Error::other("this run reads it; name another file"))
    })
}

fn note(file: &Path, is_output: bool) -> io::Result<()> {
    let mut in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
    in_use.insert(absolute(file)?, is_output);
    Ok(())
}

/// A file in use, an output or not, that is this one.
fn same(file: &Path, is_output: bool) -> Option<PathBuf> {
    let key = identity(file);
    let in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut used = in_use.iter().filter(|(_, output)| **output == is_output);
    let found = used.find(|(path, _)| identity(path) == key);
    found.map(|(path, _)| path.clone())
}

/// What two paths of one file share: device and number if it exists and has them, else its path.
fn identity(file: &Path) -> (Option<[u64; 2]>, PathBuf) {
    #[cfg(unix)]
    if let Ok(found) = fs::metadata(file) {
        use std::os::unix::fs::MetadataExt as _;
        return (Some([found.dev(), found.ino()]), PathBuf::new());
    }
    let folder = folder_of(file);
    let folder = folder.canonicalize().unwrap_or(folder.to_path_buf());
    (None, folder.join(file.file_name().unwrap_or_default()))
}
