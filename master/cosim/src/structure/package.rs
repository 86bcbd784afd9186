//! Reads the files of a packed system (`.ssp`) or a `.ssd`'s folder, for `System` and `cosim info`.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use fmi_description::Archive;
use percent_encoding::percent_decode_str;

/// Name of the default structure in a packed system.
pub(super) const DEFAULT: &str = "SystemStructure.ssd";

/// An open packed system, or the folder of a structure.
pub struct Package {
    path: PathBuf,
    archive: Option<Archive>,
}

impl Package {
    /// Open a `.ssp`, or the folder of a `.ssd`.
    pub fn open(path: &Path) -> Result<Self> {
        if path.extension().is_some_and(|e| e == "ssp") {
            let bytes = read(path).context("system")?;
            return Self::from_bytes(&path.display().to_string(), bytes);
        }
        Ok(Self {
            path: path.to_path_buf(),
            archive: None,
        })
    }

    /// Open the bytes of a packed system; `name` is its name for messages.
    pub fn from_bytes(name: &str, bytes: Vec<u8>) -> Result<Self> {
        let archive = Archive::open(bytes).with_context(|| format!("`{name}`"))?;
        Ok(Self {
            path: PathBuf::from(name),
            archive: Some(archive),
        })
    }

    /// The bytes of a packed system; empty for a folder.
    pub fn into_bytes(self) -> Vec<u8> {
        self.archive.map_or_else(Vec::new, Archive::into_bytes)
    }

    /// Path of the packed system or the structure.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the files of a packed system.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.archive.iter().flat_map(Archive::names)
    }

    /// Text of the system structure; of a packed system the structure named `variant`, else the
    /// default one.
    pub fn structure(&mut self, variant: Option<&str>) -> Result<String> {
        if self.archive.is_some() {
            return self.text(variant.unwrap_or(DEFAULT));
        }
        if let Some(variant) = variant {
            bail!(
                "`{}` is a system structure by itself; the variant `{variant}` is one in a packed .ssp",
                self.path.display()
            );
        }
        let bytes = read(&self.path).context("system")?;
        if bytes.starts_with(b"PK") {
            let kind = self.path.extension();
            let is_fmu = kind.is_some_and(|kind| kind.eq_ignore_ascii_case("fmu"));
            bail!(
                "`{}` is {}, not a system structure; a system is a packed .ssp or a .ssd that names FMUs",
                self.path.display(),
                if is_fmu { "an FMU" } else { "a ZIP archive" }
            );
        }
        self.utf8(bytes, "it")
    }

    /// Name of the structure that [`Package::structure`] gives, for messages.
    pub fn structure_name(&self, variant: Option<&str>) -> String {
        match self.archive {
            Some(_) => variant.unwrap_or(DEFAULT).to_string(),
            None => self.path.display().to_string(),
        }
    }

    /// A file of the package, by its name relative to the system structure, which may be
    /// percent-encoded. The name of a file in a nested packed system begins with the name of that
    /// system, `parts/inner.ssp/resources/A.fmu`.
    pub fn file(&mut self, name: &str) -> Result<Vec<u8>> {
        let name = name.strip_prefix("file://").unwrap_or(name);
        if let Some((outer, inner)) = name.split_once(".ssp/") {
            let outer = format!("{outer}.ssp");
            let mut archive = Archive::open(self.file(&outer)?).context(outer.clone())?;
            return in_archive(&mut archive, inner, &outer);
        }
        match &mut self.archive {
            Some(archive) => in_archive(archive, name, &self.path.display().to_string()),
            None => {
                let folder = self.path.parent().unwrap_or(Path::new("."));
                let (plain, decoded) = (folder.join(name), folder.join(&*decoded(name)));
                read(if plain.exists() { &plain } else { &decoded })
            }
        }
    }

    /// A text file of the package.
    pub fn text(&mut self, name: &str) -> Result<String> {
        let bytes = self.file(name)?;
        self.utf8(bytes, &format!("`{name}`"))
    }

    /// Whether a packed system contains the file.
    pub fn holds(&self, name: &str) -> bool {
        self.names().any(|n| n == name)
    }

    fn utf8(&self, bytes: Vec<u8>, what: &str) -> Result<String> {
        String::from_utf8(bytes)
            .with_context(|| format!("`{}`: {what} is not UTF-8 text", self.path.display()))
    }
}

/// Where the FMUs of a system are.
#[derive(Clone, Debug)]
pub enum FmuPlace {
    /// In this folder, by file name.
    Folder(PathBuf),
    /// Where the structure says, else in the first of these folders that contains the file.
    Structure {
        /// Further folders.
        else_in: Vec<PathBuf>,
    },
}

impl FmuPlace {
    /// The FMU that a structure names. A source in a folder of the resources,
    /// `resources/fmi3/Emla.fmu`, is looked for in that folder too.
    pub fn read(&self, source: &str, package: &mut Package) -> Result<Vec<u8>> {
        let name = Path::new(source).file_name().unwrap_or_default();
        let inner = Path::new(source).strip_prefix("resources").ok();
        let names = |folder: &PathBuf| {
            let mut names = Vec::from_iter(inner.map(|inner| folder.join(inner)));
            names.push(folder.join(name));
            names
        };
        match self {
            Self::Folder(folder) => {
                let files = names(folder);
                let found = files.iter().find(|file| file.is_file());
                read(found.unwrap_or(&folder.join(name)))
            }
            Self::Structure { else_in } => package.file(source).or_else(|error| {
                let mut files: Vec<PathBuf> = else_in.iter().flat_map(names).collect();
                files.dedup();
                if let Some(file) = files.iter().find(|file| file.is_file()) {
                    return read(file);
                }
                let files: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
                Err(match files.is_empty() {
                    true => error,
                    false => anyhow!("{error:#}, nor is it one of {}", files.join(", ")),
                })
            }),
        }
    }
}

/// A file of the archive named `whole`.
fn in_archive(archive: &mut Archive, name: &str, whole: &str) -> Result<Vec<u8>> {
    let decoded = decoded(name);
    let mut path: Vec<&str> = Vec::new();
    for part in decoded.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(path.pop()),
            _ => path.push(part),
        }
    }
    if let Some(bytes) = archive.file(&path.join("/"))? {
        return Ok(bytes);
    }
    let kind = Path::new(name).extension();
    let alike = archive.names().filter(|n| Path::new(n).extension() == kind);
    let alike = Some(alike.collect::<Vec<_>>().join(", ")).filter(|names| !names.is_empty());
    bail!(
        "`{whole}` holds no {name}; of this kind it has {}",
        alike.as_deref().unwrap_or("none")
    )
}

/// A name with percent-encoded characters replaced.
fn decoded(name: &str) -> Cow<'_, str> {
    let decoded = percent_decode_str(name).decode_utf8();
    decoded.unwrap_or(name.into())
}

/// The text of the file at `path`.
pub fn read_text(path: &Path) -> Result<String> {
    let text = String::from_utf8(read(path)?);
    text.with_context(|| format!("`{}` is not UTF-8 text", path.display()))
}

/// The bytes of the file at `path`; an error names the path as given, and the absolute path.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let file = path.display();
    output_file::note_read(path)?;
    fs::read(path).with_context(|| match std::path::absolute(path) {
        Ok(absolute) if absolute != path => {
            let absolute = absolute.display();
            format!("`{file}` cannot be read (looked for {absolute})")
        }
        _ => format!("`{file}` cannot be read"),
    })
}
