//! Where a system's files are read from: a packed system (`.ssp`), or the folder of a `.ssd`.

use std::fs;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use zip::ZipArchive;

/// Name of the default structure in a packed system.
const DEFAULT: &str = "SystemStructure.ssd";

/// An opened package.
pub struct Package {
    path: PathBuf,
    archive: Option<ZipArchive<Cursor<Vec<u8>>>>,
}

impl Package {
    /// Open a `.ssp`, or the folder of a `.ssd`.
    pub fn open(path: &Path) -> Result<Self> {
        let mut archive = None;
        if path.extension().is_some_and(|e| e == "ssp") {
            let bytes = read(path).context("system")?;
            let read = ZipArchive::new(Cursor::new(bytes));
            archive =
                Some(read.with_context(|| format!("`{}` is not a ZIP archive", path.display()))?);
        }
        Ok(Self {
            path: path.to_path_buf(),
            archive,
        })
    }

    /// Text of the system structure: of a packed system the one named `variant`, without a name the default.
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
            bail!(
                "`{}` is {}, not a system structure; a system is a packed .ssp or a .ssd that names FMUs",
                self.path.display(),
                match self
                    .path
                    .extension()
                    .is_some_and(|e| e.eq_ignore_ascii_case("fmu"))
                {
                    true => "an FMU",
                    false => "a ZIP archive",
                }
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

    /// A file of the package, by its name relative to the system structure.
    pub fn file(&mut self, name: &str) -> Result<Vec<u8>> {
        let Some(archive) = &mut self.archive else {
            let file = self.path.parent().unwrap_or(Path::new(".")).join(name);
            return read(&file);
        };
        let Ok(mut entry) = archive.by_name(name) else {
            let kind = Path::new(name).extension();
            let alike: Vec<_> = archive
                .file_names()
                .flatten()
                .filter(|n| Path::new(n.as_ref()).extension() == kind)
                .collect();
            return Err(anyhow!(
                "`{}` holds no {name}; of this kind it has {}",
                self.path.display(),
                match alike.len() {
                    0 => "none".to_string(),
                    _ => alike.join(", "),
                }
            ));
        };
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// A text of the package.
    pub fn text(&mut self, name: &str) -> Result<String> {
        let bytes = self.file(name)?;
        self.utf8(bytes, &format!("`{name}`"))
    }

    /// True where a packed system holds the file.
    pub fn holds(&self, name: &str) -> bool {
        let archive = self.archive.as_ref();
        archive.is_some_and(|a| a.index_for_name(name).is_some())
    }

    fn utf8(&self, bytes: Vec<u8>, what: &str) -> Result<String> {
        String::from_utf8(bytes)
            .with_context(|| format!("`{}`: {what} is not UTF-8 text", self.path.display()))
    }
}

/// The file at `path`; an error names the path as it was given, and where that is.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| match std::path::absolute(path) {
        Ok(absolute) if absolute != path => {
            format!(
                "`{}` cannot be read (looked for {})",
                path.display(),
                absolute.display()
            )
        }
        _ => format!("`{}` cannot be read", path.display()),
    })
}
