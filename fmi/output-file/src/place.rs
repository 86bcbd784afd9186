//! Where the path of an output leads, for `OutputFile`: links are followed, also those whose target
//! does not exist, and streams are told from regular files.

use std::fs::{self, File, OpenOptions};
use std::io;
#[cfg(unix)]
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The standard output, if the program has put something else in its place.
static STDOUT: OnceLock<File> = OnceLock::new();

/// Most links that are followed, as in Linux.
const LINKS: usize = 40;

/// What a path leads to.
pub enum Place {
    /// A regular file, which need not exist; the path is no link.
    File(PathBuf),
    /// A pipe, a device, or a descriptor of this process.
    Stream(File),
}

/// From now on `/dev/stdout` means this file: what the program had as standard output before it
/// redirected that.
pub fn set_stdout(file: File) {
    // Later calls change nothing.
    let _ = STDOUT.set(file);
}

impl Place {
    /// Follows the path.
    pub fn find(path: &Path) -> io::Result<Self> {
        let mut path = path.to_path_buf();
        for _ in 0..LINKS {
            if let Some(number) = descriptor(&path) {
                return open_descriptor(&path, &number).map(Self::Stream);
            }
            let Ok(target) = fs::read_link(&path) else {
                break;
            };
            path = path.parent().unwrap_or(Path::new("")).join(target);
        }
        match fs::metadata(&path) {
            Ok(found) if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(found) if !found.is_file() => {
                OpenOptions::new().write(true).open(path).map(Self::Stream)
            }
            _ => Ok(Self::File(path)),
        }
    }
}

/// The folder that a file is in.
pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The number of a descriptor of this process that the path names.
fn descriptor(path: &Path) -> Option<String> {
    let name = |folder| Some(path.strip_prefix(folder).ok()?.to_str()?.to_string());
    let number = name("/proc/self/fd").or_else(|| name("/dev/fd"))?;
    number.parse::<u32>().is_ok().then_some(number)
}

/// A regular file behind a descriptor may be written by others too, so that it is appended to.
fn open_descriptor(path: &Path, number: &str) -> io::Result<File> {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        let (mut stdout, stderr) = (io::stdout(), io::stderr());
        let own = match number {
            "1" => {
                stdout.flush()?;
                Some(STDOUT.get().map_or(stdout.as_fd(), AsFd::as_fd))
            }
            "2" => Some(stderr.as_fd()),
            _ => None,
        };
        if let Some(own) = own {
            return Ok(own.try_clone_to_owned()?.into());
        }
    }
    let _ = number;
    OpenOptions::new().append(true).open(path)
}

/// An error that names the path; its kind is kept, so that a reader that has gone is told apart.
pub fn named(path: &Path, error: &io::Error) -> io::Error {
    let text = format!("`{}` cannot be written: {error}", path.display());
    io::Error::new(error.kind(), text)
}
