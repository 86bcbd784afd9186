//! Writes output files: a new file gets its name once it is complete, and a file that this process
//! reads is never replaced. Pipes, devices and links are written through.
//!
//! ```
//! # let path = std::env::temp_dir().join("output-file-doc.txt");
//! output_file::write(&path, "whole or not at all")?;
//! # std::io::Result::Ok(())
//! ```
#![forbid(unsafe_code)]

mod in_use;
mod place;
mod temporary;

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

pub use in_use::{claim, note_read};
pub use place::set_stdout;
pub use temporary::TemporaryFolder;

use place::{Place, named};

/// A file that is being written. If it is dropped before [`OutputFile::commit`], a regular file
/// stays as it was.
pub struct OutputFile {
    path: PathBuf,
    out: BufWriter<File>,
    /// The temporary file and the one that it becomes; none if it is written through.
    names: Option<[PathBuf; 2]>,
    has_failed: bool,
}

impl OutputFile {
    /// Creates a file, or opens a pipe or a device.
    ///
    /// # Errors
    /// It names the path: the path cannot be written, or this process reads the file.
    pub fn create(path: &Path) -> io::Result<Self> {
        let opened = Place::find(path).and_then(|place| match place {
            Place::Stream(stream) => Ok((stream, None)),
            Place::File(file) => {
                in_use::refuse_read(&file)?;
                let (part, new) = temporary::file(&file)?;
                Ok((new, Some([part, file])))
            }
        });
        let (file, names) = opened.map_err(|error| named(path, &error))?;
        Ok(Self {
            path: path.to_path_buf(),
            out: BufWriter::with_capacity(1 << 16, file),
            names,
            has_failed: false,
        })
    }

    /// The path, as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is a pipe or a device, which has what is written at once.
    pub fn is_stream(&self) -> bool {
        self.names.is_none()
    }

    /// Completes the file: it replaces the one that has its name.
    ///
    /// # Errors
    /// It names the path: not all could be written. A regular file is then left as it was.
    pub fn commit(mut self) -> io::Result<()> {
        self.flush()?;
        if self.has_failed {
            let error = io::Error::other("a part of it could not be written");
            return Err(named(&self.path, &error));
        }
        if let Some([part, file]) = &self.names {
            fs::rename(part, file).map_err(|error| named(&self.path, &error))?;
        }
        self.names = None;
        Ok(())
    }

    fn check<T>(&mut self, done: io::Result<T>) -> io::Result<T> {
        done.map_err(|error| {
            self.has_failed = true;
            named(&self.path, &error)
        })
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let done = self.out.write(bytes);
        self.check(done)
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = self.out.flush();
        self.check(done)
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if let Some([part, _]) = &self.names {
            // A failure cannot be reported from here.
            let _ = fs::remove_file(part);
        }
    }
}

/// Writes a whole file, as [`OutputFile`] does.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = OutputFile::create(path)?;
    file.write_all(bytes.as_ref())?;
    file.commit()
}
