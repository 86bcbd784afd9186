//! Makes the JSON Schema of machine files, `parameters/machine.schema.json`, and compares it with
//! that file. Names, types and descriptions are those of the structs; bounds come from the checks,
//! which are asked.

use crate::angles::ANGLES;
use crate::per_axis::AXES;
use crate::per_axis::SECTIONS_PER_AXIS;
use crate::shape::template;
use crate::source::PRESETS;
use crate::{Machine, SCHEMA_JSON};
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};
use std::fs;

/// Beside a bound, to see on which side of it values are refused.
const BESIDE: f64 = 1e-9;

/// The schema, draft 2020-12.
fn schema() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    let machine = settings.into_generator().into_root_schema_for::<Machine>();
    let mut machine = machine.to_value();
    let required = machine["required"].take();
    Bounds {
        template: template(),
    }
    .overlay(&mut machine, &[]);
    let Value::Object(mut properties) = machine["properties"].take() else {
        panic!("a machine is an object");
    };
    for (section, own, other) in ANGLES {
        let properties = &mut properties[section]["properties"];
        let mut angle = properties[own].clone();
        let unit = if other.ends_with("_deg") {
            "degrees"
        } else {
            "rad"
        };
        angle["description"] = json!(format!("`{own}` in {unit}."));
        properties[other] = angle;
    }
    let mut definitions = Map::new();
    for section in SECTIONS_PER_AXIS {
        let one = std::mem::replace(&mut properties[section], per_axis(section));
        definitions.insert(section.into(), one);
    }
    let names = PRESETS.map(|(name, _)| name).join(", ");
    properties.insert("$schema".into(), json!({"type": "string"}));
    properties.insert("extends".into(), json!({
        "type": "string",
        "description": format!("A shipped machine ({names}) or another machine file, beside this one; then this file says only what differs."),
    }));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Machine of hdrm-fmu",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "anyOf": [{"required": ["extends"]}, {"required": required}],
        "$defs": definitions,
    })
}

/// One object for all actuators, or one for each.
fn per_axis(section: &str) -> Value {
    let one = json!({"$ref": format!("#/$defs/{section}")});
    let each = AXES.map(|axis| (axis.to_owned(), one.clone()));
    json!({
        "if": {"anyOf": AXES.map(|axis| json!({"required": [axis]}))},
        "then": {"type": "object", "properties": Map::from_iter(each), "additionalProperties": false},
        "else": one,
    })
}

/// Finds out by trying which values the checks refuse.
struct Bounds {
    /// A machine with every section.
    template: Value,
}

impl Bounds {
    /// Puts bounds into the schema of what is at `place`. Every field may be left out of a file
    /// that extends another.
    fn overlay(&self, schema: &mut Value, place: &[&str]) {
        let Value::Object(fields) = schema else {
            return;
        };
        for key in ["required", "format", "title", "minimum"] {
            fields.remove(key);
        }
        fields.retain(|key, value| key != "default" || !value.is_null());
        if let Some(Value::String(text)) = fields.get_mut("description") {
            *text = text.replace('\n', " ");
        }
        if let Some(Value::Object(properties)) = fields.get_mut("properties") {
            for (key, property) in properties {
                self.overlay(property, &[place, &[key.as_str()]].concat());
            }
        } else if let Some(items) = fields.remove("items") {
            fields.insert("items".into(), self.items(&items, place));
            if place.last() == Some(&"vertices") {
                fields.insert("minItems".into(), json!(2));
            }
        } else {
            self.put_range(fields, place);
        }
    }

    /// Schema of the elements of the array at `place`. Bounds that not all elements have depend on
    /// the others, and are left out.
    fn items(&self, items: &Value, place: &[&str]) -> Value {
        let pointer: String = place.iter().map(|key| format!("/{key}")).collect();
        let elements = self.template.pointer(&pointer).and_then(Value::as_array);
        let indices = (0..elements.map_or(0, Vec::len)).map(|i| i.to_string());
        let mut each = indices.map(|i| {
            let mut items = items.clone();
            self.overlay(&mut items, &[place, &[i.as_str()]].concat());
            items
        });
        let first = each.next().unwrap_or_default();
        if each.all(|other| other == first) {
            first
        } else {
            json!({"type": items["type"]})
        }
    }

    /// Puts the bounds of the number at `place`.
    fn put_range(&self, number: &mut Map<String, Value>, place: &[&str]) {
        let is_whole = number["type"] == "integer";
        let little = if is_whole { json!(1) } else { json!(BESIDE) };
        let allows = |value: Value| self.allows(place, value);
        if allows(little) && !allows(json!(0)) {
            number.insert("exclusiveMinimum".into(), json!(0));
        } else if allows(json!(0)) && !allows(json!(-BESIDE)) {
            number.insert("minimum".into(), json!(0));
        }
        if !is_whole && allows(json!(1.0)) && !allows(json!(1.0 + BESIDE)) {
            number.insert("maximum".into(), json!(1));
        }
    }

    /// Whether the machine with `value` at `place` passes its checks.
    fn allows(&self, place: &[&str], value: Value) -> bool {
        let mut machine = self.template.clone();
        let pointer: String = place.iter().map(|key| format!("/{key}")).collect();
        let Some(field) = machine.pointer_mut(&pointer) else {
            return false;
        };
        *field = value.clone();
        // The rod must fit into the retracted actuator.
        if let ["geometry", "x0_2" | "x0_3"] = place {
            machine["geometry"][place[1].replace("x0", "lc")] = value;
        }
        serde_json::from_value::<Machine>(machine).is_ok_and(|machine| machine.check().is_ok())
    }
}

/// Where it does not, the new schema is put into a file that replaces the committed one.
#[test]
fn the_schema_in_the_repository_is_that_of_the_machine() {
    let made = serde_json::to_string_pretty(&schema()).expect("JSON") + "\n";
    if SCHEMA_JSON != made {
        let file = std::env::temp_dir().join("machine.schema.json");
        fs::write(&file, made).expect("it can be written");
        panic!("copy {} to parameters/", file.display());
    }
}

#[test]
fn bounds_and_descriptions_are_those_of_the_fields() {
    let schema = schema();
    let emla = &schema["$defs"]["emla"]["properties"];
    let expected =
        json!({"type": "number", "exclusiveMinimum": 0, "description": "Stator resistance, Ω."});
    assert_eq!(emla["R_s"], expected);
    assert_eq!(emla["p"]["type"], "integer");
    assert_eq!(
        (
            &emla["eta_gear"]["exclusiveMinimum"],
            &emla["eta_gear"]["maximum"]
        ),
        (&json!(0), &json!(1))
    );
    assert_eq!(emla["C_m"]["minimum"], 0);
    assert_eq!(emla["core"]["type"], json!(["object", "null"]));
    let geometry = &schema["properties"]["geometry"]["properties"];
    assert_eq!(geometry["beta1"].get("minimum"), None);
    assert_eq!(geometry["A_in_boom"]["maxItems"], 2);
    assert_eq!(
        schema["properties"]["bodies"]["properties"]["A2"]["description"],
        "Lift boom."
    );
}
