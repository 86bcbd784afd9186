//! Sizes of arrays that structural parameters of FMI 3.0 give: a `System` is made anew with the
//! values that its structure, parameter sets and the user give them, so that names of elements,
//! connections and start values are those of arrays of these sizes.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail, ensure};
use fmi_description::{Access, Causality};
use fmi_import::value::Value;

use super::values::convert;
use super::{System, Unresolved};
use crate::io::numbers;
use crate::structure::Structure;
use crate::structure::package::Package;
use crate::structure::renaming::rename;
use crate::wiring::Port;

impl System {
    /// The system with the sizes that its structure gives. If wiring and values do not fit them, it
    /// may yet get others, so that is no error before the wiring is asked for.
    pub(super) fn assemble(path: PathBuf, mut unresolved: Unresolved) -> Result<Self> {
        unresolved.structure.check_limits(&unresolved.fmus)?;
        let mut system = Self {
            path,
            structure: Structure::default(),
            fmus: unresolved.fmus.clone(),
            alarms: Vec::new(),
            unresolved: None,
            misfit: None,
        };
        if system.fmus.iter().any(|fmu| fmu.is_configurable()) {
            system.unresolved = Some(Arc::new(unresolved));
            return system.with_sizes(None, &[], &[]);
        }
        system.structure = std::mem::take(&mut unresolved.structure);
        system.resolve(&unresolved)?;
        Ok(system)
    }

    /// The system as it was loaded, with the sizes that these parameter sets, of the package if it
    /// is open, and then the start values `given`, `name=value`, say. All other values are left to
    /// [`apply_set`](Self::apply_set) and [`settings`](Self::settings).
    pub fn with_sizes(
        mut self,
        package: Option<&mut Package>,
        sets: &[PathBuf],
        given: &[String],
    ) -> Result<Self> {
        let Some(unresolved) = self.unresolved.clone() else {
            return Ok(self);
        };
        let mut texts = Vec::new();
        if !sets.is_empty() {
            let mut opened = None;
            let package = match package {
                Some(package) => package,
                None => opened.insert(Package::open(&self.path)?),
            };
            for set in sets {
                let all = self.parameter_set(package, set)?.into_iter();
                texts.extend(all.map(|p| format!("{}={}", p.name, p.value)));
            }
        }
        texts.extend_from_slice(given);
        self.structure.clone_from(&unresolved.structure);
        self.fmus.clone_from(&unresolved.fmus);
        self.alarms.clear();
        self.configure(&unresolved, &texts)?;
        let resolved = self.resolve(&unresolved);
        let resolved = resolved.and_then(|()| self.refuse_wires());
        self.misfit = resolved.err().map(|error| format!("{error:#}"));
        Ok(self)
    }

    /// An error if the wiring does not fit the sizes of arrays.
    pub fn check_fit(&self) -> Result<()> {
        self.misfit.as_ref().map_or(Ok(()), |text| bail!("{text}"))
    }

    /// Gives the FMUs the values of structural parameters that the structure binds and that `given`
    /// says. What names nothing is left to those who read it later, in the system with these sizes.
    fn configure(&mut self, unresolved: &Unresolved, given: &[String]) -> Result<()> {
        // The last value counts, each with where it comes from.
        let mut values: BTreeMap<Port, (String, String)> = BTreeMap::new();
        let mut named = unresolved.structure.clone();
        for (k, mapping, _) in &unresolved.mappings {
            rename(&mut named, *k, mapping, &self.fmus[*k].description)?;
        }
        for (k, c) in named.components.into_iter().enumerate() {
            for parameter in c.parameters {
                if self.fmus[k].is_structural(&parameter.name) {
                    let port = self.port_of(k, &parameter.name)?;
                    let bound = convert(&c.name, &self.fmus[k], parameter)?;
                    values.insert(port, (bound.value, bound.origin));
                }
            }
        }
        for text in given {
            let parts = self
                .split_name(text)
                .filter(|(name, _)| self.is_known(name));
            let settings = parts.and_then(|(name, value)| self.settings(name, value).ok());
            let mut settings = settings.unwrap_or_default();
            settings.retain(|s| self.variable(s.port).causality == Causality::StructuralParameter);
            let all = settings.into_iter();
            values.extend(all.map(|s| (s.port, (s.value, text.clone()))));
        }
        let mut configurations: BTreeMap<usize, BTreeMap<String, Value>> = BTreeMap::new();
        for (port, (text, origin)) in values {
            let mut v = self.variable(port).clone();
            // Only a declared least value of 0 allows arrays without elements.
            if v.access() == Access::UInt64 {
                v.min = v.min.or(Some(1.0));
            }
            let context = || format!("{origin}: `{}`", self.name(port));
            if v.access().is_number() {
                numbers::number(&v, &text).with_context(context)?;
            }
            let value = Value::parse_for(&v, &text);
            let value = value.map_err(|unfit| anyhow!("`{text}` is not {unfit}"));
            let value = value.with_context(context)?;
            if v.start_of(0).and_then(|own| Value::parse(v.access(), own)) != Some(value.clone()) {
                let configuration = configurations.entry(port.component).or_default();
                configuration.insert(v.name, value);
            }
        }
        for (k, configuration) in configurations {
            let configured = self.fmus[k].configured(&configuration);
            let name = &self.structure.components[k].name;
            self.fmus[k] = configured.with_context(|| format!("`{name}`: {configuration:?}"))?;
        }
        Ok(())
    }

    /// Refuses connections to structural parameters.
    fn refuse_wires(&self) -> Result<()> {
        for connection in &self.structure.connections {
            let (component, name) = &connection.end;
            let k = self.structure.component(component);
            ensure!(
                !k.is_some_and(|k| self.fmus[k].is_structural(name)),
                "connection {connection}: sizes of arrays depend on the structural parameter `{component}.{name}`, so it must have its value before the run: give it as a start value"
            );
        }
        Ok(())
    }
}
