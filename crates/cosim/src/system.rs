//! A loaded system: the structure and its FMUs, ready to be run as often and in as many threads as
//! wanted.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::arrays;
use crate::fmu::Fmu;
use crate::package::{Package, read};
use crate::renaming::rename;
use crate::structure::{self, Component, Hop, Parameter, Structure, parse_set};
use crate::transformation::{Linear, Transformation, along, conversion, unit_of};
use crate::wiring::{Port, Wiring};
use anyhow::{Context, Result, anyhow, bail};
use fmu_description::{Description, Kind, Variable};
use system_structure::{Connector, DataType, ParameterMapping};

/// Likeness from which on a known name is suggested for an unknown one; 1 is the same name.
const LIKE: f64 = 0.85;

/// A start value as text for a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The variable.
    pub port: Port,
    /// A number, `true` or `false`, the name or number of an enumeration item, or a string.
    pub value: String,
}

/// Where the FMUs of a system lie.
#[derive(Clone, Debug)]
pub enum FmuPlace {
    /// In this folder, by file name.
    Folder(PathBuf),
    /// Where the structure says, else in the first of these folders that has the file.
    Structure {
        /// Further folders.
        else_in: Vec<PathBuf>,
    },
}

/// A system structure with one loaded FMU per component (shared where the source is the same).
#[derive(Clone)]
pub struct System {
    /// Where it came from.
    pub path: PathBuf,
    /// Components and connections.
    pub structure: Structure,
    /// FMU of each component.
    pub fmus: Vec<Arc<Fmu>>,
}

impl System {
    /// Load a packed system (`.ssp`; of it the structure named `variant`, else the default one), or
    /// a `.ssd` with its FMUs from `place`. The components named in `replaced` get the FMU in that
    /// file instead, of whichever version of FMI.
    pub fn load(
        path: &Path,
        variant: Option<&str>,
        place: &FmuPlace,
        replaced: &[(String, PathBuf)],
    ) -> Result<Self> {
        Self::load_renamed(path, variant, place, replaced, &[])
    }

    /// The same where the FMUs of some components have names of their own, by parameter mappings
    /// (`.ssm`): `source` is the name in the structure, `target` that of the FMU.
    pub fn load_renamed(
        path: &Path,
        variant: Option<&str>,
        place: &FmuPlace,
        replaced: &[(String, PathBuf)],
        mappings: &[(String, PathBuf)],
    ) -> Result<Self> {
        Self::of_package(
            &mut Package::open(path)?,
            variant,
            place,
            replaced,
            mappings,
            &mut BTreeMap::new(),
        )
    }

    /// The same of an opened package; `loaded` are FMUs of it that are loaded already, by the names
    /// that structures have for them, and takes up those that are not.
    pub fn of_package(
        package: &mut Package,
        variant: Option<&str>,
        place: &FmuPlace,
        replaced: &[(String, PathBuf)],
        mappings: &[(String, PathBuf)],
        loaded: &mut BTreeMap<String, Arc<Fmu>>,
    ) -> Result<Self> {
        let path = package.path().to_path_buf();
        let text = package.structure(variant)?;
        let name = package.structure_name(variant);
        let structure = structure::read(&text, &name, &mut |source| package.text(source));
        let structure = structure.with_context(|| format!("`{}`", path.display()))?;
        if let Some((unknown, _)) = replaced
            .iter()
            .find(|(name, _)| structure.component(name).is_none())
        {
            bail!("an FMU is given for the component `{unknown}`, which the system does not have");
        }
        let mut fmus = Vec::new();
        for c in &structure.components {
            let own = replaced.iter().rfind(|(name, _)| *name == c.name);
            let source = own.map_or(c.source.clone(), |(_, file)| file.display().to_string());
            let fmu = match loaded.get(&source) {
                Some(fmu) => fmu.clone(),
                None => {
                    let bytes = match own {
                        Some((_, file)) => read(file),
                        None => place.read(&source, package),
                    };
                    let bytes = bytes.with_context(|| format!("FMU of component `{}`", c.name))?;
                    let fmu = Fmu::load(&source, bytes)?;
                    loaded.insert(source, fmu.clone());
                    fmu
                }
            };
            fmus.push(fmu);
        }
        let mut system = Self {
            path,
            structure,
            fmus,
        };
        for (name, file) in mappings {
            let text = String::from_utf8(read(file).context("mapping")?);
            let text = text.with_context(|| format!("`{}` is not UTF-8 text", file.display()))?;
            let mapping = ParameterMapping::parse(&text, &file.display().to_string())?;
            let Some(k) = system.structure.component(name) else {
                bail!(
                    "a mapping is given for the component `{name}`, which the system does not have"
                );
            };
            let description = &system.fmus[k].description;
            for entry in &mapping.entries {
                let found = description.variable(&entry.target);
                found.with_context(|| format!("mapping `{}`", file.display()))?;
            }
            rename(&mut system.structure, k, &mapping, description);
        }
        arrays::resolve(&mut system.structure, &system.fmus)?;
        system.fit_values()?;
        for (c, fmu) in system.structure.components.iter().zip(&system.fmus) {
            for connector in &c.connectors {
                check_unit(&c.name, fmu, connector)?;
            }
        }
        Ok(system)
    }

    /// FMUs without a structure, each a component named after its file; `connections` are written
    /// `a.y=b.u`.
    pub fn of_fmus(files: &[PathBuf], connections: &[String]) -> Result<Self> {
        let mut fmus = Vec::new();
        for file in files {
            fmus.push((file.clone(), read(file)?));
        }
        Self::of_archives(fmus, connections)
    }

    /// The same of the bytes of each file.
    pub fn of_archives(files: Vec<(PathBuf, Vec<u8>)>, connections: &[String]) -> Result<Self> {
        let mut structure = Structure::default();
        let mut fmus: Vec<Arc<Fmu>> = Vec::new();
        let path = files.first().map(|(file, _)| file.clone());
        for (file, bytes) in files {
            let source = file.display().to_string();
            let stem = file.file_stem().unwrap_or_default().to_string_lossy();
            if structure.component(&stem).is_some() {
                bail!("two FMUs are named `{stem}`; a structure can give them names");
            }
            structure.components.push(Component {
                name: stem.into_owned(),
                source: source.clone(),
                connectors: Vec::new(),
                parameters: Vec::new(),
            });
            fmus.push(Fmu::load(&source, bytes)?);
        }
        let experiments = || fmus.iter().map(|fmu| &fmu.description.default_experiment);
        let starts = experiments().filter_map(|e| e.start);
        structure.start_time = starts.reduce(f64::min).unwrap_or(0.0);
        let mut system = Self {
            path: path.unwrap_or_default(),
            structure,
            fmus,
        };
        system.structure.stop_time = Some(system.preferred_stop());
        for text in connections {
            let context = || format!("--connect {text}");
            let ends = text.split_once('=').context("it must be a.y=b.u");
            let (start, end) = ends.with_context(context)?;
            let end_of = |name: &str| {
                let port = system.port(name.trim())?;
                let component = system.component_of(port).to_string();
                anyhow::Ok((component, system.variable(port).name.clone()))
            };
            let (start, end) = (
                end_of(start).with_context(context)?,
                end_of(end).with_context(context)?,
            );
            let mut others = system.structure.connections.iter();
            if let Some(other) = others.find(|c| c.end == end) {
                bail!("--connect {text}: this input is driven already, {other}");
            }
            system.structure.connect(start, end);
        }
        Ok(system)
    }

    /// The latest stop time that an FMU prefers, s, else 1 s after the start.
    pub fn preferred_stop(&self) -> f64 {
        let start = self.structure.start_time;
        let stops = self
            .fmus
            .iter()
            .filter_map(|fmu| fmu.description.default_experiment.stop);
        let latest = stops
            .filter(|stop| stop.is_finite() && *stop > start)
            .reduce(f64::max);
        latest.unwrap_or(start + 1.0)
    }

    /// The communication step that the structure asks for, else the smallest that an FMU prefers,
    /// s, and who it is.
    pub fn preferred_step(&self) -> Option<(f64, String)> {
        if let Some(step) = self.structure.step {
            return Some((step, "the system structure".into()));
        }
        let all = self.structure.components.iter().zip(&self.fmus);
        let steps = all.filter_map(|(c, fmu)| {
            let Description {
                default_experiment: preferred,
                capabilities,
                ..
            } = &fmu.description;
            let step = preferred.step.or(capabilities.internal_step)?;
            (step.is_finite() && step > 0.0).then(|| (step, format!("`{}`", c.name)))
        });
        steps.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Bring the bound values to the units of their variables; those of variables that the FMUs do
    /// not have are passed over, as the standard has it, and noted.
    fn fit_values(&mut self) -> Result<()> {
        let Structure {
            components,
            unmatched,
            ..
        } = &mut self.structure;
        for (component, fmu) in components.iter_mut().zip(&self.fmus) {
            let values = std::mem::take(&mut component.parameters);
            let values = values.into_iter().flat_map(|value| by_element(fmu, value));
            for parameter in values {
                if fmu.description.index(&parameter.name).is_none() {
                    let (name, origin) = (&parameter.name, &parameter.origin);
                    unmatched.push(format!("`{}.{name}` ({origin})", component.name));
                    continue;
                }
                component
                    .parameters
                    .push(fitted(&component.name, fmu, parameter)?);
            }
        }
        Ok(())
    }

    /// Apply a parameter set (`.ssv`) after the values that the structure binds: a file of the
    /// packed system, else one on disk. Its parameters are named `component.variable`, or only by
    /// variable where one component alone has it.
    pub fn apply_set(&mut self, file: &Path) -> Result<()> {
        self.apply_set_of(&mut Package::open(&self.path)?, file)
    }

    /// The same where the packed system is opened already.
    pub fn apply_set_of(&mut self, package: &mut Package, file: &Path) -> Result<()> {
        let name = file.display().to_string();
        let text = if package.holds(&name) {
            package.text(&name)?
        } else {
            let system = self.path.display();
            let hint = || format!("parameter set `{name}` is not in `{system}`, and as a file");
            String::from_utf8(read(file).with_context(hint)?).with_context(hint)?
        };
        for parameter in parse_set(&text, &name)? {
            let port = self.port(&parameter.name);
            let port = port.with_context(|| parameter.origin.clone())?;
            let name = self.variable(port).name.clone();
            let parameter = Parameter { name, ..parameter };
            let component = &mut self.structure.components[port.component];
            let fmu = &self.fmus[port.component];
            component
                .parameters
                .push(fitted(&component.name, fmu, parameter)?);
        }
        Ok(())
    }

    /// The connections, resolved.
    pub fn wiring(&self) -> Result<Wiring<'_>> {
        let descriptions: Vec<&Description> = self.fmus.iter().map(|f| &f.description).collect();
        Wiring::new(&self.structure, &descriptions)
    }

    /// Connected outputs that staged schedules read right after the step, before any input is set.
    pub fn read_once(&self) -> Result<Vec<String>> {
        let wiring = self.wiring()?;
        let outputs = wiring.links.iter().map(|link| link.from);
        let mut ports: Vec<Port> = outputs.filter(|p| wiring.is_read_once(*p)).collect();
        ports.sort();
        ports.dedup();
        Ok(ports.into_iter().map(|port| self.name(port)).collect())
    }

    /// A component whose step may not be varied.
    pub fn fixed_step(&self) -> Option<&str> {
        let mut all = self.structure.components.iter().zip(&self.fmus);
        let fixed = all.find(|(_, fmu)| !fmu.description.capabilities.variable_step);
        fixed.map(|(component, _)| component.name.as_str())
    }

    /// A component whose internal step, s, is fixed and does not fit the communication step, s.
    pub fn uneven_step(&self, step: f64) -> Option<(&str, f64)> {
        let mut all = self.structure.components.iter().zip(&self.fmus);
        all.find_map(|(component, fmu)| {
            let internal = fmu.description.capabilities.internal_step?;
            let parts = step / internal;
            let fits = parts.round() >= 1.0 && (parts - parts.round()).abs() <= 1e-6 * parts;
            (!fits).then_some((component.name.as_str(), internal))
        })
    }

    /// The variable `component.variable`, or `variable` where one component alone has it; the name
    /// of an output of the system is that of the output that it shows.
    pub fn port(&self, name: &str) -> Result<Port> {
        if let Some(output) = self.structure.outputs.iter().find(|o| o.name == name)
            && let Some(component) = self.structure.component(&output.start.0)
        {
            return self.port_of(component, &output.start.1);
        }
        if let Some((component, variable)) = self.structure.split(name) {
            return self.port_of(component, variable);
        }
        let mut owners = (0..self.fmus.len()).filter(|k| self.has(*k, name));
        match (owners.next(), owners.next()) {
            (Some(only), None) => self.port_of(only, name),
            (None, _) => {
                let names = self.structure.components.iter().map(|c| c.name.as_str());
                let names: Vec<_> = names.collect();
                bail!(
                    "no component of the system has a variable `{name}`{}; its components are {}",
                    self.nearest(name),
                    names.join(", ")
                )
            }
            _ => bail!(
                "several components have a variable `{name}`; name the component: component.{name}"
            ),
        }
    }

    fn has(&self, component: usize, variable: &str) -> bool {
        self.fmus[component].description.index(variable).is_some()
    }

    /// The name that is most like an unknown one, as the end of an error text.
    fn nearest(&self, name: &str) -> String {
        let all = self.structure.components.iter().zip(&self.fmus);
        let names = all.flat_map(|(c, fmu)| {
            let variables = fmu.description.variables.iter();
            variables.flat_map(|v| [v.name.clone(), format!("{}.{}", c.name, v.name)])
        });
        let inputs = self.structure.inputs.iter().map(|input| input.name.clone());
        let outputs = self
            .structure
            .outputs
            .iter()
            .map(|output| output.name.clone());
        let names = names.chain(inputs).chain(outputs);
        let rated = names.map(|known| (strsim::jaro_winkler(name, &known), known));
        let best = rated.max_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((likeness, known)) if likeness > LIKE => format!("; did you mean `{known}`?"),
            _ => String::new(),
        }
    }

    /// A variable of the component with this index.
    pub fn port_of(&self, component: usize, variable: &str) -> Result<Port> {
        let description = &self.fmus[component].description;
        let found = description.variable(variable);
        found.with_context(|| {
            let name = format!("{}.{variable}", self.structure.components[component].name);
            format!("`{name}`{}", self.nearest(&name))
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

    /// As [`System::parse_setting`]; of an input of the system the start values of all inputs that
    /// it feeds.
    pub fn parse_settings(&self, text: &str) -> Result<Vec<Setting>> {
        let (name, value) = text.split_once('=').unwrap_or((text, ""));
        let mut inputs = self.structure.inputs.iter();
        let Some(input) = inputs.find(|input| input.name == name.trim()) else {
            return Ok(vec![self.parse_setting(text)?]);
        };
        let mut settings = Vec::new();
        for ((component, variable), way) in &input.ends {
            let port = self.port(&format!("{component}.{variable}"))?;
            let fmu = &self.fmus[port.component];
            let data_type = match self.variable(port).kind {
                Kind::Real => DataType::Real,
                Kind::Boolean => DataType::Boolean,
                Kind::String => DataType::String,
                Kind::Binary => DataType::Binary,
                _ => DataType::Integer,
            };
            let parameter = Parameter {
                name: variable.clone(),
                value: value.trim().to_string(),
                data_type,
                unit: input.unit.clone(),
                way: way.clone(),
                origin: format!("input `{}` of the system", input.name),
            };
            let value = fitted(component, fmu, parameter)?.value;
            settings.push(Setting { port, value });
        }
        Ok(settings)
    }

    /// Parse `component.variable=value`, or `variable=value` where one component alone has the
    /// variable.
    pub fn parse_setting(&self, text: &str) -> Result<Setting> {
        let parts = text.split_once('=');
        let (name, value) =
            parts.with_context(|| format!("`{text}` is not component.variable=value"))?;
        self.setting(name.trim(), value.trim())
    }
}

impl FmuPlace {
    /// The FMU that a structure names. A source in a folder of the resources,
    /// `resources/fmi3/Emla.fmu`, is looked for in that folder too.
    pub fn read(&self, source: &str, package: &mut Package) -> Result<Vec<u8>> {
        let name = Path::new(source).file_name().unwrap_or_default();
        let inner = Path::new(source).strip_prefix("resources").ok();
        let names = |folder: &PathBuf| {
            let inner = inner.map(|inner| folder.join(inner));
            inner
                .into_iter()
                .chain([folder.join(name)])
                .collect::<Vec<_>>()
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

/// A declared unit must be that of the FMU, where the FMU tells one.
fn check_unit(component: &str, fmu: &Fmu, connector: &Connector) -> Result<()> {
    let index = fmu.description.index(&connector.name);
    let unit = index.and_then(|k| unit_of(&fmu.description, &fmu.description.variables[k]));
    if let (Some(declared), Some(unit)) = (&connector.unit, unit)
        && conversion(declared, &unit) != Some(Linear::NONE)
    {
        bail!(
            "connector `{component}.{}` is declared in {}, but its FMU has it in {}",
            connector.name,
            declared.name,
            unit.name
        );
    }
    Ok(())
}

/// The values of an array, one for each element; any other value as it is.
fn by_element(fmu: &Fmu, parameter: Parameter) -> Vec<Parameter> {
    let names = match fmu.description.index(&parameter.name) {
        Some(_) => Vec::new(),
        None => arrays::elements(fmu, &parameter.name),
    };
    let values: Vec<String> = (parameter.value.split_whitespace())
        .map(str::to_string)
        .collect();
    if names.is_empty() || names.len() != values.len() {
        return vec![parameter];
    }
    let pairs = names.into_iter().zip(values);
    let each = pairs.map(|(name, value)| Parameter {
        name,
        value,
        ..parameter.clone()
    });
    each.collect()
}

/// A value of the type of its variable, in the variable's unit. An Integer may be given for a Real
/// and for an enumeration.
fn fitted(component: &str, fmu: &Fmu, parameter: Parameter) -> Result<Parameter> {
    let Parameter {
        name,
        value,
        data_type,
        unit,
        way,
        origin,
    } = &parameter;
    let variable = fmu.description.variable(name);
    let variable = variable.with_context(|| format!("{origin}: component `{component}`"))?;
    let expected = variable.kind.name();
    let fits = data_type.name() == expected
        || *data_type == DataType::Integer && ["Real", "Enumeration"].contains(&expected);
    if !fits {
        bail!(
            "{origin}: `{component}.{name}` = {value}: given as {}, but its FMU has it as {expected}",
            data_type.name()
        );
    }
    let mut way = match way.is_empty() {
        true => vec![Hop::default()],
        false => way.clone(),
    };
    if let Some(last) = way.last_mut() {
        last.unit = unit_of(&fmu.description, variable);
    }
    let ends = [None, Some(variable)];
    let transformation = along(&way, unit.clone(), ends, &mut None).map_err(|_| {
        anyhow!(
            "{origin}: `{component}.{name}` = {value} {}: it must be in the unit of the variable, {}, or in one that is defined with the \
             same base units",
            unit.as_ref().map_or("", |u| &u.name),
            variable.unit.as_deref().unwrap_or("none")
        )
    })?;
    if transformation == Transformation::NONE {
        return Ok(parameter);
    }
    if let (Transformation::Map(_), Ok(number)) = (&transformation, value.trim().parse()) {
        return Ok(Parameter {
            value: transformation.of_whole(number).to_string(),
            way: Vec::new(),
            ..parameter
        });
    }
    let number: f64 = match (value.trim(), value.trim().parse()) {
        ("true", _) => 1.0,
        ("false", _) => 0.0,
        (_, Ok(number)) => number,
        _ => bail!("{origin}: `{component}.{name}` = {value}: it is not a number"),
    };
    let number = transformation.of(number);
    let value = match data_type {
        DataType::Boolean => (number != 0.0).to_string(),
        _ => number.to_string(),
    };
    Ok(Parameter {
        value,
        way: Vec::new(),
        ..parameter
    })
}
