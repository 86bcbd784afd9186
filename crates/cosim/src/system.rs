//! A loaded system: the structure and its FMUs, ready to be run as often and in as many threads as wanted.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail};

use crate::description::{Description, Variable};
use crate::fmu::Fmu;
use crate::master::Setting;
use crate::package::Package;
use crate::ssd::{Parameter, Structure, parse_set};
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
        Self::load_variant(path, None, fmu_dir)
    }

    /// As [`System::load`]; of a packed system the structure `variant` instead of the default.
    pub fn load_variant(
        path: &Path,
        variant: Option<&str>,
        fmu_dir: Option<&Path>,
    ) -> Result<Self> {
        let mut package = Package::open(path)?;
        let text = package.structure(variant)?;
        let structure = Structure::read(&text, |source| package.text(source))
            .with_context(|| format!("`{}`", path.display()))?;
        let mut loaded: BTreeMap<&str, Arc<Fmu>> = BTreeMap::new();
        let mut fmus = Vec::new();
        for c in &structure.components {
            let fmu = match loaded.get(c.source.as_str()) {
                Some(fmu) => fmu.clone(),
                None => {
                    let bytes = match fmu_dir {
                        Some(dir) => beside(&c.source, dir),
                        None => package.file(&c.source),
                    };
                    let bytes = bytes.with_context(|| format!("FMU of component `{}`", c.name))?;
                    let fmu = Fmu::load(&c.source, bytes)?;
                    loaded.insert(&c.source, fmu.clone());
                    fmu
                }
            };
            fmus.push(fmu);
        }
        let system = Self {
            path: path.to_path_buf(),
            structure,
            fmus,
        };
        for (c, fmu) in system.structure.components.iter().zip(&system.fmus) {
            for parameter in &c.parameters {
                check_unit(&c.name, fmu, parameter)?;
            }
        }
        Ok(system)
    }

    /// Apply a parameter set (`.ssv`) after the values that the structure binds: a file of the packed system, else one on disk. Its
    /// parameters are named `component.variable`, or only by variable where one component alone has it.
    pub fn apply_set(&mut self, file: &Path) -> Result<()> {
        let name = file.display().to_string();
        let mut package = Package::open(&self.path)?;
        let text = if package.holds(&name) {
            package.text(&name)?
        } else {
            let hint = || {
                let system = self.path.display();
                format!("parameter set `{name}`: neither a file in `{system}` nor a readable one")
            };
            fs::read_to_string(file).with_context(hint)?
        };
        for parameter in parse_set(&text, &name)? {
            let (k, variable) = match self.structure.split(&parameter.name) {
                Some((k, variable)) => (k, variable),
                None => {
                    let owner = self.owner(&parameter.name);
                    (owner.context(parameter.origin.clone())?.0, &*parameter.name)
                }
            };
            let name = variable.to_string();
            let parameter = Parameter { name, ..parameter };
            let component = &mut self.structure.components[k];
            check_unit(&component.name, &self.fmus[k], &parameter)?;
            component.parameters.push(parameter);
        }
        Ok(())
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
            _ => bail!(
                "several components have a variable `{name}`; name the component: component.{name}"
            ),
        }
    }
}

fn beside(source: &str, dir: &Path) -> Result<Vec<u8>> {
    let file = dir.join(Path::new(source).file_name().unwrap_or_default());
    fs::read(&file).with_context(|| format!("`{}` cannot be read", file.display()))
}

/// A value with a unit must be of the unit of its variable: nothing is converted.
fn check_unit(component: &str, fmu: &Fmu, parameter: &Parameter) -> Result<()> {
    let Parameter { name, origin, .. } = parameter;
    let variable = fmu.description.variable(name);
    let variable = variable.with_context(|| format!("{origin}: component `{component}`"))?;
    if let Some(unit) = &parameter.unit
        && variable.unit.as_ref() != Some(unit)
    {
        bail!(
            "{origin}: `{component}.{name}` = {} {unit}; allowed is the unit of the variable, {}",
            parameter.value,
            variable.unit.as_deref().unwrap_or("none")
        );
    }
    Ok(())
}
