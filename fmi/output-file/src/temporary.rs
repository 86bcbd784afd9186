//! Temporary files and folders. Each is locked by its process while that lives: what a killed
//! process left behind has no lock, and the next process that makes one removes it.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Once;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::place::folder_of;

/// A folder that is removed when it is dropped.
#[derive(Debug)]
pub struct TemporaryFolder {
    path: PathBuf,
    _lock: Option<File>,
}

impl TemporaryFolder {
    /// A new folder among the system's temporary files.
    pub fn new() -> io::Result<Self> {
        const PREFIX: &str = "fmu-of-process-";
        static ONCE: Once = Once::new();
        let place = std::env::temp_dir();
        ONCE.call_once(|| remove_stale(&place, PREFIX, |path| fs::remove_dir_all(path)));
        let make = |path: &Path| {
            #[cfg(unix)]
            {
                let mut folder = fs::DirBuilder::new();
                std::os::unix::fs::DirBuilderExt::mode(&mut folder, 0o700);
                folder.create(path)?;
            }
            #[cfg(not(unix))]
            fs::create_dir(path)?;
            // Elsewhere a folder cannot be opened, nor is it found to be stale.
            Ok(File::open(path).ok())
        };
        let (path, _lock) = held(&place, PREFIX, "", make)?;
        Ok(Self { path, _lock })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // What cannot be removed now is removed by a later process.
        let _ = fs::remove_dir_all(&self.path);
    }
}

/// A temporary file that is to become `file`, with the permissions of the present one.
pub(crate) fn file(file: &Path) -> io::Result<(PathBuf, File)> {
    const SUFFIX: &str = ".part";
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!(".{}.", name.chars().take(50).collect::<String>());
    let folder = folder_of(file);
    // A file that must not be written is not replaced either.
    let old = match OpenOptions::new().write(true).open(file) {
        Ok(old) => Some(old.metadata()?),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    remove_stale(folder, &prefix, |path| match path.extension() {
        Some(end) if end == &SUFFIX[1..] => fs::remove_file(path),
        _ => Ok(()),
    });
    let make = |path: &Path| {
        let new = OpenOptions::new().write(true).create_new(true).open(path);
        new.map(Some)
    };
    let (path, new) = held(folder, &prefix, SUFFIX, make)?;
    let new = new.ok_or(io::ErrorKind::NotFound)?;
    if let Some(old) = old {
        #[cfg(unix)]
        {
            use std::os::unix::fs::{MetadataExt as _, fchown};
            // Only the superuser can do that.
            let _ = fchown(&new, Some(old.uid()), Some(old.gid()));
        }
        // Some file systems have none.
        let _ = new.set_permissions(old.permissions());
    }
    Ok((path, new))
}

/// Makes a file or folder of a name that none had, and locks it.
fn held(
    folder: &Path,
    prefix: &str,
    suffix: &str,
    make: impl Fn(&Path) -> io::Result<Option<File>>,
) -> io::Result<(PathBuf, Option<File>)> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    loop {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("{prefix}{}-{count}{suffix}", process::id()));
        match make(&path) {
            Ok(made) => {
                // Another process may have taken it for stale before it was locked.
                let lock = made.as_ref().map_or(Ok(()), File::try_lock);
                if !matches!(lock, Err(TryLockError::WouldBlock)) && path.exists() {
                    return Ok((path, made));
                }
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
}

/// Removes what begins with `prefix` and is held by no living process.
fn remove_stale(folder: &Path, prefix: &str, remove: impl Fn(&Path) -> io::Result<()>) {
    let begins = |name: &OsStr| name.as_encoded_bytes().starts_with(prefix.as_bytes());
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if begins(&entry.file_name())
            && let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            // If it cannot be removed, it is in nobody's way.
            let _ = remove(&entry.path());
        }
    }
}
