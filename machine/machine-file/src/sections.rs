//! Sections that may have an object for each actuator, and their split, for `shape` and `source`.

use crate::per_axis::AXES;
use serde_json::{Map, Value};

pub(crate) const SECTIONS_PER_AXIS: [&str; 2] = ["emla", "ratings"];

/// Whether a section has an object for each actuator.
pub(crate) fn is_split(section: &Value) -> bool {
    let fields = section.as_object();
    fields.is_some_and(|fields| AXES.iter().any(|axis| fields.contains_key(*axis)))
}

/// Copies a section for all actuators to each of them.
pub(crate) fn split(section: &mut Value) {
    if !is_split(section) && section.is_object() {
        let each = AXES.map(|axis| (axis.to_owned(), section.clone()));
        *section = Value::Object(Map::from_iter(each));
    }
}
