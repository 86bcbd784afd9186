//! The JSON Schema of machine files, for editors. Names, types and what may be left out come from the machine itself, descriptions from the
//! comments of its fields, and bounds from the checks, which are asked.

use crate::Machine;
use crate::per_axis::AXES;
use crate::shape::{SECTIONS_PER_AXIS, may_lack, template};
use crate::source::PRESETS;
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// Where the fields and their comments are.
const SOURCES: [&str; 5] = [
    include_str!("machine.rs"),
    include_str!("geometry.rs"),
    include_str!("bodies.rs"),
    include_str!("actuator.rs"),
    include_str!("controller.rs"),
];

/// Beside a bound, to see on which side of it values are refused.
const BESIDE: f64 = 1e-9;

/// The schema, draft 2020-12.
#[must_use]
pub fn schema() -> Value {
    let made = Maker {
        template: template(),
        fields: fields(),
    };
    let Value::Object(known) = &made.template else {
        return Value::Null;
    };
    let mut properties = made.properties(known, "Machine", &[]);
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
    let required: Vec<_> = known.keys().collect();
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

struct Field {
    /// Type without `Option` and `PerAxis`.
    of: &'static str,
    /// Comment, one line.
    comment: String,
}

/// Fields of all structs, by struct and name.
fn fields() -> HashMap<(&'static str, &'static str), Field> {
    let mut fields = HashMap::new();
    for source in SOURCES {
        let (mut inside, mut comment) = ("", String::new());
        for line in source.lines() {
            if let Some(rest) = line.strip_prefix("pub struct ") {
                inside = rest.trim_end_matches(" {");
            } else if line == "}" {
                inside = "";
            } else if let Some(text) = line.strip_prefix("    /// ") {
                comment = [comment.as_str(), text].join(" ").trim().to_owned();
            } else if let Some((name, of)) = field(line).filter(|_| !inside.is_empty()) {
                let of = of
                    .trim_start_matches("Option<")
                    .trim_start_matches("PerAxis<");
                let of = of.trim_end_matches([',', '>']);
                let comment = std::mem::take(&mut comment);
                fields.insert((inside, name), Field { of, comment });
            } else if !line.trim_start().starts_with("#[") {
                comment.clear();
            }
        }
    }
    fields
}

fn field(line: &str) -> Option<(&str, &str)> {
    line.strip_prefix("    pub ")?.split_once(": ")
}

struct Maker {
    template: Value,
    fields: HashMap<(&'static str, &'static str), Field>,
}

impl Maker {
    fn properties(
        &self,
        known: &Map<String, Value>,
        of: &str,
        place: &[&str],
    ) -> Map<String, Value> {
        let property = |(key, template): (&String, &Value)| {
            let field = self.fields.get(&(of, key.as_str()));
            let of = field.map_or("", |field| field.of);
            let place = [place, &[key.as_str()]].concat();
            let mut schema = self.value(template, of, &place);
            if let Some(field) = field.filter(|field| !field.comment.is_empty()) {
                schema["description"] = field.comment.as_str().into();
            }
            (key.clone(), schema)
        };
        known.iter().map(property).collect()
    }

    fn value(&self, template: &Value, of: &str, place: &[&str]) -> Value {
        match template {
            Value::Object(known) => {
                let of_none = may_lack(&self.template, place);
                json!({
                    "type": if of_none { json!(["object", "null"]) } else { json!("object") },
                    "properties": self.properties(known, of, place),
                    "additionalProperties": false,
                })
            }
            Value::Array(elements) => {
                let index: Vec<String> = (0..elements.len()).map(|i| i.to_string()).collect();
                let each = elements.iter().zip(&index);
                let mut each =
                    each.map(|(e, i)| self.value(e, of, &[place, &[i.as_str()]].concat()));
                let first = each.next().unwrap_or_default();
                // Bounds that not all elements have depend on the others.
                let items = if each.all(|other| other == first) {
                    first
                } else {
                    json!({"type": "number"})
                };
                match place.last() {
                    Some(&"vertices") => json!({"type": "array", "items": items, "minItems": 2}),
                    _ => {
                        json!({"type": "array", "items": items, "minItems": elements.len(), "maxItems": elements.len()})
                    }
                }
            }
            number => {
                let is_whole = !number.is_f64();
                let mut schema = json!({"type": if is_whole { "integer" } else { "number" }});
                let little = if is_whole { json!(1) } else { json!(BESIDE) };
                let allows = |value: Value| self.allows(place, value);
                if allows(little) && !allows(json!(0)) {
                    schema["exclusiveMinimum"] = json!(0);
                } else if allows(json!(0)) && !allows(json!(-BESIDE)) {
                    schema["minimum"] = json!(0);
                }
                if !is_whole && allows(json!(1.0)) && !allows(json!(1.0 + BESIDE)) {
                    schema["maximum"] = json!(1);
                }
                schema
            }
        }
    }

    /// Whether the machine with `value` at `place` passes its checks.
    fn allows(&self, place: &[&str], value: Value) -> bool {
        let mut machine = self.template.clone();
        let pointer: String = place.iter().map(|key| format!("/{key}")).collect();
        let Some(field) = machine.pointer_mut(&pointer) else {
            return false;
        };
        *field = value;
        serde_json::from_value::<Machine>(machine).is_ok_and(|machine| machine.check().is_ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `hdrm-fmu machine schema > parameters/machine.schema.json` writes it anew.
    #[test]
    fn the_schema_in_the_repository_is_that_of_the_machine() {
        let committed = include_str!("../../../parameters/machine.schema.json");
        let made = serde_json::to_string_pretty(&schema()).expect("JSON") + "\n";
        assert!(committed == made, "write it anew: hdrm-fmu machine schema");
    }

    #[test]
    fn bounds_and_descriptions_are_those_of_the_fields() {
        let schema = schema();
        let emla = &schema["$defs"]["emla"]["properties"];
        let expected = json!({"type": "number", "exclusiveMinimum": 0, "description": "Stator resistance, Ω."});
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
}
