//! What a path file says.

use crate::error::PathError;
use crate::iso9283::Iso9283;
use crate::{csv_file, json_file};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// How far a quaternion's length may be from 1: files carry a few digits.
const UNIT: f64 = 1e-3;
/// Waypoints nearer to each other than this, m and rad, are the same.
const SAME: f64 = 1e-9;

/// A path as its file gives it, checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathFile {
    /// Its points.
    pub points: Points,
    /// Whether positions count from where the tip starts, along the world's axes.
    pub relative: bool,
    /// How fast the tip may move.
    pub limits: MotionLimits,
    /// The test of ISO 9283 that it is.
    pub test: Option<Iso9283>,
}

/// Points of a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Points {
    /// Straight lines between them, with corners stopped or blended.
    Waypoints(Vec<Waypoint>),
    /// A smooth curve through them at given times.
    Samples(Vec<Sample>),
}

/// A point that the tip goes to in a straight line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Waypoint {
    /// Position, m.
    pub position: Vector3<f64>,
    /// Orientation; None: that of the waypoint before.
    pub orientation: Option<UnitQuaternion<f64>>,
    /// Rest there, s.
    pub dwell: f64,
    /// Largest speed on the way there, m/s; None: that of the path.
    pub speed: Option<f64>,
    /// Time of arrival, s from the path's beginning; None: as soon as the limits allow.
    pub time: Option<f64>,
    /// Distance from the waypoint at which the tip begins to turn to the next, m; 0: it stops.
    pub blend: f64,
    /// What the end-effector carries from the arrival on; None: what it carried.
    pub load: Option<Load>,
    /// Time over which the load comes or goes from the arrival on, s; 0: at once.
    pub over: f64,
}

/// A load that is carried besides the machine's own payload: picked up, or set down with mass 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass from the tip T4, in T4's axes, m.
    pub com: [f64; 3],
}

impl Load {
    /// The part `s` of the way from `before` to this load: masses and first moments change alike,
    /// and a load that comes or goes stays in its place.
    pub(crate) fn after(&self, before: &Self, s: f64) -> Self {
        let mix = |from: f64, to: f64| from + (to - from) * s;
        let mass = mix(before.mass, self.mass);
        let com = match (before.mass, self.mass) {
            (0.0, _) => self.com,
            (_, 0.0) => before.com,
            (a, b) => std::array::from_fn(|i| mix(a * before.com[i], b * self.com[i]) / mass),
        };
        Self { mass, com }
    }
}

/// Where the tip is at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time, s.
    pub t: f64,
    /// Position, m.
    pub position: Vector3<f64>,
    /// Orientation, in all samples or in none.
    pub orientation: Option<UnitQuaternion<f64>>,
}

/// Largest speeds, accelerations and jerks of the tip on the way between waypoints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MotionLimits {
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: f64,
    /// m/s³.
    pub jerk: f64,
    /// rad/s.
    pub angular_speed: f64,
    /// rad/s².
    pub angular_acceleration: f64,
    /// rad/s³.
    pub angular_jerk: f64,
}

impl MotionLimits {
    /// Where a file gives none: a crane's careful motion.
    pub const DEFAULT: Self = Self {
        speed: 0.1,
        acceleration: 0.2,
        jerk: 1.0,
        angular_speed: 0.2,
        angular_acceleration: 0.4,
        angular_jerk: 2.0,
    };

    /// Names and values, in the order of the fields.
    fn fields(&self) -> [(&'static str, f64); 6] {
        [
            ("speed", self.speed),
            ("acceleration", self.acceleration),
            ("jerk", self.jerk),
            ("angular_speed", self.angular_speed),
            ("angular_acceleration", self.angular_acceleration),
            ("angular_jerk", self.angular_jerk),
        ]
    }
}

impl Default for MotionLimits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl PathFile {
    /// Of a file's text: JSON where it begins with a brace, else CSV.
    ///
    /// # Errors
    /// What is wrong where: syntax, an unknown name, a value out of its range, too few or equal
    /// points.
    pub fn parse(text: &str) -> Result<Self, PathError> {
        let text = text.trim_start_matches('\u{feff}');
        let file = if text.trim_start().starts_with(['{', '[']) {
            json_file::parse(text)?
        } else {
            csv_file::parse(text)?
        };
        file.check()?;
        Ok(file)
    }

    /// Of the name of a built-in path, as `iso9283-cube` or `iso9283-cube:3` with another number of
    /// cycles; None for another text.
    ///
    /// # Errors
    /// A number of cycles that is none.
    pub fn built_in(name: &str) -> Option<Result<Self, PathError>> {
        Iso9283::named(name).map(|test| test.map(Iso9283::path))
    }

    fn check(&self) -> Result<(), PathError> {
        for (name, value) in self.limits.fields() {
            positive("limits", name, value)?;
        }
        match &self.points {
            Points::Waypoints(waypoints) => check_waypoints(waypoints),
            Points::Samples(samples) => check_samples(samples),
        }
    }
}

fn check_waypoints(waypoints: &[Waypoint]) -> Result<(), PathError> {
    at_least_two(waypoints.len(), "waypoint(s)")?;
    let mut earlier = 0.0;
    for (k, waypoint) in (1..).zip(waypoints) {
        let place = format!("waypoint {k}");
        finite(&place, "position", waypoint.position.as_slice())?;
        not_negative(&place, "dwell", waypoint.dwell)?;
        not_negative(&place, "blend", waypoint.blend)?;
        if let Some(speed) = waypoint.speed {
            positive(&place, "speed", speed)?;
        }
        if let Some(time) = waypoint.time {
            if !(time.is_finite() && time >= earlier) {
                let rule = format!("finite and not before the waypoints before it, {earlier} s");
                return Err(refused(&place, "time", time, rule));
            }
            earlier = time;
        }
        if let Some(load) = waypoint.load {
            not_negative(&place, "load.mass", load.mass)?;
            finite(&place, "load.com", &load.com)?;
            not_negative(&place, "load.over", waypoint.over)?;
            if waypoint.over > waypoint.dwell {
                let rule = format!(
                    "at most the `dwell`, {} s: the tip rests meanwhile",
                    waypoint.dwell
                );
                return Err(refused(&place, "load.over", waypoint.over, rule));
            }
        }
        if waypoint.blend > 0.0 {
            let stops = [
                (waypoint.dwell > 0.0, "it has a `dwell`"),
                (waypoint.load.is_some(), "a `load` changes there"),
                (k == waypoints.len(), "the path ends there"),
            ];
            if let Some((_, why)) = stops.into_iter().find(|(stops, _)| *stops) {
                let rule = format!("0, because {why} and the tip stops");
                return Err(refused(&place, "blend", waypoint.blend, rule));
            }
        }
    }
    let is_same = |pair: &[Waypoint]| {
        let turned = match (pair[0].orientation, pair[1].orientation) {
            (_, None) => false,
            (None, Some(_)) => true,
            (Some(a), Some(b)) => (a.inverse() * b).imag().norm() > SAME,
        };
        (pair[1].position - pair[0].position).norm() <= SAME && !turned
    };
    match waypoints.windows(2).position(is_same) {
        Some(k) => Err(PathError::Same { first: k + 1 }),
        None => Ok(()),
    }
}

fn check_samples(samples: &[Sample]) -> Result<(), PathError> {
    at_least_two(samples.len(), "sample(s)")?;
    for (k, sample) in (1..).zip(samples) {
        let place = format!("sample {k}");
        finite(&place, "t", &[sample.t])?;
        finite(&place, "position", sample.position.as_slice())?;
        if sample.orientation.is_some() != samples[0].orientation.is_some() {
            let rule = "given in all samples or in none".to_owned();
            return Err(refused(&place, "orientation", "left out", rule));
        }
    }
    for (k, pair) in (2..).zip(samples.windows(2)) {
        if pair[1].t <= pair[0].t {
            let rule = format!("later than that of the sample before, {} s", pair[0].t);
            return Err(refused(&format!("sample {k}"), "t", pair[1].t, rule));
        }
    }
    Ok(())
}

fn at_least_two(count: usize, what: &'static str) -> Result<(), PathError> {
    if count < 2 {
        return Err(PathError::TooFew { count, what });
    }
    Ok(())
}

pub(crate) fn refused(
    place: &str,
    name: &str,
    value: impl std::fmt::Display,
    rule: impl Into<String>,
) -> PathError {
    PathError::Value {
        place: place.to_owned(),
        name: name.to_owned(),
        value: value.to_string(),
        rule: rule.into(),
    }
}

pub(crate) fn finite(place: &str, name: &str, values: &[f64]) -> Result<(), PathError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(refused(place, name, value, "a finite number")),
        None => Ok(()),
    }
}

fn not_negative(place: &str, name: &str, value: f64) -> Result<(), PathError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(refused(place, name, value, "finite and at least 0"))
}

fn positive(place: &str, name: &str, value: f64) -> Result<(), PathError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(refused(place, name, value, "finite and greater than 0"))
}

/// A quaternion w, x, y, z of length 1.
pub(crate) fn unit(place: &str, [w, x, y, z]: [f64; 4]) -> Result<UnitQuaternion<f64>, PathError> {
    let q = Quaternion::new(w, x, y, z);
    let length = q.norm();
    if (length - 1.0).abs() <= UNIT {
        return Ok(UnitQuaternion::new_normalize(q));
    }
    let rule = format!("a quaternion w, x, y, z of length 1; its length is {length:.4}");
    Err(refused(
        place,
        "orientation",
        format_args!("[{w}, {x}, {y}, {z}]"),
        rule,
    ))
}

/// Likeness from which on a name is proposed for another.
const LIKE: f64 = 0.7;

/// The error for a name that is not `known`.
pub(crate) fn unknown(place: &str, name: &str, known: Vec<String>) -> PathError {
    let likeness = |other: &&String| strsim::jaro_winkler(&name.to_lowercase(), other);
    let best = known
        .iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    PathError::Unknown {
        place: place.to_owned(),
        name: name.to_owned(),
        near: best.filter(|best| likeness(best) >= LIKE).cloned(),
        known,
    }
}
