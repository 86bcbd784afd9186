//! A loaded system: the structure and its FMUs. Programs, Python and pages load it once and run it
//! as often, and in as many threads, as they like.

mod alarms;
mod default_step;
mod integration;
mod names;
mod sizes;
mod values;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::{Causality, Description, Variable, Version};
use system_structure::ParameterMapping;

use crate::fmu::{Fmu, FmuWish};
use crate::structure::package::{FmuPlace, Package, read, read_text};
use crate::structure::renaming::rename;
use crate::structure::{self, Alarm, Component, FmuUse, Structure, arrays};
use crate::wiring::{Port, Wiring};

pub use default_step::DefaultStep;
pub(crate) use integration::method_name;
pub(crate) use names::Names;
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
    /// What it was made of, if FMUs have structural parameters.
    pub(crate) unresolved: Option<Arc<Unresolved>>,
    /// Why its wiring does not fit the sizes of arrays.
    pub(crate) misfit: Option<String>,
}

/// A system before what depends on the sizes of arrays is resolved.
pub(crate) struct Unresolved {
    structure: Structure,
    /// FMUs with the sizes that they declare.
    fmus: Vec<Arc<Fmu>>,
    /// Components, mappings of their names, and the files of these.
    mappings: Vec<(usize, ParameterMapping, String)>,
    /// Components whose FMUs are given instead of the structure's.
    replaced: Vec<String>,
    /// Connections that are given as texts, `a.y=b.u`.
    connections: Vec<String>,
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
        Self::from_package(
            package,
            variant,
            place,
            replaced,
            mappings,
            &FmuUse::default(),
            loaded,
        )
    }

    /// As [`System::load`], from an open package; `options` say how components use their FMUs.
    /// `loaded` caches its FMUs, by their names in the structures.
    pub fn from_package(
        package: &mut Package,
        variant: Option<&str>,
        place: &FmuPlace,
        replaced: &[(String, PathBuf)],
        mappings: &[(String, PathBuf)],
        options: &FmuUse,
        loaded: &mut BTreeMap<String, Arc<Fmu>>,
    ) -> Result<Self> {
        let path = package.path().to_path_buf();
        let structure = structure::osp::read(package, variant, place, replaced);
        let mut structure = structure.with_context(|| format!("`{}`", path.display()))?;
        let is_unknown = |(name, _): &&(String, _)| structure.component(name).is_none();
        if let Some((unknown, _)) = replaced.iter().find(is_unknown) {
            bail!("an FMU is given for the component `{unknown}`, which the system does not have");
        }
        structure.choose(options)?;
        let given: HashMap<&String, &PathBuf> =
            replaced.iter().map(|(c, file)| (c, file)).collect();
        let mut fmus = Vec::new();
        for c in &structure.components {
            let own = given.get(&c.name);
            let source = own.map_or(c.source.clone(), |file| file.display().to_string());
            let wanted = structure.wanted(&c.name);
            let key = match wanted == FmuWish::default() {
                true => source.clone(),
                false => format!("{source} ({wanted:?})"),
            };
            let fmu = match loaded.get(&key) {
                Some(fmu) => fmu.clone(),
                None => {
                    let bytes = match own {
                        Some(file) => read(file),
                        None => place.read(&source, package),
                    };
                    let context = || format!("FMU of component `{}`", c.name);
                    let fmu = Fmu::load_as(&source, bytes.with_context(context)?, wanted)?;
                    if let (None, FmuPlace::Structure { .. }) = (own, place) {
                        let counted = package.count(&source, fmu.unpacked_size);
                        counted.with_context(context)?;
                    }
                    loaded.insert(key, fmu.clone());
                    fmu
                }
            };
            fmus.push(fmu);
        }
        if !structure.has_start {
            structure.start_time = earliest_start(&fmus);
        }
        let read = mappings
            .iter()
            .map(|(name, file)| read_mapping(&structure, name, file));
        Self::assemble(
            path,
            Unresolved {
                mappings: read.collect::<Result<_>>()?,
                replaced: replaced.iter().map(|(name, _)| name.clone()).collect(),
                connections: Vec::new(),
                structure,
                fmus,
            },
        )
    }

    /// Resolves what depends on the sizes of arrays: mappings, connections, values and alarms.
    fn resolve(&mut self, unresolved: &Unresolved) -> Result<()> {
        for (k, mapping, file) in &unresolved.mappings {
            let context = || format!("mapping `{file}`");
            let description = &self.fmus[*k].description;
            for entry in &mapping.entries {
                let found = description.variable(&entry.target);
                found.with_context(context)?;
            }
            let renamed = rename(&mut self.structure, *k, mapping, description);
            renamed.with_context(context)?;
        }
        arrays::resolve(&mut self.structure, &self.fmus)?;
        for text in &unresolved.connections {
            let connected = self.connect(text);
            connected.with_context(|| format!("--connect {text}"))?;
        }
        self.find_alarms(|name| {
            unresolved
                .replaced
                .iter()
                .any(|component| component == name)
        })?;
        self.take_means();
        self.fit_values()?;
        self.check_units()
    }

    /// A system of FMUs without a structure: `FILE`, a component named after the file, or
    /// `NAME=FILE`; `connections` are written `a.y=b.u`, and `options` say how components use their
    /// FMUs.
    pub fn from_fmus(files: &[PathBuf], connections: &[String], options: &FmuUse) -> Result<Self> {
        let files = files.iter().map(|file| named_file(file)).collect();
        Self::from_files(files, connections, options, |file| read(Path::new(file)))
    }

    /// As [`System::from_fmus`], from names and files; `options` say how components use their FMUs, and
    /// `read` reads a file once for each use. A component without a name has the identifier of its
    /// FMU, which mostly is the name of its file.
    pub fn from_files(
        files: Vec<(String, String)>,
        connections: &[String],
        options: &FmuUse,
        mut read: impl FnMut(&str) -> Result<Vec<u8>>,
    ) -> Result<Self> {
        let mut structure = Structure::default();
        let mut fmus: Vec<Arc<Fmu>> = Vec::new();
        let path = files.first().map(|(_, file)| PathBuf::from(file));
        let named = files.iter().map(|(name, source)| Component {
            name: name.clone(),
            source: source.clone(),
            connectors: Vec::new(),
            parameters: Vec::new(),
        });
        structure.components = named.collect();
        structure.choose(options)?;
        structure.components.clear();
        for (name, source) in files {
            if structure.component(&name).is_some() {
                bail!("two FMUs are named `{name}`; give them names: a={source} b={source}");
            }
            let wanted = structure.wanted(&name);
            let fits = |fmu: &&Arc<Fmu>| fmu.file == source && fmu.wanted == wanted;
            let fmu = match fmus.iter().find(fits) {
                Some(fmu) => fmu.clone(),
                None => Fmu::load_as(&source, read(&source)?, wanted)?,
            };
            let name = match name.is_empty() {
                true => fmu.description.identifier.clone(),
                false => name,
            };
            structure.components.push(Component {
                name,
                source,
                connectors: Vec::new(),
                parameters: Vec::new(),
            });
            fmus.push(fmu);
        }
        structure.start_time = earliest_start(&fmus);
        structure.stop_time = Some(latest_stop(&fmus, structure.start_time));
        let unresolved = Unresolved {
            mappings: Vec::new(),
            replaced: Vec::new(),
            connections: connections.to_vec(),
            structure,
            fmus,
        };
        Self::assemble(path.unwrap_or_default(), unresolved)
    }

    /// Connect an output with an input that nothing drives, or whole arrays: `a.y=b.u`.
    fn connect(&mut self, text: &str) -> Result<()> {
        let ends = text.match_indices('=');
        let mut ends = ends.map(|(k, _)| (text[..k].trim(), text[k + 1..].trim()));
        let known = ends.find(|(start, end)| self.is_known(start) && self.is_known(end));
        let ends = known.or_else(|| self.split_name(text));
        let (start, end) = ends.context("it must be a.y=b.u")?;
        let (starts, ends) = (self.ports(start)?, self.ports(end)?);
        let [from, to] = [starts.len(), ends.len()];
        ensure!(
            from == to,
            "`{start}` has {from} elements, and `{end}` has {to}"
        );
        for (start, end) in starts.into_iter().zip(ends) {
            let end_of = |port: Port| {
                let component = self.component_of(port).to_string();
                (component, self.variable(port).name.clone())
            };
            let (start, end) = (end_of(start), end_of(end));
            let mut others = self.structure.connections.iter();
            if let Some(other) = others.find(|c| c.end == end) {
                bail!("this input is driven already, {other}");
            }
            self.structure.connect(start, end);
        }
        Ok(())
    }

    /// The latest default stop time of the FMUs, s, else 1 s after the start.
    pub fn preferred_stop(&self, start: f64) -> f64 {
        latest_stop(&self.fmus, start)
    }

    /// The connections, resolved.
    pub fn wiring(&self) -> Result<Wiring<'_>> {
        self.check_fit()?;
        let descriptions: Vec<&Description> = self.fmus.iter().map(|f| &f.description).collect();
        Wiring::new(&self.structure, &descriptions)
    }

    /// Lets outputs of the component `name` be read again after inputs were set, although they do
    /// not declare on which inputs they depend.
    ///
    /// # Errors
    /// There is no such component, or that would change nothing.
    pub fn allow_feedthrough(&mut self, name: &str) -> Result<()> {
        let k = self.structure.component(name);
        let k = k.context("the system has no component of this name")?;
        ensure!(
            self.can_read_again(k),
            "its FMU of FMI 3.0 has no Event Mode, without which no output can be read again"
        );
        let description = &self.fmus[k].description;
        let mut variables = description.variables.iter().enumerate();
        let lacks = |(i, v): (usize, &Variable)| {
            v.causality == Causality::Output && description.declared_feedthrough(i, false).is_none()
        };
        ensure!(
            variables.any(lacks),
            "its outputs declare on which inputs they depend, and are read again anyway"
        );
        self.structure.feedthrough.push(name.to_string());
        Ok(())
    }

    /// Whether an FMU allows that outputs are read again after inputs were set.
    fn can_read_again(&self, component: usize) -> bool {
        let description = &self.fmus[component].description;
        description.fmi == Version::Fmi2 || description.capabilities.event_mode
    }

    /// Connected outputs that staged schedules read only right after the step, before inputs are
    /// set: those of FMUs that allow to read them again, else those of the others.
    pub fn read_once(&self, by_choice: bool) -> Result<Vec<String>> {
        let wiring = self.wiring()?;
        // Where clocks are connected, clocked values are read at their ticks, too.
        let at_ticks = |p: &Port| !wiring.clocks.is_empty() && wiring.passes_at_ticks(*p);
        let outputs = wiring.links.iter().map(|link| link.from);
        let outputs = outputs.filter(|p| !at_ticks(p));
        let own = outputs.filter(|p| self.can_read_again(p.component) == by_choice);
        let mut ports: Vec<Port> = own.filter(|p| wiring.is_read_once(*p)).collect();
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

/// The component `name` and the mapping in `file` for it, with the name of the file.
fn read_mapping(
    structure: &Structure,
    name: &str,
    file: &Path,
) -> Result<(usize, ParameterMapping, String)> {
    let text = read_text(file).context("mapping")?;
    let file = file.display().to_string();
    let mapping = ParameterMapping::parse(&text, &file)?;
    let Some(k) = structure.component(name) else {
        bail!("a mapping is given for the component `{name}`, which the system does not have");
    };
    Ok((k, mapping, file))
}

/// The earliest start time that an FMU declares, s, else 0.
fn earliest_start(fmus: &[Arc<Fmu>]) -> f64 {
    let experiments = fmus.iter().map(|fmu| &fmu.description.default_experiment);
    let starts = experiments.filter_map(|e| e.start);
    starts.reduce(f64::min).unwrap_or(0.0)
}

/// The latest stop time after `start` that an FMU declares, else 1 s after it, s.
fn latest_stop(fmus: &[Arc<Fmu>], start: f64) -> f64 {
    let experiments = fmus.iter().map(|fmu| &fmu.description.default_experiment);
    let stops = experiments.filter_map(|preferred| preferred.stop);
    let latest = stops.filter(|stop| stop.is_finite() && *stop > start);
    latest.reduce(f64::max).unwrap_or(start + 1.0)
}

/// Splits `NAME=FILE` before the longest file that there is, else at the first `=`.
pub(crate) fn split_file(text: &str) -> Option<(&str, &str)> {
    let splits = text.match_indices('=');
    let mut splits = splits.map(|(k, _)| (&text[..k], &text[k + 1..]));
    let first = splits.clone().next()?;
    let found = splits.find(|(_, file)| Path::new(file).is_file());
    Some(found.unwrap_or(first))
}

/// Name and file of `NAME=FILE`, or of a file, which names a component by itself.
pub(crate) fn named_file(path: &Path) -> (String, String) {
    let text = path.display().to_string();
    match split_file(&text).filter(|(name, _)| !name.is_empty() && !path.is_file()) {
        Some((name, file)) => (name.to_string(), file.to_string()),
        None => {
            let stem = path.file_stem().unwrap_or_default();
            (stem.to_string_lossy().into_owned(), text)
        }
    }
}
