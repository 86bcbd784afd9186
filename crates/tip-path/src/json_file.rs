//! Path files as JSON.

use crate::error::PathError;
use crate::file::{Load, MotionLimits, PathFile, Points, Sample, Waypoint, refused, unit, unknown};
use serde_json::{Map, Value};

const KEYS: [&str; 4] = ["waypoints", "samples", "relative", "limits"];
const WAYPOINT: [&str; 7] = [
    "position",
    "orientation",
    "dwell",
    "speed",
    "time",
    "blend",
    "load",
];
const LOAD: [&str; 3] = ["mass", "com", "over"];

/// Reads a path; its values are not checked yet.
pub(crate) fn parse(text: &str) -> Result<PathFile, PathError> {
    let value: Value =
        serde_json::from_str(text).map_err(|e| PathError::Format(format!("path JSON: {e}")))?;
    let file = Object::of(&value, "the file", &KEYS)?;
    let points = match (file.get("waypoints"), file.get("samples")) {
        (Some(list), None) => Points::Waypoints(each(list, "waypoint", waypoint)?),
        (None, Some(list)) => Points::Samples(each(list, "sample", sample)?),
        _ => {
            let text = "a path must have either `waypoints` or `samples`".to_owned();
            return Err(PathError::Format(text));
        }
    };
    let relative = match file.get("relative") {
        None => false,
        Some(Value::Bool(relative)) => *relative,
        Some(other) => return Err(refused("the file", "relative", other, "true or false")),
    };
    let mut limits = MotionLimits::DEFAULT;
    if let Some(value) = file.get("limits") {
        let known = limits.fields().map(|(name, _)| name);
        let given = Object::of(value, "limits", &known)?;
        for (name, limit) in limits.fields() {
            *limit = given.number(name)?.unwrap_or(*limit);
        }
    }
    Ok(PathFile {
        points,
        relative,
        limits,
        test: None,
    })
}

fn waypoint(value: &Value, place: &str) -> Result<Waypoint, PathError> {
    let given = Object::of(value, place, &WAYPOINT)?;
    let position = given.numbers::<3>("position")?;
    let position = position.ok_or_else(|| refused(place, "position", "left out", "given"))?;
    let (mut load, mut over) = (None, 0.0);
    if let Some(value) = given.get("load") {
        let load_place = format!("{place}, load");
        let given = Object::of(value, &load_place, &LOAD)?;
        let mass = given.number("mass")?;
        load = Some(Load {
            mass: mass.ok_or_else(|| refused(place, "load.mass", "left out", "given"))?,
            com: given.numbers("com")?.unwrap_or_default(),
        });
        over = given.number("over")?.unwrap_or(0.0);
    }
    Ok(Waypoint {
        position: position.into(),
        orientation: (given.numbers("orientation")?)
            .map(|q| unit(place, q))
            .transpose()?,
        dwell: given.number("dwell")?.unwrap_or(0.0),
        speed: given.number("speed")?,
        time: given.number("time")?,
        blend: given.number("blend")?.unwrap_or(0.0),
        load,
        over,
    })
}

/// `[t, x, y, z]` or `[t, x, y, z, qw, qx, qy, qz]`.
fn sample(value: &Value, place: &str) -> Result<Sample, PathError> {
    let rule = "[t, x, y, z] or [t, x, y, z, qw, qx, qy, qz], all numbers";
    let refuse = || refused(place, "samples", value, rule);
    let list = value.as_array().ok_or_else(refuse)?;
    let numbers = list.iter().map(|v| v.as_f64().ok_or_else(refuse));
    let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
    let (&t, [x, y, z], orientation) = match &numbers[..] {
        [t, x, y, z] => (t, [*x, *y, *z], None),
        [t, x, y, z, q @ ..] => {
            let q = <[f64; 4]>::try_from(q).map_err(|_| refuse())?;
            (t, [*x, *y, *z], Some(unit(place, q)?))
        }
        _ => return Err(refuse()),
    };
    Ok(Sample {
        t,
        position: [x, y, z].into(),
        orientation,
    })
}

fn each<T>(
    list: &Value,
    what: &str,
    read: impl Fn(&Value, &str) -> Result<T, PathError>,
) -> Result<Vec<T>, PathError> {
    let Some(list) = list.as_array() else {
        return Err(PathError::Format(format!("`{what}s` must be a list")));
    };
    let numbered = (1..).zip(list);
    numbered
        .map(|(k, value)| read(value, &format!("{what} {k}")))
        .collect()
}

/// An object of which all keys are known.
struct Object<'a> {
    place: &'a str,
    fields: &'a Map<String, Value>,
}

impl<'a> Object<'a> {
    fn of(value: &'a Value, place: &'a str, known: &[&'static str]) -> Result<Self, PathError> {
        let Some(fields) = value.as_object() else {
            return Err(PathError::Format(format!(
                "{place} must be an object, not {value}"
            )));
        };
        match fields.keys().find(|key| !known.contains(&key.as_str())) {
            Some(key) => Err(unknown(place, key, known)),
            None => Ok(Self { place, fields }),
        }
    }

    fn get(&self, name: &str) -> Option<&'a Value> {
        self.fields.get(name)
    }

    fn number(&self, name: &str) -> Result<Option<f64>, PathError> {
        let number = |value: &Value| {
            let number = value.as_f64();
            number.ok_or_else(|| refused(self.place, name, value, "a number"))
        };
        self.get(name).map(number).transpose()
    }

    fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, PathError> {
        let Some(value) = self.get(name) else {
            return Ok(None);
        };
        let list = value
            .as_array()
            .map(|list| list.iter().map(Value::as_f64).collect());
        let numbers: Option<Vec<f64>> = list.flatten();
        let array = numbers.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
        let refuse = || refused(self.place, name, value, format!("a list of {N} numbers"));
        array.map(Some).ok_or_else(refuse)
    }
}
