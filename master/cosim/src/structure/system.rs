//! A loaded system: the structure and its FMUs. Programs, Python and pages load it once and run it
//! as often, and in as many threads, as they like.

mod alarms;
mod names;
mod values;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use fmi_description::Description;
use system_structure::ParameterMapping;

use crate::fmu::Fmu;
use crate::structure::package::{FmuPlace, Package, read, read_text};
use crate::structure::renaming::rename;
use crate::structure::{self, Alarm, Component, Structure, arrays};
use crate::wiring::{Port, Wiring};

pub use values::Setting;

/// A system structure with one loaded FMU per component (shared where the source is the same).
#[derive(Clone)]
pub struct System {
    /// File that it was loaded from.
    pub path: PathBuf,
    /// Components and connections.
    pub structure: Structure,
    /// FMU of each component.
    pub fmus: Vec<Arc<Fmu>>,
    /// Alarms with their variables, and the bounds as numbers.
    pub(crate) alarms: Vec<(Port, f64, Alarm)>,
}

impl System {
    /// Load a packed system (`.ssp`; of it the structure named `variant`, else the default one), or
    /// a `.ssd`, with its FMUs from `place`. `replaced` gives components other FMU files, of any
    /// version of FMI. `mappings` gives components parameter mappings (`.ssm`) for FMUs with other
    /// variable names: `source` is the name in the structure, `target` that of the FMU.
    pub fn load(
        path: &Path,
        variant: Option<&str>,
        place: &FmuPlace,
        replaced: &[(String, PathBuf)],
        mappings: &[(String, PathBuf)],
    ) -> Result<Self> {
        let (package, loaded) = (&mut Package::open(path)?, &mut BTreeMap::new());
        Self::from_package(package, variant, place, replaced, mappings, loaded)
    }

    /// As [`System::load`], from an open package. `loaded` caches its FMUs, by their names in the
    /// structures.
    pub fn from_package(
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
        let is_unknown = |(name, _): &&(String, _)| structure.component(name).is_none();
        if let Some((unknown, _)) = replaced.iter().find(is_unknown) {
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
            alarms: Vec::new(),
        };
        for (name, file) in mappings {
            system.map(name, file)?;
        }
        arrays::resolve(&mut system.structure, &system.fmus)?;
        system.find_alarms(|name| replaced.iter().any(|(component, _)| component == name))?;
        system.fit_values()?;
        system.check_units()?;
        Ok(system)
    }

    /// Rename the variables of the component `name` by the mapping in `file`.
    fn map(&mut self, name: &str, file: &Path) -> Result<()> {
        let text = read_text(file).context("mapping")?;
        let mapping = ParameterMapping::parse(&text, &file.display().to_string())?;
        let Some(k) = self.structure.component(name) else {
            bail!("a mapping is given for the component `{name}`, which the system does not have");
        };
        let description = &self.fmus[k].description;
        for entry in &mapping.entries {
            let found = description.variable(&entry.target);
            found.with_context(|| format!("mapping `{}`", file.display()))?;
        }
        rename(&mut self.structure, k, &mapping, description);
        Ok(())
    }

    /// A system of FMUs without a structure, each a component named after its file; `connections`
    /// are written `a.y=b.u`.
    pub fn from_fmus(files: &[PathBuf], connections: &[String]) -> Result<Self> {
        let read = files.iter().map(|file| Ok((file.clone(), read(file)?)));
        Self::from_archives(read.collect::<Result<_>>()?, connections)
    }

    /// As [`System::from_fmus`], from the bytes of the files.
    pub fn from_archives(files: Vec<(PathBuf, Vec<u8>)>, connections: &[String]) -> Result<Self> {
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
            alarms: Vec::new(),
        };
        system.structure.stop_time = Some(system.preferred_stop());
        for text in connections {
            let context = || format!("--connect {text}");
            let ends = text.split_once('=').context("it must be a.y=b.u");
            let (start, end) = ends.with_context(context)?;
            let end_of = |name: &str| {
                let port = system.port(name.trim()).with_context(context)?;
                let component = system.component_of(port).to_string();
                anyhow::Ok((component, system.variable(port).name.clone()))
            };
            let (start, end) = (end_of(start)?, end_of(end)?);
            let mut others = system.structure.connections.iter();
            if let Some(other) = others.find(|c| c.end == end) {
                bail!("--connect {text}: this input is driven already, {other}");
            }
            system.structure.connect(start, end);
        }
        Ok(system)
    }

    /// The latest default stop time of the FMUs, s, else 1 s after the start.
    pub fn preferred_stop(&self) -> f64 {
        let start = self.structure.start_time;
        let experiments = self
            .fmus
            .iter()
            .map(|fmu| &fmu.description.default_experiment);
        let stops = experiments.filter_map(|preferred| preferred.stop);
        let latest = stops.filter(|stop| stop.is_finite() && *stop > start);
        latest.reduce(f64::max).unwrap_or(start + 1.0)
    }

    /// The communication step, s, that the structure requests, else the smallest that an FMU
    /// prefers; and which of them it is.
    pub fn preferred_step(&self) -> Option<(f64, String)> {
        if let Some(step) = self.structure.step {
            return Some((step, "the system structure".into()));
        }
        let all = self.structure.components.iter().zip(&self.fmus);
        let steps = all.filter_map(|(c, fmu)| {
            let (d, preferred) = (&fmu.description, &fmu.description.default_experiment);
            let step = preferred.step.or(d.capabilities.internal_step)?;
            (step.is_finite() && step > 0.0).then(|| (step, format!("`{}`", c.name)))
        });
        steps.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The connections, resolved.
    pub fn wiring(&self) -> Result<Wiring<'_>> {
        let descriptions: Vec<&Description> = self.fmus.iter().map(|f| &f.description).collect();
        Wiring::new(&self.structure, &descriptions)
    }

    /// Connected outputs that staged schedules read only right after the step, before inputs are
    /// set.
    pub fn read_once(&self) -> Result<Vec<String>> {
        let wiring = self.wiring()?;
        let outputs = wiring.links.iter().map(|link| link.from);
        let mut ports: Vec<Port> = outputs.filter(|p| wiring.is_read_once(*p)).collect();
        ports.sort();
        ports.dedup();
        Ok(ports.into_iter().map(|port| self.name(port)).collect())
    }

    /// A component that cannot vary its communication step.
    pub fn fixed_step(&self) -> Option<&str> {
        let mut all = self.structure.components.iter().zip(&self.fmus);
        let fixed = all.find(|(_, fmu)| !fmu.description.capabilities.variable_step);
        fixed.map(|(component, _)| component.name.as_str())
    }

    /// A component with a fixed internal step, s, of which the communication step, s, is no
    /// multiple.
    pub fn uneven_step(&self, step: f64) -> Option<(&str, f64)> {
        let mut all = self.structure.components.iter().zip(&self.fmus);
        all.find_map(|(component, fmu)| {
            let internal = fmu.description.capabilities.internal_step?;
            let parts = step / internal;
            let fits = parts.round() >= 1.0 && (parts - parts.round()).abs() <= 1e-6 * parts;
            (!fits).then_some((component.name.as_str(), internal))
        })
    }
}
