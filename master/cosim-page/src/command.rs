//! Executes the JSON commands that `exports` gets from a page: restart, watch, get, set and others.

use anyhow::{Context, Result, bail};
use cosim::describe;
use serde_json::{Map, Value, json};

use crate::engine::{Engine, setting_text};

/// Execute the command in `text`: an object with the name of a `command` and its arguments.
pub fn answer(engine: &mut Engine, text: &str) -> Result<Value> {
    let command: Map<String, Value> = serde_json::from_str(text).context("the command")?;
    let name = command.get("command").and_then(Value::as_str);
    let name = name.context("a command has the name `command`")?;
    let variable = engine.full_name(command.get("name").map(setting_text).unwrap_or_default());
    let id = command.get("id").and_then(Value::as_u64);
    let id = id.unwrap_or_default();
    match name {
        "restart" => {
            let settings = command.get("settings").and_then(Value::as_object);
            engine.restart(settings.unwrap_or(&Map::new()))?;
            describe_run(engine)
        }
        "watch" => {
            let names = command.get("names").and_then(Value::as_array);
            let names = names.context("`names` are missing")?;
            engine.watch(names.iter().map(setting_text).collect())?;
            Ok(Value::Null)
        }
        "get" => engine.run()?.get(&variable),
        "driver" => {
            let run = engine.run()?;
            Ok(run.driver(run.system.port(&variable)?)?.into())
        }
        "set" => {
            let value = command.get("value").map(setting_text);
            let value = value.context("`value` is missing")?;
            engine.run()?.set(&variable, &value)?;
            Ok(Value::Null)
        }
        "save" => Ok(engine.run()?.save()?.into()),
        "restore" => {
            engine.restore(id)?;
            Ok(Value::Null)
        }
        "forget" => {
            engine.run()?.forget(id);
            Ok(Value::Null)
        }
        "variables" => variables(engine),
        "verdict" => {
            let verdict = engine.run()?.verdict();
            let findings = verdict.findings().iter();
            let findings = findings.map(|f| json!({"text": f.text, "bad": f.is_bad}));
            Ok(
                json!({"bad": verdict.is_bad(), "text": verdict.to_string(), "findings": findings.collect::<Value>()}),
            )
        }
        other => bail!("`{other}` is no command"),
    }
}

/// The opened system and the settings of its run.
fn describe_run(engine: &mut Engine) -> Result<Value> {
    let (structures, sets) = (json!(engine.files(".ssd")), json!(engine.files(".ssv")));
    let run = engine.run()?;
    let (stepping, structure) = (run.master.stepping(), &run.system.structure);
    let all = structure.components.iter().zip(&run.system.fmus);
    let components = all.map(
        |(c, fmu)| json!({"name": c.name, "source": c.source, "model": fmu.description.model}),
    );
    Ok(json!({
        "name": structure.name, "structures": structures, "parameters": sets, "watched": run.watched(),
        "components": components.collect::<Value>(),
        "start": stepping.start, "step": stepping.step, "stop": run.system.structure.stop_time.unwrap_or(run.system.preferred_stop(stepping.start)),
    }))
}

/// All variables of the system, named `component.variable`.
fn variables(engine: &mut Engine) -> Result<Value> {
    let system = &engine.run()?.system;
    let mut all = Vec::new();
    for (component, fmu) in system.structure.components.iter().zip(&system.fmus) {
        for v in &fmu.description.variables {
            let mut row = describe::variable_json(&fmu.description, v);
            row["name"] = format!("{}.{}", component.name, v.name).into();
            row["displayUnit"] = row["display_unit"].take();
            all.push(row);
        }
    }
    Ok(all.into())
}
