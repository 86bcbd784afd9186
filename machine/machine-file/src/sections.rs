//! Sections of a machine file that may tell the actuators apart.

use crate::per_axis::AXES;
use serde_json::{Map, Value};

/// Sections that may have one object for each actuator.
pub(crate) const SECTIONS_PER_AXIS: [&str; 2] = ["emla", "ratings"];

/// Whether a section tells actuators apart.
pub(crate) fn is_split(section: &Value) -> bool {
    let fields = section.as_object();
    fields.is_some_and(|fields| AXES.iter().any(|axis| fields.contains_key(*axis)))
}

/// Says for each actuator what a section says for all.
pub(crate) fn split(section: &mut Value) {
    if !is_split(section) && section.is_object() {
        let each = AXES.map(|axis| (axis.to_owned(), section.clone()));
        *section = Value::Object(Map::from_iter(each));
    }
}
