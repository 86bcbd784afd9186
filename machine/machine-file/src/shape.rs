//! Compares a machine file's JSON with a template of all fields, for `source`, and reports fields
//! that are unknown, missing or of a wrong type; suggests similar names, for other crates too.

use crate::check::Findings;
use crate::per_axis::{AXES, PerAxis, SECTIONS_PER_AXIS, is_split};
use crate::{EmlaFields, Machine};
use serde_json::Value;

/// Similarity (Jaro–Winkler) from which on a name is suggested in place of an unknown one.
const LIKE: f64 = 0.7;

/// Reports and removes unknown fields. If the machine must be complete, also reports missing fields
/// and fills them with the reference machine's values.
pub(crate) fn check(value: &mut Value, found: &mut Findings, is_complete: bool) {
    let template = template();
    let root = FieldPath {
        template: &template,
        keys: &[],
        name: "",
    };
    let check = ShapeCheck {
        template: &template,
        is_complete,
    };
    check.value(value, &root, found);
}

/// The name among `known` that is most similar to `name`, for "did you mean …?".
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    let likeness = |other: &str| strsim::jaro_winkler(&name, &other.to_lowercase());
    let best = known.map(|other| (likeness(other), other));
    let best = best.max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(likeness, _)| *likeness >= LIKE)
        .map(|(_, name)| name)
}

/// The reference machine with all optional sections.
pub(crate) fn template() -> Value {
    let mut machine = Machine::reference();
    let with_all = EmlaFields::new(machine.emla.lift).section();
    machine.emla = PerAxis::all(with_all.expect("pole pairs"));
    serde_json::to_value(machine).expect("numbers and names")
}

/// A field of the machine file, where the comparison is.
struct FieldPath<'a> {
    template: &'a Value,
    /// Keys that lead there in the template.
    keys: &'a [&'a str],
    /// Path for messages, which also names the actuator.
    name: &'a str,
}

struct ShapeCheck<'a> {
    template: &'a Value,
    is_complete: bool,
}

impl ShapeCheck<'_> {
    fn value(&self, value: &mut Value, at: &FieldPath, found: &mut Findings) {
        let is_section = matches!(at.keys, [section] if SECTIONS_PER_AXIS.contains(section));
        if is_section && is_split(value) {
            return self.axes(value, at, found);
        }
        let must_be = match (&*value, at.template) {
            (Value::Object(_), Value::Object(_)) => return self.fields(value, at, found),
            (Value::Array(_), Value::Array(_)) => return self.elements(value, at, found),
            (Value::Number(n), Value::Number(t)) => {
                // Where the template has a whole number, the file must have one, too.
                if t.is_f64() || n.as_u64().is_some_and(|n| u32::try_from(n).is_ok()) {
                    return;
                }
                "a whole number".into()
            }
            (Value::Null, Value::Object(_)) if self.is_optional(at.keys) => return,
            (_, Value::Object(_)) => "an object".into(),
            (_, Value::Array(t)) => format!("an array of {} elements", t.len()),
            _ => "a number".into(),
        };
        found.refuse(at.name, &*value, must_be);
        *value = at.template.clone();
    }

    fn axes(&self, value: &mut Value, at: &FieldPath, found: &mut Findings) {
        let Value::Object(fields) = value else { return };
        fields.retain(|key, _| {
            let is_axis = AXES.contains(&key.as_str());
            if !is_axis {
                let problem = "must be inside `slew`, `lift` or `tilt`, which this section has";
                found.add(format_args!("{}.{key}", at.name), problem);
            }
            is_axis
        });
        for axis in AXES {
            let name = format!("{}.{axis}", at.name);
            match fields.get_mut(axis) {
                Some(value) if value.is_object() => {
                    self.fields(value, &FieldPath { name: &name, ..*at }, found);
                }
                Some(value) => {
                    found.refuse(name, &*value, "an object");
                    *value = at.template.clone();
                }
                None if self.is_complete => {
                    found.add(name, "is missing");
                    fields.insert(axis.to_owned(), at.template.clone());
                }
                None => {}
            }
        }
    }

    fn fields(&self, value: &mut Value, at: &FieldPath, found: &mut Findings) {
        let (Value::Object(fields), Value::Object(known)) = (value, at.template) else {
            return;
        };
        let inner = |key: &str| match at.name {
            "" => key.to_owned(),
            name => format!("{name}.{key}"),
        };
        fields.retain(|key, _| {
            if !known.contains_key(key) {
                let near = nearest(key, known.keys().map(String::as_str));
                let near = match near {
                    Some(near) => format!("; did you mean `{near}`?"),
                    None => format!(
                        "; there are {}",
                        Vec::from_iter(known.keys().cloned()).join(", ")
                    ),
                };
                found.add(inner(key), format_args!("is an unknown field{near}"));
            }
            known.contains_key(key)
        });
        for (key, template) in known {
            let keys = &[at.keys, &[key.as_str()]].concat();
            let name = &inner(key);
            let field = FieldPath {
                template,
                keys,
                name,
            };
            match fields.get_mut(key) {
                Some(value) => self.value(value, &field, found),
                None if self.is_complete && !self.is_optional(keys) => {
                    found.add(inner(key), "is missing");
                    fields.insert(key.clone(), template.clone());
                }
                None => {}
            }
        }
    }

    fn elements(&self, value: &mut Value, at: &FieldPath, found: &mut Findings) {
        let (Value::Array(values), Value::Array(known)) = (&mut *value, at.template) else {
            return;
        };
        let is_list = at.keys.last() == Some(&"vertices");
        if !is_list && values.len() != known.len() {
            let rule = format!("an array of {} elements", known.len());
            found.refuse(at.name, &*value, rule);
            *value = at.template.clone();
            return;
        }
        for (i, value) in values.iter_mut().enumerate() {
            let element = FieldPath {
                template: if is_list { &known[0] } else { &known[i] },
                keys: &[at.keys, &["element"]].concat(),
                name: &format!("{}[{}]", at.name, i + 1),
            };
            self.value(value, &element, found);
        }
    }

    /// Whether a machine can be read without the field at `place`.
    fn is_optional(&self, place: &[&str]) -> bool {
        let Some((field, parents)) = place.split_last() else {
            return false;
        };
        let mut without = self.template.clone();
        let parent = parents
            .iter()
            .try_fold(&mut without, |value, key| value.get_mut(key));
        if let Some(Value::Object(parent)) = parent {
            parent.remove(*field);
        }
        serde_json::from_value::<Machine>(without).is_ok()
    }
}
