//! One value for each actuator. A file writes one object for all, or
//! `{"slew": …, "lift": …, "tilt": …}`. Saved states, whose bytes name nothing, hold all three.

use crate::check::{Finding, Findings};
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Error, IntoDeserializer, MapAccess, Visitor};
use serde::ser::SerializeStruct;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

/// The actuators, in the order of `x[1..3]`.
pub const AXES: [&str; 3] = ["slew", "lift", "tilt"];

/// One value for each actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerAxis<T> {
    /// Of the slew actuator.
    pub slew: T,
    /// Of the lift actuator.
    pub lift: T,
    /// Of the tilt actuator.
    pub tilt: T,
}

impl<T> PerAxis<T> {
    /// In the order of [`AXES`].
    #[must_use]
    pub fn in_order(&self) -> [&T; 3] {
        [&self.slew, &self.lift, &self.tilt]
    }
}

impl<T: Copy + PartialEq> PerAxis<T> {
    /// The same for all.
    #[must_use]
    pub fn all(value: T) -> Self {
        Self {
            slew: value,
            lift: value,
            tilt: value,
        }
    }

    /// Whether all are the same.
    #[must_use]
    pub fn is_common(&self) -> bool {
        self.slew == self.lift && self.lift == self.tilt
    }

    /// Examines each of them; where they differ, a finding's name says whose it is:
    /// `emla.lift.R_s`.
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
        from.deserialize_map(Either(PhantomData))
    }
}

/// Tells the two forms by the first key, so that errors keep their place in the file.
struct Either<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Copy + PartialEq> Visitor<'de> for Either<T> {
    type Value = PerAxis<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object for all actuators, or one with slew, lift and tilt")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<PerAxis<T>, A::Error> {
        let first = map.next_key::<String>()?;
        let is_axis = |key: &String| AXES.contains(&key.as_str());
        if !first.as_ref().is_some_and(is_axis) {
            let all = T::deserialize(MapAccessDeserializer::new(Replayed { first, map }))?;
            return Ok(PerAxis::all(all));
        }
        let mut found: [Option<T>; 3] = [None; 3];
        let mut key = first;
        while let Some(axis) = key {
            let Some(place) = AXES.iter().position(|known| *known == axis) else {
                return Err(A::Error::unknown_field(&axis, &AXES));
            };
            if found[place].replace(map.next_value()?).is_some() {
                return Err(A::Error::custom(format_args!("duplicate field `{axis}`")));
            }
            key = map.next_key()?;
        }
        let value = |place: usize| found[place].ok_or_else(|| A::Error::missing_field(AXES[place]));
        Ok(PerAxis {
            slew: value(0)?,
            lift: value(1)?,
            tilt: value(2)?,
        })
    }
}

/// A map whose first key was read already.
struct Replayed<A> {
    first: Option<String>,
    map: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Replayed<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        match self.first.take() {
            Some(key) => seed.deserialize(key.into_deserializer()).map(Some),
            None => self.map.next_key_seed(seed),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
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
