//! Files that a library has compiled in and that are packed into the FMU's `resources` folder, too:
//! what a user has edited there counts. `c_api` asks for it when an instance is made; a host without
//! that folder, such as one of WebAssembly, gets what is compiled in.

use super::fault::Fault;
use super::instance::Instance;
use super::message::Kind;
use super::parameter_file::{exists, read};
use super::storage::Storage;
use crate::Model;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::ErrorKind;
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
        let Some(file) = resources.map(|folder| folder.join(self.path)) else {
            return Ok(None);
        };
        let context = |e: &dyn Display| format!("file `{}`: {e}", file.display());
        match read(&file) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(context(&error)),
            Ok(text) if digest(text.as_bytes()) == self.digest => Ok(None),
            Ok(text) => match parse(&text, &file) {
                Ok(parsed) => Ok(Some(parsed)),
                Err(error) => Err(context(&error)),
            },
        }
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

impl<M: Model> Instance<M> {
    /// Takes over the files in the `resources` folder that String parameters stand for by default
    /// and that differ from what is compiled in.
    pub(crate) fn take_packed_files(&mut self) -> Result<(), String> {
        let Some(folder) = self.resources.clone() else {
            return Ok(());
        };
        let (mut found, mut missing) = (BTreeMap::new(), Vec::new());
        for (_, row) in self.layout.rows() {
            let Storage::Text(get, _) = &row.storage else {
                continue;
            };
            let start = get(&self.start);
            let path = row.packed_file.map_or(start, |packed| packed.path);
            if path.is_empty() || Path::new(path).is_absolute() {
                continue;
            }
            match (read(&folder.join(path)), row.packed_file) {
                (Err(error), _) if error.kind() == ErrorKind::NotFound => missing.push(format!(
                    "`{}`: there is no `{path}` in the resources folder {}; the one that is compiled in is used",
                    row.name,
                    folder.display()
                )),
                (Err(error), _) => {
                    let file = folder.join(path);
                    return Err(format!("`{}`: file `{}`: {error}", row.name, file.display()));
                }
                (Ok(text), Some(packed)) if digest(text.as_bytes()) == packed.digest => {}
                (Ok(_), _) => {
                    found.insert(row.name, path.to_owned());
                }
            }
        }
        if !missing.is_empty() && exists(&folder).unwrap_or(false) {
            for text in missing {
                self.report(Kind::Warning, text);
            }
        }
        if found.is_empty() {
            return Ok(());
        }
        self.packed_texts = found;
        let (start, settings) = (self.start.clone(), self.state.settings.clone());
        let texts = self.texts(&start, &settings);
        let parameters = self.composed(&texts, &start, &settings);
        let parameters = parameters.map_err(|fault| match fault {
            Fault::Refused(text) | Fault::Discarded(text) => format!(
                "{text}; the file is in the FMU's resources folder {} and counts before the one that is compiled in",
                folder.display()
            ),
            Fault::Unknown(number) => format!("no variable has the number {number}"),
        })?;
        let bytes = |p: &M::Parameters| postcard::to_extend(p, Vec::new()).ok();
        if bytes(&parameters) == bytes(&start) {
            self.packed_texts.clear();
            return Ok(());
        }
        let files: Vec<_> = self
            .packed_texts
            .values()
            .map(|file| format!("`{file}`"))
            .collect();
        let text = format!(
            "{} in the resources folder {} differs from what is compiled in, and is used",
            files.join(" and "),
            folder.display()
        );
        self.report(Kind::Event, text);
        self.state.parameters = parameters.clone();
        self.packed_start = Some(parameters);
        Ok(())
    }
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
