//! One value for each of the three actuators, for `Machine`. A machine file has one object for all,
//! or `{"slew": …, "lift": …, "tilt": …}`; `shape` and `source` tell and split such sections by the
//! functions here. Saved states hold all three.

use crate::check::{Finding, Findings};
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};

/// Names of the actuators, in the order of `x[1..3]`.
pub const AXES: [&str; 3] = ["slew", "lift", "tilt"];

pub(crate) const SECTIONS_PER_AXIS: [&str; 2] = ["emla", "ratings"];

/// Whether a section of a file has an object for each actuator.
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

/// One value for each actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerAxis<T> {
    /// Value of the slew actuator.
    pub slew: T,
    /// Value of the lift actuator.
    pub lift: T,
    /// Value of the tilt actuator.
    pub tilt: T,
}

impl<T> PerAxis<T> {
    /// The values in the order of [`AXES`].
    pub fn in_order(&self) -> [&T; 3] {
        [&self.slew, &self.lift, &self.tilt]
    }
}

impl<T: Copy + PartialEq> PerAxis<T> {
    /// The same value for all.
    pub fn all(value: T) -> Self {
        Self {
            slew: value,
            lift: value,
            tilt: value,
        }
    }

    /// Whether all values are equal.
    pub fn is_common(&self) -> bool {
        self.slew == self.lift && self.lift == self.tilt
    }

    /// Checks each value; if they differ, the findings name the axis: `emla.lift.R_s`.
    pub(crate) fn examine(&self, examine: impl Fn(&T, &mut Findings), found: &mut Findings) {
        if self.is_common() {
            return examine(&self.slew, found);
        }
        for (axis, value) in AXES.into_iter().zip(self.in_order()) {
            let first = found.list.len();
            examine(value, found);
            for Finding { name, .. } in &mut found.list[first..] {
                if let Some((section, field)) = name.split_once('.') {
                    *name = format!("{section}.{axis}.{field}");
                }
            }
        }
    }
}

impl<T: Serialize + Copy + PartialEq> Serialize for PerAxis<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if !to.is_human_readable() {
            return self.in_order().serialize(to);
        }
        if self.is_common() {
            return self.slew.serialize(to);
        }
        let mut fields = to.serialize_struct("PerAxis", 3)?;
        for (axis, value) in AXES.into_iter().zip(self.in_order()) {
            fields.serialize_field(axis, value)?;
        }
        fields.end()
    }
}

impl<'de, T: Deserialize<'de> + Copy + PartialEq> Deserialize<'de> for PerAxis<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        if !from.is_human_readable() {
            let [slew, lift, tilt] = Deserialize::deserialize(from)?;
            return Ok(Self { slew, lift, tilt });
        }
        Ok(match FileForm::deserialize(from)? {
            FileForm::Each { slew, lift, tilt } => Self { slew, lift, tilt },
            FileForm::All(all) => Self::all(all),
        })
    }
}

/// The two forms of such a section in a file.
#[derive(Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum FileForm<T> {
    Each { slew: T, lift: T, tilt: T },
    All(T),
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The FMUs' saved states are written by postcard.
    #[test]
    fn bytes_of_saved_states_are_read_back() {
        let common = PerAxis::all(1.5);
        let different = PerAxis {
            tilt: 0.7,
            ..common
        };
        for value in [common, different] {
            let bytes = postcard::to_allocvec(&value).unwrap();
            assert_eq!(postcard::from_bytes::<PerAxis<f64>>(&bytes), Ok(value));
        }
        let machine = crate::Machine::reference();
        let bytes = postcard::to_allocvec(&machine).unwrap();
        assert_eq!(postcard::from_bytes(&bytes), Ok(machine));
    }
}
