//! Reads all files of an archive, and writes archives whose bytes depend only on their contents
//! (entries are sorted by name and have a fixed time), for `cargo fmu` and `xtask`.
//!
//! ```
//! use fmi_description::entries::{Entries, read_bytes, stored};
//! let files = Entries::from([("a.txt".to_string(), b"text".to_vec())]);
//! assert_eq!(read_bytes(stored(&files).unwrap()).unwrap(), files);
//! ```

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::archive::{Archive, ArchiveError};

/// Files of an archive: path inside it and content.
pub type Entries = BTreeMap<String, Vec<u8>>;

/// The deflate level of the smallest archives: libraries take 3 % less than at the usual level, and
/// packing takes some tenths of a second more.
const SMALLEST: i64 = 9;

/// The bytes of an archive without compression, for archives that are compressed as a whole.
pub fn stored(entries: &Entries) -> ZipResult<Vec<u8>> {
    let plain = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    zipped(entries, plain)
}

fn zipped(entries: &Entries, options: SimpleFileOptions) -> ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        let is_executable = name.starts_with("binaries/");
        let options = options
            .last_modified_time(DateTime::default())
            .unix_permissions(if is_executable { 0o755 } else { 0o644 });
        zip.start_file(name.as_str(), options)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// Writes an archive; returns its size in bytes. The file appears only once the archive is
/// complete.
pub fn write(path: &Path, entries: &Entries) -> Result<usize, ArchiveError> {
    let smallest = SimpleFileOptions::default().compression_level(Some(SMALLEST));
    let bytes = zipped(entries, smallest)
        .map_err(|error| ArchiveError::At(path.to_path_buf(), Box::new(error.into())))?;
    output_file::write(path, &bytes)?;
    Ok(bytes.len())
}

/// Reads all files of an archive.
pub fn read(path: &Path) -> Result<Entries, ArchiveError> {
    let bytes = fs::read(path).map_err(ArchiveError::from);
    let read = bytes.and_then(read_bytes);
    read.map_err(|error| ArchiveError::At(path.to_path_buf(), Box::new(error)))
}

/// Reads all files of an archive in memory.
pub fn read_bytes(bytes: Vec<u8>) -> Result<Entries, ArchiveError> {
    Archive::open(bytes)?.read_all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zip::ZipArchive;

    /// The time is fixed and the order is that of the names, so that equal contents give equal
    /// bytes whenever they are packed.
    #[test]
    fn equal_contents_give_equal_archives() {
        let path = std::env::temp_dir().join(format!("cargo-fmu-{}.zip", std::process::id()));
        let entries = Entries::from([
            ("b/x".to_string(), vec![1; 1000]),
            ("a".to_string(), b"text".to_vec()),
        ]);
        let size = write(&path, &entries).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert_eq!(bytes.len(), size);
        let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let written = (0..archive.len()).map(|k| {
            let entry = archive.by_index(k).unwrap();
            (entry.name().unwrap().into_owned(), entry.last_modified())
        });
        let expected = ["a", "b/x"].map(|name| (name.to_string(), Some(DateTime::default())));
        assert_eq!(written.collect::<Vec<_>>(), expected);
        assert_eq!(read(&path).unwrap(), entries);
        fs::remove_file(&path).unwrap();
    }
}
