//! The files that this process reads and those that it is to write: an output never replaces an
//! input, nor another output, whatever names, links or hard links they are given by.

use std::collections::BTreeMap;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::place::Place;

/// Absolute paths in use, and whether they are to be written.
static IN_USE: Mutex<BTreeMap<PathBuf, bool>> = Mutex::new(BTreeMap::new());

fn in_use() -> MutexGuard<'static, BTreeMap<PathBuf, bool>> {
    IN_USE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads a file, which this process then neither claims nor writes.
///
/// # Errors
/// It cannot be read, or is [claimed](claim) as an output.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    note_read(path)?;
    fs::read(path)
}

/// Says that this process, or an FMU in it, reads a file.
///
/// # Errors
/// It is [claimed](claim) as an output.
pub fn note_read(path: &Path) -> io::Result<()> {
    // What is no regular file can be read and written at once.
    if !path.is_file() {
        return Ok(());
    }
    if let Some(output) = same(path, |is_output| is_output) {
        return Err(io::Error::other(format!(
            "`{}` is read, and the output `{}` would replace it; name another file for the output",
            path.display(),
            output.display()
        )));
    }
    in_use().insert(std::path::absolute(path)?, false);
    Ok(())
}

/// Says beforehand that an output is to be written to a path: what is wrong is told before the
/// work, not after it.
///
/// # Errors
/// The path is a folder, or in none; this process reads the file; another output goes there.
pub fn claim(path: &Path) -> io::Result<()> {
    let refuse = |why: &str| {
        let text = format!("`{}` cannot be written: {why}", path.display());
        Err(io::Error::other(text))
    };
    let file = match fs::metadata(path) {
        Ok(found) if found.is_dir() => return refuse("it is a folder"),
        Ok(found) if !found.is_file() => return Ok(()),
        _ => match Place::find(path)? {
            Place::File(file) => file,
            Place::Stream(_) => return Ok(()),
        },
    };
    let folder = file
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        return refuse(&format!("there is no folder `{}`", folder.display()));
    }
    refuse_read(&file).or_else(|error| refuse(&error.to_string()))?;
    if same(&file, |is_output| is_output).is_some() {
        return refuse("another output goes to the same file");
    }
    in_use().insert(std::path::absolute(file)?, true);
    Ok(())
}

/// An error if this process reads the file.
pub(crate) fn refuse_read(file: &Path) -> io::Result<()> {
    match same(file, |is_output| !is_output) {
        Some(_) => Err(io::Error::other("this run reads it; name another file")),
        None => Ok(()),
    }
}

/// A file in use that is this one.
fn same(file: &Path, is_wanted: impl Fn(bool) -> bool) -> Option<PathBuf> {
    let key = identity(file);
    let in_use = in_use();
    let mut used = in_use
        .iter()
        .filter(|(_, is_output)| is_wanted(**is_output));
    let found = used.find(|(path, _)| identity(path) == key);
    found.map(|(path, _)| path.clone())
}

/// What two paths of one file share: numbers if it exists and has them, else its path.
fn identity(file: &Path) -> (Option<[u64; 2]>, PathBuf) {
    if let Some(numbers) = fs::metadata(file).ok().as_ref().and_then(numbers) {
        return (Some(numbers), PathBuf::new());
    }
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().unwrap_or(folder.to_path_buf());
    (None, folder.join(file.file_name().unwrap_or_default()))
}

/// Device and number of a file.
#[cfg(unix)]
fn numbers(file: &Metadata) -> Option<[u64; 2]> {
    use std::os::unix::fs::MetadataExt as _;
    Some([file.dev(), file.ino()])
}

#[cfg(not(unix))]
fn numbers(_: &Metadata) -> Option<[u64; 2]> {
    None
}
