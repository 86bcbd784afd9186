//! A loaded system: the structure and its FMUs, ready to be run as often and in as many threads as wanted.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::fmu::Fmu;
use crate::package::Package;
use crate::ssd::{Parameter, Structure, parse_set};
use crate::wiring::{Port, Wiring};
use anyhow::{Context, Result, bail};
use fmu_description::{Description, Variable};

/// A start value as text for a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The variable.
    pub port: Port,
    /// A number, `true` or `false`, the name or number of an enumeration item, or a string.
    pub value: String,
}

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
    /// Load a packed system (`.ssp`; of it the structure named `variant`, else the default one), or a `.ssd` whose FMUs lie where it says
    /// or, by file name, in `fmu_dir`.
    pub fn load(path: &Path, variant: Option<&str>, fmu_dir: Option<&Path>) -> Result<Self> {
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
            let port = self.port(&parameter.name);
            let port = port.with_context(|| parameter.origin.clone())?;
            let name = self.variable(port).name.clone();
            let parameter = Parameter { name, ..parameter };
            let component = &mut self.structure.components[port.component];
            check_unit(&component.name, &self.fmus[port.component], &parameter)?;
            component.parameters.push(parameter);
        }
        Ok(())
    }

    /// The connections, resolved.
    pub fn wiring(&self) -> Result<Wiring<'_>> {
        let descriptions: Vec<&Description> = self.fmus.iter().map(|f| &f.description).collect();
        Wiring::new(&self.structure, &descriptions)
    }

    /// The variable `component.variable`, or `variable` where one component alone has it.
    pub fn port(&self, name: &str) -> Result<Port> {
        if let Some((component, variable)) = self.structure.split(name) {
            return self.port_of(component, variable);
        }
        let mut owners = (0..self.fmus.len()).filter_map(|k| self.port_of(k, name).ok());
        match (owners.next(), owners.next()) {
            (Some(only), None) => Ok(only),
            (None, _) => {
                let names = self.structure.components.iter().map(|c| c.name.as_str());
                let names: Vec<_> = names.collect();
                bail!(
                    "no component of the system has a variable `{name}`; its components are {}",
                    names.join(", ")
                )
            }
            _ => bail!(
                "several components have a variable `{name}`; name the component: component.{name}"
            ),
        }
    }

    /// A variable of the component with this index.
    pub fn port_of(&self, component: usize, variable: &str) -> Result<Port> {
        let description = &self.fmus[component].description;
        let found = description.variable(variable);
        found.with_context(|| {
            let name = &self.structure.components[component].name;
            format!("`{name}.{variable}`")
        })?;
        Ok(Port {
            component,
            variable: description.index(variable).unwrap_or_default(),
        })
    }

    /// The elements 1 to `count` of the array `array` of the component with this index.
    pub fn elements(&self, component: usize, array: &str, count: usize) -> Result<Vec<Port>> {
        (1..=count)
            .map(|k| self.port_of(component, &format!("{array}[{k}]")))
            .collect()
    }

    /// What the model description says of a variable.
    pub fn variable(&self, port: Port) -> &Variable {
        &self.fmus[port.component].description.variables[port.variable]
    }

    /// Name of the component that a variable belongs to.
    pub fn component_of(&self, port: Port) -> &str {
        &self.structure.components[port.component].name
    }

    /// `component.variable`.
    pub fn name(&self, port: Port) -> String {
        format!("{}.{}", self.component_of(port), self.variable(port).name)
    }

    /// A start value for a variable named as in [`System::port`].
    pub fn setting(&self, name: &str, value: impl ToString) -> Result<Setting> {
        Ok(Setting {
            port: self.port(name)?,
            value: value.to_string(),
        })
    }

    /// Parse `component.variable=value`, or `variable=value` where one component alone has the variable.
    pub fn parse_setting(&self, text: &str) -> Result<Setting> {
        let parts = text.split_once('=');
        let (name, value) =
            parts.with_context(|| format!("`{text}` is not component.variable=value"))?;
        self.setting(name.trim(), value.trim())
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
