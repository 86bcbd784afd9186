//! Flattens a system structure for `System` and `cosim info`: nested systems, signal dictionaries
//! and structures in other files become one list of components and connections ([`Structure`]).

use std::collections::HashMap;

use anyhow::{Context, Result, anyhow, bail, ensure};
use fmi_description::Interface;
use system_structure::{
    Annotation, Connection as Wire, Connector, DataType, Direction, Element, End, Implementation,
    Kind, SignalDictionary, Sourced, System, SystemStructure, Transformation,
};

use super::alarm::Alarm;
use super::bond::PowerBond;
use super::flat::{Component, Connection, Hop, Parameter, Structure};
use super::package::{Base, DEFAULT};
use super::values::{Files, binding_values};
use super::ways::{Key, join, resolve};

/// Type of the annotation of a component whose outputs may be read again after its inputs were set.
const FEEDTHROUGH: &str = "io.github.hdrm-fmu.feedthrough";

/// Type of the annotation that gives a component a step of its own: `<Rate step="0.25e-3"/>`, s.
const RATE: &str = "io.github.hdrm-fmu.rate";

/// Type of the annotation of a component that lives in a process of its own.
const PROCESS: &str = "io.github.hdrm-fmu.process";

/// Type of the annotation of a connection whose input is the sum of all its connections: `<Sum/>`.
const SUM: &str = "io.github.hdrm-fmu.sum";

/// Deepest nesting of files; stops a file that names itself.
const MAX_DEPTH: usize = 16;

/// Most elements, connectors, connections and values of a system. A few small files that each name
/// the next one ten times would otherwise make a system without end.
const MAX_PARTS: usize = if cfg!(test) { 10_000 } else { 5_000_000 };

/// Most bytes of the files that a structure names, counted as often as they are named.
const MAX_TEXT: usize = 1 << 29;

/// Read the text of the system structure `file`; `files` reads the files that it names.
pub fn read(text: &str, file: &str, files: &mut Files<'_>) -> Result<Structure> {
    let read = SystemStructure::parse(text, file)?;
    let mut bytes = 0;
    let mut files = |name: &str| {
        let text = files(name)?;
        bytes += text.len();
        ensure!(
            bytes <= MAX_TEXT,
            "`{name}`: with it the files that systems in systems name have more than {MAX_TEXT} bytes together, each counted as often as it is named"
        );
        Ok(text)
    };
    let mut flattening = Flattening {
        structure: Structure {
            name: read.system.name.clone(),
            start_time: read.default_experiment.start.unwrap_or(0.0),
            has_start: read.default_experiment.start.is_some(),
            stop_time: read.default_experiment.stop,
            step: base_step(&read)?,
            ..Structure::default()
        },
        files: &mut files,
        parts: Vec::new(),
        driven: HashMap::new(),
        values: Vec::new(),
        references: HashMap::new(),
        count: 0,
    };
    let base = Base {
        folder: "",
        is_packed: false,
    };
    let place = SourceFile {
        file,
        base,
        depth: 0,
    };
    flattening.system(&read.system, "", &place, &[])?;
    let Flattening {
        mut structure,
        parts,
        values,
        ..
    } = flattening;
    resolve(&mut structure, &parts, values, &read.system)?;
    Ok(structure)
}

/// The communication step that an annotation of the Open Simulation Platform requests.
fn base_step(read: &SystemStructure) -> Result<Option<f64>> {
    for annotation in &read.default_experiment.annotations {
        let algorithm = annotation.content.child("Algorithm");
        if let Some(fixed) = algorithm.and_then(|a| a.child("FixedStepAlgorithm")) {
            return Ok(fixed.finite("baseStepSize")?);
        }
    }
    Ok(None)
}

/// The file that is being read.
struct SourceFile<'a> {
    file: &'a str,
    base: Base<'a>,
    depth: usize,
}

/// The connectors of the elements of a system, and its own, by the names of the element (None for
/// its own) and of the connector.
type Connectors<'a> = HashMap<(Option<&'a str>, &'a str), &'a Connector>;

fn connectors(system: &System) -> Connectors<'_> {
    let elements = system.elements.iter();
    let elements = elements.map(|e| (Some(e.name()), e.connectors()));
    let mut found = HashMap::new();
    for (owner, own) in elements.chain([(None, &system.connectors[..])]) {
        for connector in own {
            found.entry((owner, &*connector.name)).or_insert(connector);
        }
    }
    found
}

struct Flattening<'a> {
    structure: Structure,
    files: &'a mut Files<'a>,
    /// Connections of all systems, directed from their sources to their sinks.
    parts: Vec<Connection>,
    /// The place in `parts` of the connection to a connector.
    driven: HashMap<Key, usize>,
    /// Values with full names, in the order in which they are applied.
    values: Vec<Parameter>,
    /// Path of the dictionary, by the path of the element that refers to it.
    references: HashMap<String, String>,
    /// Elements, connectors, connections and values so far.
    count: usize,
}

impl Flattening<'_> {
    /// Add a system with the path `path`; `around` are the names and paths of the dictionaries of
    /// the enclosing systems.
    fn system(
        &mut self,
        system: &System,
        path: &str,
        place: &SourceFile,
        around: &[(String, String)],
    ) -> Result<()> {
        let connectors = connectors(system);
        let parts = system.elements.len() + system.connections.len() + connectors.len();
        self.count(1 + parts, place)?;
        let mut dictionaries = around.to_vec();
        for (name, dictionary) in &system.dictionaries {
            if let Sourced::File(source) = dictionary {
                let text = (self.files)(&place.base.file(source)?)?;
                SignalDictionary::parse(&text, source)?;
            }
            // No path of an element begins with this character.
            dictionaries.push((name.clone(), format!("\0{}", join(path, name))));
        }
        for element in &system.elements {
            let inner = join(path, element.name());
            match element {
                Element::System(nested) => self.system(nested, &inner, place, &dictionaries)?,
                Element::Component(component) => self.component(component, &inner, place)?,
                Element::Dictionary(reference) => {
                    let wanted = &reference.dictionary;
                    let Some((_, found)) = dictionaries.iter().rfind(|(name, _)| name == wanted)
                    else {
                        bail!(
                            "`{}`: `{inner}` refers to the signal dictionary `{wanted}`, which no system around it has",
                            place.file
                        );
                    };
                    self.references.insert(inner, found.clone());
                }
            }
        }
        for wire in &system.connections {
            let place = format!("`{}`, line {}", place.file, wire.line);
            let part = self.connection((system, &connectors), path, wire, &place);
            let part = part.with_context(|| place.clone())?;
            self.driven.insert(part.end.clone(), self.parts.len());
            self.parts.push(part);
        }
        self.alarms(&system.annotations, path, place.file)?;
        let owner = format!("system `{}`", system.name);
        self.bind(&system.bindings, &owner, path, place)
    }

    fn component(
        &mut self,
        component: &system_structure::Component,
        path: &str,
        place: &SourceFile,
    ) -> Result<()> {
        let source = place.base.file(&component.source);
        let source = source.with_context(|| format!("component `{path}`"))?;
        let file = match component.kind {
            Kind::Fmu => {
                if component.annotations.iter().any(|a| a.kind == FEEDTHROUGH) {
                    self.structure.feedthrough.push(path.to_string());
                }
                for annotation in component.annotations.iter().filter(|a| a.kind == RATE) {
                    if let Some(rate) = annotation.content.child("Rate") {
                        let step = rate.required("step")?;
                        let step: Option<f64> = step.trim().parse().ok().filter(|s| *s > 0.0);
                        let step = step.with_context(|| {
                            rate.error("step of a Rate must be a time greater than 0, s".into())
                        })?;
                        self.structure.rates.push((path.to_string(), step));
                    }
                }
                if component.annotations.iter().any(|a| a.kind == PROCESS) {
                    self.structure.isolated.push(path.to_string());
                }
                if let Some(implementation) = component.implementation {
                    let interface = match implementation {
                        Implementation::CoSimulation => Interface::CoSimulation,
                        Implementation::ModelExchange => Interface::ModelExchange,
                    };
                    (self.structure.interfaces).push((path.to_string(), interface));
                }
                self.structure.components.push(Component {
                    name: path.to_string(),
                    source,
                    connectors: component.connectors.clone(),
                    parameters: Vec::new(),
                });
                None
            }
            Kind::Structure => Some(source),
            Kind::Package => Some(format!("{source}/{DEFAULT}")),
        };
        if let Some(file) = file {
            if place.depth == MAX_DEPTH {
                bail!("`{file}`: files of systems in systems are nested deeper than {MAX_DEPTH}");
            }
            let text = (self.files)(&file).with_context(|| format!("component `{path}`"))?;
            let read = SystemStructure::parse(&text, &file)?;
            let base = Base {
                folder: &file[..file.rfind('/').map_or(0, |slash| slash + 1)],
                is_packed: place.base.is_packed || component.kind == Kind::Package,
            };
            let inner = SourceFile {
                file: &file,
                base,
                depth: place.depth + 1,
            };
            self.system(&read.system, path, &inner, &[])?;
        }
        self.alarms(&component.annotations, path, place.file)?;
        let owner = format!("component `{path}`");
        self.bind(&component.bindings, &owner, path, place)
    }

    /// Add the alarms among annotations, with their full names.
    fn alarms(&mut self, annotations: &[Annotation], path: &str, file: &str) -> Result<()> {
        for mut alarm in Alarm::read_all(annotations, file)? {
            alarm.name = join(path, &alarm.name);
            self.structure.alarms.push(alarm);
        }
        Ok(())
    }

    /// Add the values of bindings, with their full names.
    fn bind(
        &mut self,
        bindings: &[system_structure::Binding],
        owner: &str,
        path: &str,
        place: &SourceFile,
    ) -> Result<()> {
        for binding in bindings {
            let values = binding_values(binding, owner, place.base, self.files)?;
            self.count(values.len(), place)?;
            for mut parameter in values {
                parameter.name = join(path, &parameter.name);
                self.values.push(parameter);
            }
        }
        Ok(())
    }

    /// Counts parts of the system; an error if they are too many.
    fn count(&mut self, parts: usize, place: &SourceFile) -> Result<()> {
        self.count += parts;
        ensure!(
            self.count <= MAX_PARTS,
            "`{}`: with it the system has more than {MAX_PARTS} elements, connectors, connections and values, systems in other files included",
            place.file
        );
        Ok(())
    }

    /// A connection, directed as its connectors require.
    fn connection(
        &self,
        system: (&System, &Connectors),
        path: &str,
        wire: &Wire,
        place: &str,
    ) -> Result<Connection> {
        let [(start, start_gives), (end, end_gives)] =
            [find(system, &wire.start)?, find(system, &wire.end)?];
        let misused = |end: &End, connector: &Connector, used: &str| {
            let declared = connector.direction.name();
            anyhow!(
                "connector `{end}` is declared as {declared}, but a connection uses it as {used}"
            )
        };
        match (start_gives, end_gives) {
            (Some(true), Some(true)) => return Err(misused(&wire.end, end, "input")),
            (Some(false), Some(false)) => return Err(misused(&wire.start, start, "output")),
            _ => {}
        }
        let is_turned = start_gives == Some(false) || end_gives == Some(true);
        let name = format!("connection {} -> {}", wire.start, wire.end);
        let mut ends = [(start, &wire.start), (end, &wire.end)];
        let whole = |t| matches!(t, DataType::Integer | DataType::Enumeration);
        let data_type = start.data_type.or(end.data_type);
        if let (Some(a), Some(b)) = (start.data_type, end.data_type)
            && a != b
            && !(whole(a) && whole(b))
        {
            bail!(
                "{name}: the types differ, {} and {}; both ends must be of the same type",
                a.name(),
                b.name()
            );
        }
        let named = [&wire.start, &wire.end].map(End::to_string);
        check_mime_types(&name, named, [&start.mime_type, &end.mime_type])?;
        if let (Some(transformation), Some(data_type)) = (&wire.transformation, data_type) {
            let (element, fitting) = match transformation {
                Transformation::Linear { .. } => ("a LinearTransformation", DataType::Real),
                Transformation::Booleans(_) => {
                    ("a BooleanMappingTransformation", DataType::Boolean)
                }
                Transformation::Integers(_) => {
                    ("an IntegerMappingTransformation", DataType::Integer)
                }
                Transformation::Items(_) => {
                    ("an EnumerationMappingTransformation", DataType::Enumeration)
                }
            };
            let is_item = fitting == DataType::Integer && data_type == DataType::Enumeration;
            ensure!(
                data_type == fitting || is_item,
                "{name}: {element} is for {} connectors; these are {}",
                fitting.name(),
                data_type.name()
            );
        }
        let bond = PowerBond::read(&wire.annotations)?;
        let is_term = wire.annotations.iter().any(|a| a.kind == SUM);
        if is_turned {
            ends.reverse();
        }
        let [(first, start), (last, end)] = ends;
        let [start, end] = [start, end].map(|end| self.key(path, end));
        if let Some(other) = self.driven.get(&end)
            && !(is_term && self.parts[*other].is_term)
        {
            let other = &self.parts[*other];
            let [input, first, second] =
                [&end, &other.start, &start].map(|(a, b)| format!("{a}.{b}"));
            bail!("input {input} is driven twice, by {first} and by {second}");
        }
        let is_parameter = |connector: &Connector| {
            use Direction::{CalculatedParameter, Parameter};
            matches!(connector.direction, Parameter | CalculatedParameter)
        };
        let is_initial = is_parameter(first) || is_parameter(last);
        ensure!(
            !is_term || self.structure.component(&end.0).is_some() && !is_initial && bond.is_none(),
            "{name}: a sum is for inputs of components, without parameters and power bonds"
        );
        Ok(Connection {
            start,
            end,
            way: vec![Hop {
                transformation: wire.transformation.clone(),
                keeps_units: wire.keeps_units,
                unit: last.unit.clone(),
            }],
            unit: first.unit.clone(),
            is_initial,
            bond,
            is_term,
            place: place.to_string(),
        })
    }

    /// The path and name of the connector at an end of a connection in the system with this path.
    fn key(&self, path: &str, end: &End) -> Key {
        let owner = match &end.element {
            Some(element) => join(path, element),
            None => path.to_string(),
        };
        let owner = self.references.get(&owner).cloned().unwrap_or(owner);
        (owner, end.connector.clone())
    }
}

/// Refuses a connection between bytes that are declared to be of different kinds. Case, blanks and
/// quotes do not count.
pub(crate) fn check_mime_types(
    connection: &str,
    [start, end]: [String; 2],
    declared: [&Option<String>; 2],
) -> Result<()> {
    let [Some(a), Some(b)] = declared else {
        return Ok(());
    };
    let meant = |text: &str| text.to_lowercase().replace(['"', ' ', '\t'], "");
    ensure!(
        meant(a) == meant(b),
        "{connection}: `{start}` has the MIME type `{a}`, `{end}` has `{b}`; both ends must have the same"
    );
    Ok(())
}

/// The connector at one end of a connection, and whether it gives values to the system, rather than
/// takes them; None where both are possible.
fn find<'s>(
    (system, connectors): (&'s System, &Connectors<'s>),
    end: &End,
) -> Result<(&'s Connector, Option<bool>)> {
    let element = end.element.as_deref();
    let Some(found) = connectors.get(&(element, &*end.connector)) else {
        let mut elements = system.elements.iter();
        let owner = match element {
            None => format!("system `{}`", system.name),
            Some(name) => format!("component `{name}`"),
        };
        if let Some(name) = element.filter(|name| elements.all(|e| e.name() != *name)) {
            bail!("a connection names the component `{name}`, which the system does not have");
        }
        bail!(
            "{owner} declares no connector `{}`, but a connection uses it",
            end.connector
        );
    };
    let gives = match found.direction {
        Direction::Output | Direction::CalculatedParameter => Some(element.is_some()),
        Direction::Input | Direction::Parameter => Some(element.is_none()),
        Direction::Either => None,
    };
    Ok((found, gives))
}
