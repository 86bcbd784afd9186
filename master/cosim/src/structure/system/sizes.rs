//! Sizes of arrays that structural parameters of FMI 3.0 give: a `System` is made anew with the
//! values that its structure, parameter sets and the user give them, so that names of elements,
//! connections and start values are those of arrays of these sizes.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail, ensure};
use fmi_description::{Access, Causality};
use fmi_import::value::Value;
use system_structure::ParameterMapping;

use super::System;
use super::values::convert;
use crate::fmu::Fmu;
use crate::structure::package::Package;
use crate::structure::{Hop, Parameter, Structure};
use crate::wiring::Port;

/// A system before what depends on the sizes of arrays is resolved.
pub(crate) struct Unresolved {
    pub structure: Structure,
    /// FMUs with the sizes that they declare.
    pub fmus: Vec<Arc<Fmu>>,
    /// Components, mappings of their names, and the files of these.
    pub mappings: Vec<(usize, ParameterMapping, String)>,
    /// Components whose FMUs are given instead of the structure's.
    pub replaced: Vec<String>,
    /// Connections that are given as texts, `a.y=b.u`.
    pub connections: Vec<String>,
}

/// Values of structural parameters, each with where it comes from.
type Sizes = BTreeMap<Port, (String, String)>;

impl System {
    /// The system with the sizes that its structure gives. If wiring and values do not fit them, it
    /// may yet get others, so that is no error before the wiring is asked for.
    pub(super) fn assemble(path: PathBuf, mut unresolved: Unresolved) -> Result<Self> {
        let fmus = unresolved.fmus.clone();
        if !fmus.iter().any(|fmu| fmu.is_configurable()) {
            let structure = std::mem::take(&mut unresolved.structure);
            let mut system = Self::unwired(path, structure, fmus);
            system.resolve(&unresolved)?;
            return Ok(system);
        }
        let mut system = Self::unwired(path, Structure::default(), fmus);
        system.unresolved = Some(Arc::new(unresolved));
        system.resize(&[])
    }

    fn unwired(path: PathBuf, structure: Structure, fmus: Vec<Arc<Fmu>>) -> Self {
        Self {
            path,
            structure,
            fmus,
            alarms: Vec::new(),
            unresolved: None,
            misfit: None,
        }
    }

    /// The system as it was loaded, with the sizes that these parameter sets and then the start
    /// values `given`, `name=value`, say. All other values are left to
    /// [`apply_set`](Self::apply_set) and [`settings`](Self::settings).
    pub fn with_sizes(self, sets: &[PathBuf], given: &[String]) -> Result<Self> {
        let mut package = match self.unresolved {
            Some(_) if !sets.is_empty() => Package::open(&self.path)?,
            _ => return self.with_sizes_from(None, &[], given),
        };
        self.with_sizes_from(Some(&mut package), sets, given)
    }

    /// As [`with_sizes`](Self::with_sizes), with the packed system open already.
    pub fn with_sizes_from(
        self,
        package: Option<&mut Package>,
        sets: &[PathBuf],
        given: &[String],
    ) -> Result<Self> {
        if self.unresolved.is_none() {
            return Ok(self);
        }
        let mut texts = Vec::new();
        if let Some(package) = package {
            for set in sets {
                let all = self.parameter_set(package, set)?.into_iter();
                texts.extend(all.map(|p| format!("{}={}", p.name, p.value)));
            }
        }
        texts.extend_from_slice(given);
        self.resize(&texts)
    }

    /// An error if the wiring does not fit the sizes of arrays.
    pub fn check_fit(&self) -> Result<()> {
        self.misfit.as_ref().map_or(Ok(()), |text| bail!("{text}"))
    }

    /// Names a component of a system without a structure.
    pub fn rename_component(&mut self, k: usize, name: &str) {
        self.structure.components[k].name = name.into();
        if let Some(unresolved) = self.unresolved.as_mut().and_then(Arc::get_mut) {
            unresolved.structure.components[k].name = name.into();
        }
    }

    fn resize(self, given: &[String]) -> Result<Self> {
        let Some(unresolved) = &self.unresolved else {
            return Ok(self);
        };
        let (structure, fmus) = (unresolved.structure.clone(), unresolved.fmus.clone());
        let mut system = Self::unwired(self.path, structure, fmus);
        let sizes = system.sizes(unresolved, given)?;
        system.configure(&sizes)?;
        let resolved = system.resolve(unresolved).and_then(|()| system.refuse_wires());
        system.misfit = resolved.err().map(|error| format!("{error:#}"));
        system.unresolved = self.unresolved;
        Ok(system)
    }

    /// The values that are given for structural parameters. What names nothing is left to those
    /// who read it later, in the system with these sizes.
    fn sizes(&self, unresolved: &Unresolved, given: &[String]) -> Result<Sizes> {
        let mut sizes = Sizes::new();
        let is_structural =
            |port: &Port| self.variable(*port).causality == Causality::StructuralParameter;
        for (component, c) in unresolved.structure.components.iter().enumerate() {
            let fmu = &self.fmus[component];
            for parameter in c.parameters.iter().filter(|_| fmu.is_configurable()) {
                let parameter = mapped(parameter, component, unresolved);
                let Some(variable) = fmu.description.index(&parameter.name) else {
                    continue;
                };
                let port = Port {
                    component,
                    variable,
                };
                if is_structural(&port) {
                    let Parameter { value, origin, .. } = convert(&c.name, fmu, parameter)?;
                    sizes.insert(port, (value, origin));
                }
            }
        }
        for text in given {
            let settings = self.split_name(text);
            let settings = settings.and_then(|(name, value)| self.settings(name, value).ok());
            for setting in settings.into_iter().flatten() {
                if is_structural(&setting.port) {
                    sizes.insert(setting.port, (setting.value, text.clone()));
                }
            }
        }
        Ok(sizes)
    }

    /// Gives the FMUs other sizes; components with the same FMU and sizes share them.
    fn configure(&mut self, sizes: &Sizes) -> Result<()> {
        let mut values: BTreeMap<usize, BTreeMap<String, Value>> = BTreeMap::new();
        for (port, (text, origin)) in sizes {
            let v = self.variable(*port);
            let name = self.name(*port);
            let value = Value::parse_for(v, text);
            let value = value.map_err(|unfit| anyhow!("`{name}` = {text} is not {unfit}"));
            let value = value.with_context(|| origin.clone())?;
            if let (Value::Whole(number), Access::UInt64) = (&value, v.access()) {
                let [least, most] = v.bounds();
                // Only a least value of 0 allows arrays without elements.
                let least = if v.min.is_none() { 1.0 } else { least };
                ensure!(
                    (least..=most).contains(&(*number as f64)),
                    "{origin}: `{name}` = {text} must be at least {least}{}",
                    match most.is_finite() {
                        true => format!(" and at most {most}"),
                        false => String::new(),
                    }
                );
            }
            let own = v.start_of(0).and_then(|own| Value::parse(v.access(), own));
            if own.as_ref() != Some(&value) {
                let values = values.entry(port.component).or_default();
                values.insert(v.name.clone(), value);
            }
        }
        let mut made: Vec<(Arc<Fmu>, BTreeMap<String, Value>, Arc<Fmu>)> = Vec::new();
        for (k, values) in values {
            let fmu = self.fmus[k].clone();
            let is_same = |(of, with, _): &&(Arc<Fmu>, BTreeMap<String, Value>, Arc<Fmu>)| {
                Arc::ptr_eq(of, &fmu) && *with == values
            };
            self.fmus[k] = match made.iter().find(is_same) {
                Some((.., configured)) => configured.clone(),
                None => {
                    let configured = fmu.configured(&values).with_context(|| {
                        let given = values.iter().map(|(name, value)| format!("{name} = {value}"));
                        let given = Vec::from_iter(given).join(", ");
                        format!("`{}` with {given}", self.structure.components[k].name)
                    })?;
                    made.push((fmu, values, configured.clone()));
                    configured
                }
            };
        }
        Ok(())
    }

    /// Refuses connections to structural parameters.
    fn refuse_wires(&self) -> Result<()> {
        for connection in &self.structure.connections {
            let (component, name) = &connection.end;
            let k = self.structure.component(component);
            let v = k.and_then(|k| self.fmus[k].description.variable(name).ok());
            ensure!(
                v.is_none_or(|v| v.causality != Causality::StructuralParameter),
                "connection {connection}: sizes of arrays depend on the structural parameter `{component}.{name}`, so it must have its value before the run: give it as a start value"
            );
        }
        Ok(())
    }
}

/// A value under the name that the FMU has for it.
fn mapped(parameter: &Parameter, component: usize, unresolved: &Unresolved) -> Parameter {
    let mut parameter = parameter.clone();
    for (k, mapping, _) in &unresolved.mappings {
        let mut entries = mapping.entries.iter();
        let entry = entries.find(|e| *k == component && e.source == parameter.name);
        if let Some(entry) = entry {
            parameter.name.clone_from(&entry.target);
            parameter.way.push(Hop {
                transformation: entry.transformation.clone(),
                keeps_units: entry.keeps_units,
                unit: None,
            });
        }
    }
    parameter
}
