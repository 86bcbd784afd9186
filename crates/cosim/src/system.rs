//! A loaded system: the structure and its FMUs, ready to be run as often and in as many threads as wanted.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail};

use crate::description::{Description, Variable};
use crate::fmu::Fmu;
use crate::master::Setting;
use crate::ssd::Structure;
use crate::wiring::Wiring;

/// A system structure with one loaded FMU per component (shared where the source is the same).
pub struct System {
    /// Where it came from.
    pub path: PathBuf,
    /// Components and connections.
    pub structure: Structure,
    /// FMU of each component.
    pub fmus: Vec<Arc<Fmu>>,
}

impl System {
    /// Load a packed system (`.ssp`), or a `.ssd` whose FMUs lie where it says or, by file name, in `fmu_dir`.
    pub fn load(path: &Path, fmu_dir: Option<&Path>) -> Result<Self> {
        let bytes = fs::read(path)
            .with_context(|| format!("system `{}` cannot be read", path.display()))?;
        if path.extension().is_some_and(|e| e == "ssp") {
            let name = path.display();
            let mut archive = zip::ZipArchive::new(Cursor::new(bytes))
                .with_context(|| format!("`{name}` is not a ZIP archive"))?;
            let text =
                entry(&mut archive, "SystemStructure.ssd").with_context(|| format!("`{name}`"))?;
            let structure =
                String::from_utf8(text).context("SystemStructure.ssd is not UTF-8 text")?;
            Self::new(path, &structure, |source| match fmu_dir {
                Some(dir) => beside(source, dir),
                None => entry(&mut archive, source).with_context(|| format!("`{name}`")),
            })
        } else {
            let text = String::from_utf8(bytes)
                .with_context(|| format!("`{}` is not UTF-8 text", path.display()))?;
            let here = path.parent().unwrap_or(Path::new("."));
            Self::new(path, &text, |source| match fmu_dir {
                Some(dir) => beside(source, dir),
                None => fs::read(here.join(source))
                    .with_context(|| format!("`{}` cannot be read", here.join(source).display())),
            })
        }
    }

    fn new(path: &Path, text: &str, mut read: impl FnMut(&str) -> Result<Vec<u8>>) -> Result<Self> {
        let structure = Structure::parse(text).with_context(|| format!("`{}`", path.display()))?;
        let mut loaded: BTreeMap<&str, Arc<Fmu>> = BTreeMap::new();
        let mut fmus = Vec::new();
        for c in &structure.components {
            let fmu = match loaded.get(c.source.as_str()) {
                Some(fmu) => fmu.clone(),
                None => {
                    let bytes = read(&c.source)
                        .with_context(|| format!("FMU of component `{}`", c.name))?;
                    let fmu = Fmu::load(&c.source, bytes)?;
                    loaded.insert(&c.source, fmu.clone());
                    fmu
                }
            };
            fmus.push(fmu);
        }
        Ok(Self {
            path: path.to_path_buf(),
            structure,
            fmus,
        })
    }

    /// The connections, resolved.
    pub fn wiring(&self) -> Result<Wiring<'_>> {
        let descriptions: Vec<&Description> = self.fmus.iter().map(|f| &f.description).collect();
        Wiring::new(&self.structure, &descriptions)
    }

    /// Index of the component `name`, or an error that lists what there is.
    pub fn component(&self, name: &str) -> Result<usize> {
        self.structure.component(name).ok_or_else(|| {
            let names: Vec<_> = self
                .structure
                .components
                .iter()
                .map(|c| c.name.as_str())
                .collect();
            anyhow!(
                "there is no component `{name}`; the system has {}",
                names.join(", ")
            )
        })
    }

    /// A start value for the one component that has the variable.
    pub fn setting(&self, variable: &str, value: &str) -> Result<Setting> {
        let (k, _) = self.owner(variable)?;
        let component = self.structure.components[k].name.clone();
        Ok(Setting {
            component,
            variable: variable.into(),
            value: value.into(),
        })
    }

    /// The one component that has the variable `name`, for options that do not name a component.
    pub fn owner(&self, name: &str) -> Result<(usize, &Variable)> {
        let mut owners = self
            .fmus
            .iter()
            .enumerate()
            .filter_map(|(k, f)| f.description.variable(name).ok().map(|v| (k, v)));
        match (owners.next(), owners.next()) {
            (Some(only), None) => Ok(only),
            (None, _) => bail!("no component of the system has a variable `{name}`"),
            _ => bail!("several components have a variable `{name}`; use --set component.{name}=…"),
        }
    }
}

fn beside(source: &str, dir: &Path) -> Result<Vec<u8>> {
    let file = dir.join(Path::new(source).file_name().unwrap_or_default());
    fs::read(&file).with_context(|| format!("`{}` cannot be read", file.display()))
}

fn entry(archive: &mut zip::ZipArchive<Cursor<Vec<u8>>>, name: &str) -> Result<Vec<u8>> {
    let mut file = archive
        .by_name(name)
        .map_err(|_| anyhow!("the archive holds no {name}"))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}
