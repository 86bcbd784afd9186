//! Reads path files in JSON, for `reading`; error messages name waypoint, field and rule.

use crate::error::{PathError, counted, refused, unknown};
use crate::file::{Load, MotionLimits, PathFile, Points, Sample, Waypoint, in_laps};
use crate::quaternion::unit;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use serde_path_to_error::{Path, Segment};
use std::fmt;
use std::marker::PhantomData;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileRecord {
    #[serde(default, deserialize_with = "given")]
    waypoints: Option<Vec<Object<WaypointRecord>>>,
    #[serde(default, deserialize_with = "given")]
    samples: Option<Vec<Value>>,
    #[serde(default)]
    relative: bool,
    #[serde(default, deserialize_with = "given")]
    laps: Option<f64>,
    #[serde(default)]
    limits: Object<MotionLimits>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WaypointRecord {
    position: Numbers<3>,
    #[serde(default, deserialize_with = "given")]
    orientation: Option<Numbers<4>>,
    #[serde(default)]
    dwell: f64,
    #[serde(default, deserialize_with = "given")]
    speed: Option<f64>,
    #[serde(default, deserialize_with = "given")]
    time: Option<f64>,
    #[serde(default)]
    blend: f64,
    #[serde(default, deserialize_with = "given")]
    load: Option<Object<LoadRecord>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LoadRecord {
    mass: f64,
    #[serde(default, deserialize_with = "given")]
    com: Option<Numbers<3>>,
    #[serde(default)]
    over: f64,
}

struct Numbers<const N: usize>([f64; N]);

/// A record that must be a JSON object; serde alone would accept a list of its fields, too.
#[derive(Default)]
struct Object<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Object<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Fields(PhantomData)).map(Self)
    }
}

/// Reader of an object's fields.
struct Fields<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Fields<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, fields: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(fields))
    }
}

/// A field that may be left out, but if given must not be `null`.
fn given<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Option<T>, D::Error> {
    T::deserialize(from).map(Some)
}

impl<'de, const N: usize> Deserialize<'de> for Numbers<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let numbers = numbers(&Value::deserialize(from)?).and_then(|list| list.try_into().ok());
        let rule = || D::Error::custom(format_args!("expected a list of {N} numbers"));
        numbers.map(Self).ok_or_else(rule)
    }
}

fn numbers(list: &Value) -> Option<Vec<f64>> {
    list.as_array()?.iter().map(Value::as_f64).collect()
}

/// Reads a path without checking its values.
pub(crate) fn parse(text: &str) -> Result<PathFile, PathError> {
    let value: Value =
        serde_json::from_str(text).map_err(|e| PathError::Format(format!("path JSON: {e}")))?;
    let Object::<FileRecord>(file) = serde_path_to_error::deserialize(&value)
        .map_err(|e| refusal(&value, e.path(), &e.inner().to_string()))?;
    let laps = (file.laps).map(|laps| counted("the file", "laps", laps, laps));
    let laps = laps.transpose()?;
    let points = match (file.waypoints, file.samples) {
        (Some(list), None) => {
            let waypoints = each(list, "waypoint", waypoint)?;
            Points::Waypoints(match laps {
                Some(laps) => lapped(&waypoints, laps)?,
                None => waypoints,
            })
        }
        (None, Some(_)) if laps.is_some() => {
            let text =
                "a path of `samples` has no `laps`; give `waypoints`, or the samples of all laps";
            return Err(PathError::Format(text.to_owned()));
        }
        (None, Some(list)) => Points::Samples(each(list, "sample", sample)?),
        _ => {
            let text = "a path must have either `waypoints` or `samples`".to_owned();
            return Err(PathError::Format(text));
        }
    };
    Ok(PathFile {
        points,
        relative: file.relative,
        limits: file.limits.0,
        laps,
        test: None,
    })
}

/// The waypoints of all laps, each of which ends where the first one begins.
fn lapped(waypoints: &[Waypoint], laps: usize) -> Result<Vec<Waypoint>, PathError> {
    for (k, waypoint) in (1..).zip(waypoints) {
        let place = format!("waypoint {k}");
        if let Some(time) = waypoint.time {
            let rule = "left out, since the path has `laps`";
            return Err(refused(&place, "time", time, rule));
        }
        if k == 1 && waypoint.blend > 0.0 {
            let rule = "0, because the laps end there and the tip stops";
            return Err(refused(&place, "blend", waypoint.blend, rule));
        }
    }
    Ok(in_laps(waypoints, laps))
}

fn each<R, T>(
    list: Vec<R>,
    what: &str,
    read: impl Fn(R, &str) -> Result<T, PathError>,
) -> Result<Vec<T>, PathError> {
    let numbered = (1..).zip(list);
    numbered
        .map(|(k, record)| read(record, &format!("{what} {k}")))
        .collect()
}

fn waypoint(Object(record): Object<WaypointRecord>, place: &str) -> Result<Waypoint, PathError> {
    let load = record.load.map(|Object(load)| load);
    let load = load.as_ref();
    Ok(Waypoint {
        position: record.position.0.into(),
        orientation: (record.orientation).map(|q| unit(place, q.0)).transpose()?,
        dwell: record.dwell,
        speed: record.speed,
        time: record.time,
        blend: record.blend,
        over: load.map_or(0.0, |load| load.over),
        load: load.map(|load| Load {
            mass: load.mass,
            com: load.com.as_ref().map_or([0.0; 3], |com| com.0),
        }),
    })
}

/// `[t, x, y, z]` or `[t, x, y, z, qw, qx, qy, qz]`.
fn sample(record: Value, place: &str) -> Result<Sample, PathError> {
    let (t, [x, y, z], orientation) = match numbers(&record).as_deref() {
        Some(&[t, x, y, z]) => (t, [x, y, z], None),
        Some(&[t, x, y, z, qw, qx, qy, qz]) => (t, [x, y, z], Some([qw, qx, qy, qz])),
        _ => {
            let rule = "[t, x, y, z] or [t, x, y, z, qw, qx, qy, qz], all numbers";
            return Err(refused(place, "samples", record, rule));
        }
    };
    Ok(Sample {
        t,
        position: [x, y, z].into(),
        orientation: orientation.map(|q| unit(place, q)).transpose()?,
    })
}

/// The error for a person, from serde's `message` about the value at `path`.
fn refusal(file: &Value, path: &Path, message: &str) -> PathError {
    let (mut place, mut names, mut value) = ("the file".to_owned(), Vec::new(), Some(file));
    for segment in path {
        match segment {
            Segment::Map { key } => {
                names.push(key.as_str());
                value = value.and_then(|value| value.get(key));
            }
            Segment::Seq { index } => {
                let list = names.pop().unwrap_or_default();
                place = format!("{} {}", list.trim_end_matches('s'), index + 1);
                value = value.and_then(|value| value.get(index));
            }
            Segment::Enum { .. } | Segment::Unknown => (),
        }
    }
    // "expected one of `a`, `b`" and "expected `a`" list the known names.
    let (said, expected) = message.rsplit_once("expected ").unwrap_or(("", message));
    if let Some(name) = said.strip_prefix("unknown field `") {
        let name = name.trim_end_matches("`, ");
        names.retain(|part| *part != name);
        let place = match names[..] {
            [] => place,
            [section] if place == "the file" => section.to_owned(),
            _ => format!("{place}, {}", names.join(".")),
        };
        let known = expected.split('`').skip(1).step_by(2).map(str::to_owned);
        return unknown(&place, name, known.collect());
    }
    if let Some(name) = message.strip_prefix("missing field `") {
        names.push(name.trim_end_matches('`'));
        return refused(&place, &names.join("."), "left out", "given");
    }
    let rule = match expected {
        "f64" => "a number",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        other => other,
    };
    let value = value.map_or_else(String::new, Value::to_string);
    if names.is_empty() {
        return PathError::Format(format!("{place} must be {rule}, not {value}"));
    }
    if place == "the file" && names.len() == 2 {
        place = names.remove(0).to_owned();
    }
    refused(&place, &names.join("."), value, rule)
}
