//! Describes FMUs and systems as text and JSON for `cosim info`, variables also for `cosim-page`.
//! The JSON's names are a contract (`docs/master/cosim-options.md`): names are added, none renamed.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::structure::Structure;
use fmi_description::xml::Element;
use fmi_description::{Archive, Capabilities, Description, DescriptionError, Kind, Variable};
use serde_json::{Map, Value, json};

/// An FMU that is described but not loaded.
pub struct DescribedFmu {
    /// File, as the user or the system names it.
    pub file: String,
    /// The JSON of an FMU of FMI 1.0, which is listed rather than read.
    described: Result<Box<Description>, Value>,
    /// Platforms that it has libraries for.
    platforms: Vec<String>,
    has_sources_only: bool,
}

impl DescribedFmu {
    /// Reads the description from an opened archive, whatever its interfaces and version are.
    pub fn from_archive(file: String, mut archive: Archive) -> anyhow::Result<Self> {
        let text = archive.description_text()?;
        let described = match Description::parse_any(&text) {
            Err(DescriptionError::Version { version, .. }) if version.trim().starts_with("1.") => {
                Err(fmi_1_json(&Element::parse(
                    &text,
                    "modelDescription.xml",
                    "fmiModelDescription",
                )?))
            }
            read => Ok(Box::new(read?)),
        };
        let names = archive.names();
        let libraries = names.filter_map(|name| name.strip_prefix("binaries/")?.split_once('/'));
        let platforms = BTreeSet::from_iter(libraries.map(|(platform, _)| platform.to_string()));
        Ok(Self {
            file,
            described,
            has_sources_only: archive.has_sources_only(),
            platforms: platforms.into_iter().collect(),
        })
    }
}

/// Abilities of an FMU: name in JSON, name in text, and whether the FMU has it.
#[rustfmt::skip]
fn abilities(c: &Capabilities) -> [(&'static str, &'static str, bool); 9] {
    let derivatives = c.output_derivative_order > 0;
    [
        ("variable_step", "variable step", c.variable_step),
        ("interpolates_inputs", "interpolates inputs", c.interpolates_inputs),
        ("output_derivatives", "derivatives of outputs", derivatives),
        ("saves_state", "saves its state", c.saves_state),
        ("serializes_state", "state as bytes", c.serializes_state),
        ("directional_derivatives", "directional derivatives", c.directional_derivatives),
        ("event_mode", "Event Mode", c.event_mode),
        ("needs_execution_tool", "needs its tool", c.needs_execution_tool),
        ("only_once_per_process", "only one instance in a process", c.only_once),
    ]
}

/// An FMU of FMI 1.0 as JSON, without its file: names, version, interface.
fn fmi_1_json(root: &Element) -> Value {
    let interface = match root.child("Implementation") {
        Some(_) => "Co-Simulation",
        None => "Model Exchange",
    };
    let variables = root.all_in("ModelVariables");
    let variables =
        variables.map(|v| json!({"name": v.text("name"), "causality": v.text("causality")}));
    json!({
        "kind": "fmu", "fmi": root.text("fmiVersion"), "model": root.text("modelName"), "version": root.text("version"),
        "tool": root.text("generationTool"), "identifier": root.text("modelIdentifier"), "token": root.text("guid"),
        "interfaces": [interface], "capabilities": {}, "default_experiment": {}, "units": [], "variables": variables.collect::<Value>(),
        "remarks": ["FMI 1.0 is listed only; FMI 2.0 and 3.0 can be run"],
    })
}

/// An FMU as JSON.
pub fn fmu_json(fmu: &DescribedFmu) -> Value {
    let d = match &fmu.described {
        Ok(description) => description,
        Err(json) => {
            let mut json = json.clone();
            json["file"] = fmu.file.clone().into();
            json["platforms"] = json!(fmu.platforms);
            json["sources_only"] = fmu.has_sources_only.into();
            return json;
        }
    };
    let e = &d.default_experiment;
    let abilities = abilities(&d.capabilities);
    let abilities = abilities.map(|(name, _, has)| (name.to_string(), json!(has)));
    let unit = |u: &fmi_description::Unit| json!({"name": u.name, "factor": u.factor, "offset": u.offset, "exponents": u.exponents});
    let remarks = d.remarks.iter().map(ToString::to_string);
    json!({
        "file": fmu.file, "kind": "fmu", "fmi": d.fmi.to_string(), "model": d.model, "version": d.version, "tool": d.tool,
        "identifier": d.identifier, "token": d.guid, "platforms": fmu.platforms, "sources_only": fmu.has_sources_only,
        "interfaces": d.interfaces,
        "capabilities": Map::from_iter(abilities),
        "default_experiment": {"start": e.start, "stop": e.stop, "step": e.step, "tolerance": e.tolerance},
        "units": d.units.iter().map(unit).collect::<Value>(),
        "remarks": remarks.collect::<Value>(),
        "variables": d.variables.iter().map(|v| variable_json(d, v)).collect::<Value>(),
    })
}

/// A variable as JSON.
pub fn variable_json(d: &Description, v: &Variable) -> Value {
    let mut starts: Vec<Value> = v.start.iter().map(|text| start_json(v, text)).collect();
    let start = match starts.len() {
        0 | 1 => starts.pop().unwrap_or_default(),
        _ => starts.into(),
    };
    let items = v.items().iter();
    let items = items.map(|item| json!({"name": item.name, "value": item.value}));
    let is_enumeration = matches!(v.kind, Kind::Enumeration(_));
    let items = is_enumeration.then(|| items.collect::<Value>());
    let depends = depends_on(d, v).flatten();
    json!({
        "name": v.name, "causality": camel_case(&v.causality), "variability": camel_case(&v.variability), "type": v.kind.name(),
        "dimensions": v.dimensions, "unit": v.unit, "display_unit": v.display_unit, "start": start, "min": v.min, "max": v.max, "nominal": v.nominal,
        "items": items, "depends_on": depends, "description": v.description,
    })
}

fn start_json(v: &Variable, text: &str) -> Value {
    let text = text.trim();
    match v.kind {
        Kind::Real => text.parse::<f64>().map_or(text.into(), Value::from),
        Kind::Integer | Kind::Enumeration(_) => {
            text.parse::<i64>().map_or(text.into(), Value::from)
        }
        Kind::Boolean => (text == "true" || text == "1").into(),
        _ => text.into(),
    }
}

/// The inputs that an output depends on directly: None if the variable is no output, Some(None) if
/// the dependencies are not declared.
fn depends_on<'a>(d: &'a Description, v: &Variable) -> Option<Option<Vec<&'a str>>> {
    let is_output = v.causality == fmi_description::Causality::Output;
    let index = d.index(&v.name).filter(|_| is_output)?;
    let inputs = d.declared_feedthrough(index, false);
    let name = |k: &usize| d.variables[*k].name.as_str();
    Some(inputs.map(|inputs| inputs.iter().map(name).collect()))
}

/// The name of an enum variant, spelt as in FMI files.
fn camel_case(name: &dyn std::fmt::Debug) -> String {
    let mut text = format!("{name:?}");
    text[..1].make_ascii_lowercase();
    text
}

/// A system and its FMUs as JSON.
pub fn system_json(file: &str, s: &Structure, fmus: &[DescribedFmu]) -> Value {
    let dotted = |end: &(String, String)| format!("{}.{}", end.0, end.1);
    let components = s.components.iter();
    let components = components.map(|c| json!({"name": c.name, "source": c.source}));
    let connections = s.connections.iter();
    let connections = connections.map(|c| json!({"from": dotted(&c.start), "to": dotted(&c.end)}));
    let inputs = s.inputs.iter().map(|i| {
        let to: Value = i.ends.iter().map(|(end, _)| dotted(end)).collect();
        json!({"name": i.name, "unit": i.unit.as_ref().map(|u| &u.name), "to": to})
    });
    let outputs = s.outputs.iter();
    let outputs = outputs.map(|o| json!({"name": o.name, "from": dotted(&o.start)}));
    json!({
        "file": file, "kind": "system", "name": s.name, "start": s.start_time, "stop": s.stop_time, "step": s.step,
        "components": components.collect::<Value>(), "connections": connections.collect::<Value>(),
        "inputs": inputs.collect::<Value>(), "outputs": outputs.collect::<Value>(),
        "fmus": fmus.iter().map(fmu_json).collect::<Value>(),
    })
}

/// A system and its FMUs as text.
pub fn system(file: &str, s: &Structure, fmus: &[DescribedFmu]) -> String {
    let mut text = format!("{file}: system {}\n", s.name);
    for c in &s.components {
        let _ = writeln!(text, "  component {}: {}", c.name, c.source);
    }
    for input in &s.inputs {
        let _ = writeln!(text, "  input {}", input.name);
    }
    for o in &s.outputs {
        let _ = writeln!(text, "  output {}: {}.{}", o.name, o.start.0, o.start.1);
    }
    for connection in &s.connections {
        let _ = writeln!(text, "  connection {connection}");
    }
    fmus.iter().for_each(|f| text += &fmu(f));
    text
}

/// The platforms of an FMU as text.
fn platforms(fmu: &DescribedFmu) -> String {
    let platforms: Vec<&str> = fmu.platforms.iter().map(String::as_str).collect();
    match fmu.has_sources_only {
        true => "none (C sources only)".into(),
        false => listed(&platforms),
    }
}

/// An FMU as text: interfaces, platforms, abilities, default experiment, variables.
pub fn fmu(fmu: &DescribedFmu) -> String {
    let d = match &fmu.described {
        Ok(description) => description,
        Err(json) => {
            let text = |key: &str| json[key].as_str().unwrap_or_default().to_string();
            let [interface, remark] =
                ["interfaces", "remarks"].map(|key| json[key][0].as_str().unwrap_or_default());
            return format!(
                "{}: {}, FMI {}\n  interfaces: {interface}\n  platforms: {}\n  remark: {remark}\n",
                fmu.file,
                text("model"),
                text("fmi"),
                platforms(fmu)
            );
        }
    };
    let mut text = format!("{}: {}, FMI {}", fmu.file, d.model, d.fmi);
    if !d.tool.is_empty() {
        text += &format!(", made by {}", d.tool);
    }
    text.push('\n');
    let mut line = |l: String| text += &(l + "\n");
    line(format!("  interfaces: {}", listed(&d.interfaces)));
    line(format!("  platforms: {}", platforms(fmu)));
    let has = abilities(&d.capabilities);
    let has: Vec<&str> = has.iter().filter(|a| a.2).map(|a| a.1).collect();
    line(format!("  abilities: {}", listed(&has)));
    let e = &d.default_experiment;
    let times = [("start", e.start), ("stop", e.stop), ("step", e.step)].into_iter();
    let times = times.filter_map(|(name, t)| Some(format!("{name} {} s", t?)));
    let times: Vec<String> = times.collect();
    if !times.is_empty() {
        line(format!("  default experiment: {}", times.join(", ")));
    }
    for remark in &d.remarks {
        line(format!("  remark: {remark}"));
    }
    for v in &d.variables {
        line(variable(d, v));
    }
    text
}

fn listed(items: &[&str]) -> String {
    match items.is_empty() {
        true => "none".into(),
        false => items.join(", "),
    }
}

fn variable(description: &Description, v: &Variable) -> String {
    let (causality, variability) = (camel_case(&v.causality), camel_case(&v.variability));
    let mut text = format!("  {}: {causality}, {variability} {}", v.name, v.kind.name());
    if !v.dimensions.is_empty() {
        let _ = write!(text, " {:?}", v.dimensions);
    }
    if let Some(unit) = &v.unit {
        let _ = write!(text, ", {unit}");
    }
    if let Some(start) = v.start_of(0) {
        let _ = write!(text, ", start {start}");
    }
    if v.min.or(v.max).is_some() {
        let [min, max] = [v.min, v.max].map(|b| b.map_or("…".to_string(), |b| b.to_string()));
        let _ = write!(text, ", {min} to {max}");
    }
    match depends_on(description, v) {
        Some(None) => text.push_str(", dependencies not declared"),
        Some(Some(names)) if !names.is_empty() => {
            let _ = write!(text, ", depends at once on {}", names.join(", "));
        }
        _ => {}
    }
    if !v.description.is_empty() {
        let _ = write!(text, ": {}", v.description);
    }
    text
}
