//! [`PackedFile`]: a file that a library has compiled in and that is packed into the FMU's
//! `resources` folder, too. Tables name it, so that what a user has edited there counts.

use super::parameter_file::read;
use std::fmt::Display;
use std::io::{self, ErrorKind};
use std::path::Path;

/// A file in the `resources` folder whose content is compiled in as well.
#[derive(Clone, Copy, Debug)]
pub struct PackedFile {
    /// Its path in the folder.
    pub path: &'static str,
    /// A hash of what is packed.
    pub digest: u64,
}

impl PackedFile {
    /// The file with this path in the folder, and the bytes that are packed.
    pub const fn new(path: &'static str, bytes: &[u8]) -> Self {
        let digest = digest(bytes);
        Self { path, digest }
    }

    /// Parses the file if the one in the `resources` folder is another than what is compiled in.
    ///
    /// # Errors
    /// The file cannot be read, or `parse` fails.
    pub fn if_edited<T, E: Display>(
        &self,
        resources: Option<&Path>,
        parse: impl FnOnce(&str, &Path) -> Result<T, E>,
    ) -> Result<Option<T>, String> {
        let Some(folder) = resources else {
            return Ok(None);
        };
        let file = folder.join(self.path);
        let context = |e: &dyn Display| format!("file `{}`: {e}", file.display());
        match self.edited_text(folder) {
            Ok(Some(text)) => parse(&text, &file).map(Some).map_err(|e| context(&e)),
            Ok(None) => Ok(None),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(context(&error)),
        }
    }

    /// The text of the file in the `resources` folder, if it is another than what is compiled in.
    pub(super) fn edited_text(&self, resources: &Path) -> io::Result<Option<String>> {
        let file = resources.join(self.path);
        let text = read(file.as_path())?;
        Ok((digest(text.as_bytes()) != self.digest).then_some(text))
    }
}

/// A hash that changes with every change of a single word of eight bytes.
const fn digest(bytes: &[u8]) -> u64 {
    const FACTOR: u64 = 0x9E37_79B9_7F4A_7C15;
    let (mut hash, mut rest) = (bytes.len() as u64, bytes);
    while let Some((word, after)) = rest.split_first_chunk::<8>() {
        hash = (hash ^ u64::from_le_bytes(*word))
            .wrapping_mul(FACTOR)
            .rotate_left(29);
        rest = after;
    }
    while let Some((byte, after)) = rest.split_first() {
        hash = (hash ^ *byte as u64).wrapping_mul(FACTOR).rotate_left(29);
        rest = after;
    }
    hash
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn every_single_change_is_seen() {
        let text: Vec<u8> = (0..37).collect();
        let own = digest(&text);
        for k in 0..text.len() {
            let mut other = text.clone();
            other[k] ^= 0x80;
            assert_ne!(digest(&other), own, "{k}");
            assert_ne!(digest(&text[..k]), own, "{k}");
        }
    }

    #[test]
    fn only_an_edited_file_is_read() {
        const FILE: PackedFile = PackedFile::new("a.txt", b"packed");
        let folder = std::env::temp_dir().join(format!("packed-file-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let parse = |text: &str, _: &Path| match text {
            "bad" => Err("line 1: bad"),
            other => Ok(other.to_owned()),
        };
        let read = || FILE.if_edited(Some(&folder), parse);
        assert_eq!(FILE.if_edited(None, parse), Ok(None));
        assert_eq!(read(), Ok(None), "no such file");
        for (text, expected) in [("packed", None), ("edited", Some("edited".to_owned()))] {
            fs::write(folder.join("a.txt"), text).unwrap();
            assert_eq!(read(), Ok(expected));
        }
        fs::write(folder.join("a.txt"), "bad").unwrap();
        let error = read().unwrap_err();
        assert!(error.contains("a.txt`: line 1: bad"), "{error}");
        fs::remove_dir_all(folder).unwrap();
    }
}
