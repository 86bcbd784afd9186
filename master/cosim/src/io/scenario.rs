//! Reads scenarios in the format of libcosim (`--scenario`): timed events that override a variable,
//! add a bias, ramp it, or reset it. They become [`Faults`] with a start and an end.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::Causality;
use serde_json::{Map, Value};

use crate::exchange::faults::{Effect, Fault, Faults, effect};
use crate::schedule::Stepping;
use crate::structure::package::read;
use crate::structure::system::{Names, System};
use crate::wiring::Port;
use fmi_import::digits::short;

/// Keys that are ignored: comments, and keys of older versions of the format that repeat the model
/// description.
const IGNORED: [&str; 4] = ["id", "description", "type", "causality"];
const DEFAULTS: [&str; 3] = ["model", "variable", "action"];

/// An event of the scenario.
struct Event {
    /// Since the start of the run, s.
    time: f64,
    port: Port,
    /// None resets the variable: from now on it is not altered.
    effect: Option<Effect>,
}

/// Add the events of the scenario in `file` to `faults`. Returns a line about it for the verdict.
pub fn add(
    file: &Path,
    system: &System,
    stepping: Stepping,
    faults: &mut Faults,
) -> Result<String> {
    let context = || format!("scenario `{}`", file.display());
    let is_yaml = file
        .extension()
        .is_some_and(|e| ["yml", "yaml"].iter().any(|y| e.eq_ignore_ascii_case(y)));
    let bytes = read(file).context("scenario")?;
    let scenario = match is_yaml {
        true => yaml(&bytes),
        false => serde_json::from_slice(&bytes).context("it is no JSON"),
    };
    let scenario = scenario.with_context(context)?;
    let (events, end) = read_events(&scenario, system).with_context(context)?;
    let last = events.iter().map(|e| e.time).fold(0.0, f64::max);
    // As in libcosim the scenario ends at `end`, but not before the step after the last event.
    let steps = |time: f64| (time / stepping.step - 1e-6).ceil();
    let over = steps(end.unwrap_or(0.0)).max(steps(last) + 1.0);
    let over = stepping.start + over * stepping.step;
    // Times of the events of each variable; they are not below 0, so their bits are in order.
    let times = events
        .iter()
        .map(|event| (event.port, event.time.to_bits()));
    let times: BTreeSet<(Port, u64)> = times.collect();
    for event in &events {
        let Some(effect) = event.effect else { continue };
        let (port, time) = (event.port, event.time.to_bits());
        let mut later = times.range((port, time + 1)..=(port, u64::MAX));
        let next = later.next().map(|(_, time)| f64::from_bits(*time));
        let until = next.map(|time| stepping.start + time);
        faults.list.push(Fault {
            port: event.port,
            effect,
            from: stepping.start + event.time,
            until: until.unwrap_or(over),
            is_event: true,
        });
    }
    let why = match end {
        Some(end) if stepping.start + end >= over - 1e-6 * stepping.step => "",
        Some(_) => ", a step after its last event, which is later than its `end`",
        None => ", a step after its last event, because it has no `end`",
    };
    Ok(format!(
        "{}: {} events; what it alters ends at t = {} s{why}",
        context(),
        events.len(),
        short(over)
    ))
}

#[cfg(feature = "yaml")]
fn yaml(bytes: &[u8]) -> Result<Value> {
    serde_saphyr::from_slice(bytes).context("it is no YAML")
}

#[cfg(not(feature = "yaml"))]
fn yaml(_: &[u8]) -> Result<Value> {
    bail!("this program reads scenarios as JSON, not as YAML; the keys are the same")
}

/// The events, and the end of the scenario, s.
fn read_events(scenario: &Value, system: &System) -> Result<(Vec<Event>, Option<f64>)> {
    let scenario = object(scenario, "it")?;
    check_keys(scenario, &["events", "defaults", "end"])?;
    let nothing = Map::new();
    let defaults = match scenario.get("defaults") {
        Some(defaults) => object(defaults, "`defaults`")?,
        None => &nothing,
    };
    check_keys(defaults, &DEFAULTS).context("`defaults`")?;
    let end = scenario.get("end").map(|end| time(end, "`end`"));
    let list = scenario.get("events").and_then(Value::as_array);
    let list = list.context("it must have a list `events`")?;
    let names = Names::new(system);
    let (mut events, mut places) = (Vec::new(), HashMap::new());
    for (k, event) in (1..).zip(list) {
        let event = read_event(event, defaults, &names).with_context(|| format!("event {k}"))?;
        // Of two events of a variable at the same time the later one counts.
        let before = places.insert((event.port, event.time.to_bits()), events.len());
        before.into_iter().for_each(|k: usize| events[k] = None);
        events.push(Some(event));
    }
    let events: Vec<Event> = events.into_iter().flatten().collect();
    ensure!(!events.is_empty(), "it has no events");
    Ok((events, end.transpose()?))
}

fn read_event(event: &Value, defaults: &Map<String, Value>, names: &Names) -> Result<Event> {
    let system = names.system;
    let event = object(event, "it")?;
    check_keys(
        event,
        &["time", "model", "variable", "action", "value", "duration"],
    )?;
    let at = event.get("time").context("it has no `time`")?;
    let at = time(at, "`time`")?;
    let word = |key: &str| {
        let value = event.get(key).or_else(|| defaults.get(key));
        value
            .map(|v| {
                v.as_str()
                    .with_context(|| format!("`{key}` = {v}: it must be a text"))
            })
            .transpose()
    };
    let variable =
        word("variable")?.context("it has no `variable`, nor have the `defaults` one")?;
    let port = match word("model")? {
        Some(model) => {
            let component = names.component(model).with_context(|| {
                let all = system.structure.component_names();
                format!("`model` = `{model}`: the system has no component of this name, only {all}")
            })?;
            system.port_of(component, variable)?
        }
        None => names.port(variable)?,
    };
    let (v, name) = (system.variable(port), system.name(port));
    use Causality::{CalculatedParameter, Input, Output, Parameter, StructuralParameter};
    ensure!(
        matches!(v.causality, Input | Output | CalculatedParameter) || v.is_tunable(),
        match v.causality {
            Parameter | StructuralParameter => format!(
                "`{name}` is a parameter that is fixed after initialization; a start value is given by --set"
            ),
            other => format!(
                "`{name}` is {}; a scenario alters inputs, outputs and parameters",
                format!("{other:?}").to_lowercase()
            ),
        }
    );
    let action = word("action")?.context("it has no `action`, nor have the `defaults` one")?;
    let value = || {
        let value = event.get("value");
        let value = value.with_context(|| format!("the action `{action}` needs a `value`"))?;
        Ok(match value {
            Value::String(text) => text.clone(),
            Value::Number(_) | Value::Bool(_) => value.to_string(),
            other => bail!("`value` = {other}: it must be a number, true, false or a text"),
        })
    };
    let effect = match action {
        "reset" => None,
        "override" | "bias" => Some(effect(system, port, action, &value()?)?),
        "ramp" => {
            ensure!(
                v.kind == fmi_description::Kind::Real,
                "the action `ramp` is for Reals; `{name}` is of type {}",
                v.kind.name()
            );
            let Effect::Override(to) = effect(system, port, "override", &value()?)? else {
                bail!("`{name}` takes no number");
            };
            let over = event.get("duration");
            let over = over.context("the action `ramp` needs a `duration`, s")?;
            let over = time(over, "`duration`")?;
            ensure!(over > 0.0, "`duration` = {over}: it must be greater than 0");
            Some(Effect::Ramp(to, over))
        }
        other => bail!("`action` = `{other}`: it must be override, bias, ramp or reset"),
    };
    Ok(Event {
        time: at,
        port,
        effect,
    })
}

fn object<'a>(value: &'a Value, what: &str) -> Result<&'a Map<String, Value>> {
    value
        .as_object()
        .with_context(|| format!("{what} must be an object, {{ ... }}"))
}

/// Refuse unknown keys.
fn check_keys(object: &Map<String, Value>, keys: &[&str]) -> Result<()> {
    let is_unknown =
        |key: &&String| !keys.contains(&key.as_str()) && !IGNORED.contains(&key.as_str());
    match object.keys().find(is_unknown) {
        Some(key) => bail!(
            "the key `{key}` is not known; it must be one of {}",
            keys.join(", ")
        ),
        None => Ok(()),
    }
}

/// A time since the start, s.
fn time(value: &Value, what: &str) -> Result<f64> {
    // Adding 0 makes -0 a 0.
    let time = value
        .as_f64()
        .filter(|time| *time >= 0.0)
        .map(|time| time + 0.0);
    time.with_context(|| format!("{what} = {value}: it must be a number, s, not below 0"))
}
