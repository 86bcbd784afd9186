//! [`Archive`]: the ZIP archive of an FMU or of a system, for the importer and the master. Whatever
//! ZIP allows is accepted (folders as entries, data descriptors, zip64), but nothing is written
//! outside the folder to which it is unpacked, and no more than [`crate::limits`] allows.
//! [`Archive::open`] is where every archive is refused that must be.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use thiserror::Error;
use zip::ZipArchive;
use zip::read::{ArchiveOffset, Config};
use zip::result::ZipError;

use crate::description::{Description, Interface};
use crate::error::DescriptionError;
use crate::limits;
use crate::platform::Platform;
use crate::remark::Remark;

/// The files of an FMU or of another package, not yet unpacked.
pub struct Archive {
    zip: ZipArchive<Cursor<Vec<u8>>>,
    /// Index of each file in the ZIP archive, by its path.
    files: BTreeMap<String, usize>,
    /// Size of all files, bytes.
    size: u64,
    remarks: Vec<Remark>,
}

/// Why an archive cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// Not a ZIP archive, or a damaged one.
    #[error("it is not a ZIP archive that can be read: {0}")]
    Zip(#[from] ZipError),
    /// A file that cannot be read.
    #[error("`{name}` in it cannot be read: {reason}")]
    File {
        /// Path in the archive.
        name: String,
        /// Why.
        reason: String,
    },
    /// A path that leads out of the folder, a link, or a file that is there twice.
    #[error("`{name}` in it {reason}")]
    Unsafe {
        /// Path in the archive.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// Two files have the same name.
    #[error("two of its files have the same name")]
    Repeated,
    /// It has more files, or larger ones, than an archive may have.
    #[error("it is too large: {0}")]
    TooLarge(String),
    /// It has no model description, so it is no FMU.
    #[error("it holds no modelDescription.xml")]
    NoDescription,
    /// The description cannot be used.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// It has no library for this platform.
    #[error("it holds no {expected}, the library for this platform; {has}")]
    NoLibrary {
        /// Where the library should be.
        expected: String,
        /// The libraries that it has.
        has: String,
    },
    /// A file of the system cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// An error with the path of the archive or file.
    #[error("{0}: {1}")]
    At(PathBuf, Box<ArchiveError>),
}

impl Archive {
    /// The bytes of the archive.
    pub fn into_bytes(self) -> Vec<u8> {
        self.zip.into_inner().into_inner()
    }

    /// Opens an archive.
    ///
    /// # Errors
    /// It is no ZIP archive or does not begin with its first byte; it contains an unsafe path, a
    /// link, or a file twice; files overlap; it is too large once unpacked.
    pub fn open(bytes: Vec<u8>) -> Result<Self, ArchiveError> {
        let packed = bytes.len() as u64;
        // It must begin with the first byte: else a truncated package would be opened as the last
        // FMU that is stored in it.
        let archive_offset = ArchiveOffset::Known(0);
        let mut zip = ZipArchive::with_config(Config { archive_offset }, Cursor::new(bytes))?;
        if zip.len() > limits::FILES {
            let (count, most) = (zip.len(), limits::FILES);
            let text = format!("{count} files; at most {most} are allowed");
            return Err(ArchiveError::TooLarge(text));
        }
        if zip.has_duplicate_names() {
            return Err(ArchiveError::Repeated);
        }
        let (mut files, mut remarks) = (BTreeMap::new(), Vec::new());
        let (mut places, mut size) = (Vec::with_capacity(zip.len()), 0_u64);
        for index in 0..zip.len() {
            let entry = zip.by_index_raw(index)?;
            let written = entry.name()?.into_owned();
            let end = entry.data_start().unwrap_or(entry.header_start()) + entry.compressed_size();
            places.push((entry.header_start(), end, index));
            size = size.saturating_add(entry.size());
            let slashed = written.replace('\\', "/");
            let parts = slashed.split('/').filter(|part| !matches!(*part, "" | "."));
            let name = parts.collect::<Vec<_>>().join("/");
            let is_file = entry.is_file() && !slashed.ends_with('/');
            let reason = if !is_inside(&slashed) {
                Some("is a path that leads elsewhere")
            } else if entry.is_symlink() {
                Some("is a link")
            } else if is_file && files.contains_key(&name) {
                Some("is there twice")
            } else if cfg!(windows) {
                unportable(&name)
            } else {
                None
            };
            if let Some(reason) = reason {
                let name = written;
                return Err(ArchiveError::Unsafe { name, reason });
            }
            if slashed != written && remarks.is_empty() {
                remarks.push(Remark::Backslash(written));
            }
            if is_file {
                files.insert(name, index);
            }
        }
        places.sort_unstable();
        if let Some(pair) = places.windows(2).find(|pair| pair[1].0 < pair[0].1) {
            let name = zip.by_index_raw(pair[1].2)?.name()?.into_owned();
            let reason = "shares its bytes with another file";
            return Err(ArchiveError::Unsafe { name, reason });
        }
        if let Some(text) = limits::excess(packed, size) {
            return Err(ArchiveError::TooLarge(text));
        }
        Ok(Self {
            zip,
            files,
            size,
            remarks,
        })
    }

    /// What is wrong with it, but harms nobody here.
    pub fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    /// Reads all its files.
    pub fn read_all(&mut self) -> Result<BTreeMap<String, Vec<u8>>, ArchiveError> {
        let files = self.files.clone().into_iter();
        let read = files.map(|(name, index)| {
            let content = self.content(&name, index)?;
            Ok((name, content))
        });
        read.collect()
    }

    /// Size of all its files once unpacked, bytes.
    pub fn unpacked_size(&self) -> u64 {
        self.size
    }

    /// Paths of its files, with `/` as separator.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }

    /// Whether it has a file with this path.
    pub fn holds(&self, name: &str) -> bool {
        self.files.contains_key(name)
    }

    /// The content of the file with this path; None if there is none.
    pub fn file(&mut self, name: &str) -> Result<Option<Vec<u8>>, ArchiveError> {
        let Some(index) = self.files.get(name) else {
            return Ok(None);
        };
        self.content(name, *index).map(Some)
    }

    fn content(&mut self, name: &str, index: usize) -> Result<Vec<u8>, ArchiveError> {
        let unreadable = |reason: String| ArchiveError::File {
            name: name.to_string(),
            reason,
        };
        let mut entry = self
            .zip
            .by_index(index)
            .map_err(|e| unreadable(e.to_string()))?;
        let mut content = Vec::new();
        // An error if there is more than the directory says, whose sizes were checked.
        let read = entry.read_to_end(&mut content);
        read.map_err(|e| unreadable(e.to_string()))?;
        Ok(content)
    }

    /// Reads the model description for Co-Simulation, and adds remarks on the archive to it.
    pub fn description(&mut self) -> Result<Description, ArchiveError> {
        self.description_as(&[Interface::CoSimulation])
    }

    /// The same for the first of the interfaces `wanted` that the FMU has.
    pub fn description_as(&mut self, wanted: &[Interface]) -> Result<Description, ArchiveError> {
        let text = self.description_text()?;
        let mut description = Description::parse_as(&text, wanted, &HashMap::new())?;
        description.remarks.extend(self.remarks.iter().cloned());
        Ok(description)
    }

    /// The text of the model description.
    pub fn description_text(&mut self) -> Result<String, ArchiveError> {
        let bytes = self.file("modelDescription.xml")?;
        let text = crate::encoding::text(&bytes.ok_or(ArchiveError::NoDescription)?);
        text.map_err(|error| DescriptionError::from(error).into())
    }

    /// Whether it has sources, and no library for any platform.
    pub fn has_sources_only(&self) -> bool {
        let has_library = self.names().any(|name| name.starts_with("binaries/"));
        !has_library && self.names().any(is_source)
    }

    /// Path of the library for a platform, as [`library_among`] finds it.
    pub fn library(
        &self,
        description: &Description,
        platform: Platform,
    ) -> Result<(String, Option<Remark>), ArchiveError> {
        library_among(self.names(), description, platform)
    }

    /// Writes all files to a folder, which is made if necessary. The files are executable.
    pub fn unpack(&mut self, folder: &Path) -> Result<(), ArchiveError> {
        let write = |path: &Path, content: &[u8]| {
            if let Some(parent) = path.parent() {
                fs::create_dir_all(parent)?;
            }
            fs::write(path, content)?;
            allow_execution(path)
        };
        for (name, index) in self.files.clone() {
            let content = self.content(&name, index)?;
            let path = folder.join(&name);
            let written = write(&path, &content);
            written.map_err(|error| ArchiveError::At(path, Box::new(error.into())))?;
        }
        Ok(())
    }
}

/// Finds the path of the library for a platform among the files of an FMU. If none is named after
/// the identifier, but there is only one in the platform's folder, that is taken, with a remark.
pub fn library_among<'a>(
    names: impl Iterator<Item = &'a str>,
    description: &Description,
    platform: Platform,
) -> Result<(String, Option<Remark>), ArchiveError> {
    let expected = platform.library(description.fmi, &description.identifier);
    let expected = expected.ok_or_else(|| ArchiveError::NoLibrary {
        expected: format!("library for {}", platform.folder),
        has: format!("FMI {} has no folder for it", description.fmi),
    })?;
    let (binaries, others): (Vec<_>, Vec<_>) = names.partition(|n| n.starts_with("binaries/"));
    if binaries.contains(&expected.as_str()) {
        return Ok((expected, None));
    }
    let folder = &expected[..=expected.rfind('/').expect("in a folder")];
    let is_library = |name: &&&str| {
        let file = name.strip_prefix(folder);
        file.is_some_and(|file| !file.contains('/') && file.ends_with(platform.suffix))
    };
    let mut libraries = binaries.iter().filter(is_library);
    if let (Some(found), None) = (libraries.next(), libraries.next()) {
        let found = (*found).to_string();
        let remark = Remark::Library {
            expected,
            found: found.clone(),
        };
        return Ok((found, Some(remark)));
    }
    let has = match binaries.is_empty() {
        true if others.iter().any(|name| is_source(name)) => "it has C sources only".to_string(),
        true => "it has no binaries".to_string(),
        false => format!("it has {}", binaries[..binaries.len().min(8)].join(", ")),
    };
    Err(ArchiveError::NoLibrary { expected, has })
}

/// Whether it is a source of an FMU that is handed out to be compiled.
fn is_source(name: &str) -> bool {
    name.starts_with("sources/") && [".c", ".cpp", ".cc"].iter().any(|end| name.ends_with(end))
}

/// Whether a path stays in its folder on every file system: no drive, no device, no `..`.
fn is_inside(name: &str) -> bool {
    !name.starts_with('/') && !name.contains(['\0', ':']) && name.split('/').all(|p| p != "..")
}

/// Why no file of Windows can have this path, which archives may have elsewhere; None if one can.
pub fn unportable(path: &str) -> Option<&'static str> {
    let is_device = |part: &str| {
        let stem = part.split('.').next().unwrap_or_default().trim_end();
        let stem = stem.to_ascii_uppercase();
        let numbered = |name| {
            stem.strip_prefix(name)
                .is_some_and(|k| k.chars().count() == 1)
        };
        matches!(&*stem, "CON" | "PRN" | "AUX" | "NUL" | "CONIN$" | "CONOUT$")
            || (numbered("COM") || numbered("LPT"))
                && stem.ends_with(|k: char| k.is_ascii_digit() || "¹²³".contains(k))
    };
    let is_odd = |c: char| c.is_control() || r#"<>:"|?*\"#.contains(c);
    path.split('/').find_map(|part| match part {
        _ if part.contains(is_odd) => Some("has a character that no file of Windows can have"),
        _ if part.ends_with(['.', ' ']) => Some("ends with a dot or a blank, which Windows drops"),
        _ if is_device(part) => Some("is the name of a device of Windows"),
        _ => None,
    })
}

/// An FMU may contain programs, and archives made on Windows do not mark them as executable.
#[cfg(unix)]
fn allow_execution(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn allow_execution(_: &Path) -> io::Result<()> {
    Ok(())
}
