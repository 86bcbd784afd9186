//! Reads the files of a packed system (`.ssp`) or a `.ssd`'s folder, for `System` and `cosim info`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail, ensure};
use fmi_description::{Archive, limits};
use percent_encoding::percent_decode_str;

/// Name of the default structure in a packed system.
pub(super) const DEFAULT: &str = "SystemStructure.ssd";

/// Name of a system of the Open Simulation Platform.
const OSP: &str = "OspSystemStructure.xml";

/// An open packed system, or the folder of a structure. A packed system takes nothing from outside
/// of itself, nor does one inside it.
pub struct Package {
    path: PathBuf,
    archive: Option<Layer>,
    /// Packed systems in the folder of a structure, by path.
    inner: BTreeMap<PathBuf, Layer>,
    sizes: Sizes,
}

/// An archive with the opened packages in it.
struct Layer {
    archive: Archive,
    inner: BTreeMap<String, Layer>,
}

/// Bytes of the packages that were opened, and of all that they unpack to.
#[derive(Default)]
struct Sizes {
    packed: u64,
    unpacked: u64,
}

impl Sizes {
    fn add(&mut self, packed: u64, unpacked: u64) -> Result<()> {
        self.packed += packed;
        self.unpacked = self.unpacked.saturating_add(unpacked);
        match limits::excess(self.packed, self.unpacked) {
            Some(text) => bail!("with what is packed inside, it is too large: {text}"),
            None => Ok(()),
        }
    }
}

impl Layer {
    /// Opens an archive that is not inside another.
    fn open(bytes: Vec<u8>, sizes: &mut Sizes) -> Result<Self> {
        let packed = bytes.len() as u64;
        let archive = Archive::open(bytes)?;
        sizes.add(packed, archive.unpacked_size())?;
        let inner = BTreeMap::new();
        Ok(Self { archive, inner })
    }

    /// The file with this path, which may lead through packages; `whole` is the path of this one.
    fn file(&mut self, name: &str, whole: &str, sizes: &mut Sizes) -> Result<Vec<u8>> {
        let (mut path, mut rest) = (Vec::new(), Some(name));
        while let Some(left) = rest {
            let split = left.split_once('/');
            let (part, further) = split.map_or((left, None), |(a, b)| (a, Some(b)));
            match part {
                "" | "." => {}
                ".." if path.pop().is_none() => bail!(
                    "`{name}` leads out of the package `{whole}`, which takes nothing from outside"
                ),
                ".." => {}
                _ => path.push(part),
            }
            rest = further;
            let Some(further) = further else { break };
            let outer = path.join("/");
            if self.archive.holds(&outer) {
                let place = format!("{whole}/{outer}");
                if !self.inner.contains_key(&outer) {
                    let bytes = self.archive.file(&outer)?.unwrap_or_default();
                    let archive = Archive::open(bytes).with_context(|| format!("`{place}`"))?;
                    sizes.add(0, archive.unpacked_size())?;
                    let inner = BTreeMap::new();
                    self.inner.insert(outer.clone(), Self { archive, inner });
                }
                let inner = self.inner.get_mut(&outer).context("it is open")?;
                return inner.file(further, &place, sizes);
            }
        }
        if let Some(bytes) = self.archive.file(&path.join("/"))? {
            return Ok(bytes);
        }
        let kind = Path::new(name).extension();
        let alike = self.archive.names();
        let alike = alike.filter(|n| Path::new(n).extension() == kind).take(20);
        let alike = Some(alike.collect::<Vec<_>>().join(", ")).filter(|names| !names.is_empty());
        bail!(
            "`{whole}` holds no {name}; of this kind it has {}",
            alike.as_deref().unwrap_or("none")
        )
    }
}

/// Where a structure is that names other files.
#[derive(Clone, Copy)]
pub(super) struct Base<'a> {
    /// Its folder, relative to the outermost structure: empty, or with `/` at the end.
    pub folder: &'a str,
    /// It is in a package inside another file.
    pub is_packed: bool,
}

impl Base<'_> {
    /// The name, relative to the outermost structure, of a file that a structure here names.
    pub fn file(&self, source: &str) -> Result<String> {
        let source = source.strip_prefix("file://").unwrap_or(source);
        if !leads_elsewhere(source) {
            return Ok(format!("{}{source}", self.folder));
        }
        ensure!(!self.is_packed, outside(source));
        Ok(source.into())
    }
}

/// Whether the name of a file is a path from the root, a URL, or on a drive.
fn leads_elsewhere(name: &str) -> bool {
    let name = decoded(name);
    name.starts_with(['/', '\\']) || name.contains(':')
}

fn outside(name: &str) -> String {
    format!("`{name}` is no path in the package, which takes nothing from outside")
}

impl Package {
    /// Open a `.ssp`, or the folder of a `.ssd` or of a system of the Open Simulation Platform,
    /// which may itself be named.
    pub fn open(path: &Path) -> Result<Self> {
        let whole;
        let path = match path.is_dir() {
            true => {
                whole = path.join(OSP);
                ensure!(
                    whole.is_file(),
                    "`{}` is a folder without {OSP}; a system is a packed .ssp, a .ssd or an {OSP}",
                    path.display()
                );
                &whole
            }
            false => path,
        };
        if path.extension().is_some_and(|e| e == "ssp") {
            let bytes = read(path).context("system")?;
            return Self::from_bytes(&path.display().to_string(), bytes);
        }
        Ok(Self {
            path: path.to_path_buf(),
            archive: None,
            inner: BTreeMap::new(),
            sizes: Sizes::default(),
        })
    }

    /// Open the bytes of a packed system; `name` is its name for messages.
    pub fn from_bytes(name: &str, bytes: Vec<u8>) -> Result<Self> {
        let mut sizes = Sizes::default();
        let archive = Layer::open(bytes, &mut sizes).with_context(|| format!("`{name}`"))?;
        Ok(Self {
            path: PathBuf::from(name),
            archive: Some(archive),
            inner: BTreeMap::new(),
            sizes,
        })
    }

    /// The bytes of a packed system; empty for a folder.
    pub fn into_bytes(self) -> Vec<u8> {
        let archive = self.archive.map(|layer| layer.archive);
        archive.map_or_else(Vec::new, Archive::into_bytes)
    }

    /// Path of the packed system or the structure.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the files of a packed system.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.archive.iter().flat_map(|layer| layer.archive.names())
    }

    /// Whether it is a system of the Open Simulation Platform.
    pub(super) fn is_osp(&self) -> bool {
        let kind = self.path.extension();
        self.archive.is_none() && kind.is_some_and(|kind| kind.eq_ignore_ascii_case("xml"))
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
        self.decode(&bytes, "it")
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
        let whole = self.path.display().to_string();
        if let Some(layer) = &mut self.archive {
            ensure!(!leads_elsewhere(name), outside(name));
            let path = decoded(name).replace('\\', "/");
            return layer.file(&path, &whole, &mut self.sizes);
        }
        let Some((outer, inner)) = self.in_package(name) else {
            return read(&self.on_disk(name));
        };
        if !self.inner.contains_key(&outer) {
            let layer = Layer::open(read(&outer)?, &mut self.sizes);
            let layer = layer.with_context(|| format!("`{}`", outer.display()))?;
            self.inner.insert(outer.clone(), layer);
        }
        let layer = self.inner.get_mut(&outer).context("it is open")?;
        let path = decoded(inner).replace('\\', "/");
        layer.file(&path, &outer.display().to_string(), &mut self.sizes)
    }

    /// The file with this name, relative to the folder of a structure.
    fn on_disk(&self, name: &str) -> PathBuf {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        let (plain, decoded) = (folder.join(name), folder.join(&*decoded(name)));
        if plain.exists() { plain } else { decoded }
    }

    /// The packed system in the folder of a structure that a name leads into, and the rest of it.
    fn in_package<'n>(&self, name: &'n str) -> Option<(PathBuf, &'n str)> {
        let mut slashes = name.match_indices('/');
        slashes.find_map(|(at, _)| {
            let outer = self.on_disk(&name[..at]);
            outer.is_file().then_some((outer, &name[at + 1..]))
        })
    }

    /// Whether a file of this name must be in a package.
    fn is_packed(&self, name: &str) -> bool {
        self.archive.is_some() || self.in_package(name).is_some()
    }

    /// Counts what an FMU of the package unpacks to; an error if it is too much for all together.
    pub(super) fn count(&mut self, source: &str, unpacked: u64) -> Result<()> {
        match self.is_packed(source) {
            true => self.sizes.add(0, unpacked),
            false => Ok(()),
        }
    }

    /// A text file of the package.
    pub fn text(&mut self, name: &str) -> Result<String> {
        let bytes = self.file(name)?;
        self.decode(&bytes, &format!("`{name}`"))
    }

    /// Whether a packed system contains the file.
    pub fn holds(&self, name: &str) -> bool {
        let mut archive = self.archive.iter();
        archive.any(|layer| layer.archive.holds(name))
    }

    fn decode(&self, bytes: &[u8], what: &str) -> Result<String> {
        let text = fmi_description::text(bytes);
        text.with_context(|| format!("`{}`: {what} is no text", self.path.display()))
    }
}

/// Where the FMUs of a system are.
#[derive(Clone, Debug)]
pub enum FmuPlace {
    /// In this folder, by file name.
    Folder(PathBuf),
    /// Where the structure says; for a structure that is in no package, else in the first of these
    /// folders that contains the file.
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
            Self::Structure { .. } if package.is_packed(source) => {
                package.file(source).context("it is taken from its package alone, unless it is named (--fmu COMPONENT=FILE, --fmu-dir DIR)")
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

/// A name with percent-encoded characters replaced.
fn decoded(name: &str) -> Cow<'_, str> {
    let decoded = percent_decode_str(name).decode_utf8();
    decoded.unwrap_or(name.into())
}

/// The text of the file at `path`.
pub fn read_text(path: &Path) -> Result<String> {
    let text = fmi_description::text(&read(path)?);
    text.with_context(|| format!("`{}` is no text", path.display()))
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
