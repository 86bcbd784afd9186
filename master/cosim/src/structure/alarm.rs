//! Alarms as system structures declare them, for `flatten`: an annotation of a component, or of a
//! system for the components in it, names outputs that mean that the result is not good.

use std::cmp::Ordering;

use anyhow::{Result, bail};
use system_structure::Annotation;

/// Type of the annotation that holds the alarms.
const ALARMS: &str = "io.github.hdrm-fmu.alarms";

/// How the value is compared with the bound.
const CONDITIONS: [(&str, Ordering); 3] = [
    ("equals", Ordering::Equal),
    ("above", Ordering::Greater),
    ("below", Ordering::Less),
];

/// An output that means that the result is not good.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarm {
    /// `component.variable`; of an array each element counts.
    pub name: String,
    /// How the value compares with the bound where the alarm holds.
    pub condition: Ordering,
    /// A number, `true`, `false` or an enumeration item.
    pub bound: String,
    /// What it means, for people.
    pub text: String,
    /// File and line.
    pub place: String,
}

impl Alarm {
    /// The alarms among the annotations of an element in `file`, with their names in it.
    pub(super) fn read_all(annotations: &[Annotation], file: &str) -> Result<Vec<Self>> {
        let mut alarms = Vec::new();
        for Annotation { kind, content } in annotations {
            let list = content.child("Alarms");
            if list.is_some() != (kind == ALARMS) {
                bail!(content.error(format!(
                    "annotations of type `{ALARMS}` hold Alarms, and no others; this one is of type `{kind}`"
                )));
            }
            for node in list.into_iter().flat_map(|list| &list.children) {
                let given = CONDITIONS.map(|(name, condition)| Some((condition, node.get(name)?)));
                let given: Vec<_> = given.into_iter().flatten().collect();
                let ([(condition, bound)], "Alarm") = (&given[..], node.tag.as_str()) else {
                    bail!(node.error(
                        "Alarms are elements `Alarm` with a variable, a text and one condition: equals, above or below".into()
                    ));
                };
                alarms.push(Self {
                    name: node.required("variable")?,
                    condition: *condition,
                    bound: bound.to_string(),
                    text: node.required("text")?,
                    place: format!("`{file}`, line {}", node.line),
                });
            }
        }
        Ok(alarms)
    }

    /// Whether it holds for a value, compared with the bound as a number.
    pub fn holds(&self, value: f64, bound: f64) -> bool {
        value.partial_cmp(&bound) == Some(self.condition)
    }
}
