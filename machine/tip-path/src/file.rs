//! Contents of a path file (JSON, CSV, built-in), for planning, check, the FMU, studies and Python.

use crate::iso9283::Iso9283;
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// A path as its file gives it, with checked values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathFile {
    /// Its points.
    pub points: Points,
    /// Whether positions are relative to the tip's start, along the world's axes.
    pub relative: bool,
    /// Limits of speed, acceleration and jerk.
    pub limits: MotionLimits,
    /// Equal laps that its waypoints make; None: they are no laps.
    pub laps: Option<usize>,
    /// The test of ISO 9283 that the path is, if any.
    pub test: Option<Iso9283>,
}

/// Points of a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Points {
    /// Straight lines between the points, with a stop or a blend at each corner.
    Waypoints(Vec<Waypoint>),
    /// A smooth curve through the points at given times.
    Samples(Vec<Sample>),
}

/// A point that the tip moves to in a straight line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Waypoint {
    /// Position, m.
    pub position: Vector3<f64>,
    /// Orientation; None: that of the previous waypoint.
    pub orientation: Option<UnitQuaternion<f64>>,
    /// Time of rest there, s.
    pub dwell: f64,
    /// Largest speed on the way there, m/s; None: that of the path.
    pub speed: Option<f64>,
    /// Time of arrival after the start of the path, s; None: as early as the limits allow.
    pub time: Option<f64>,
    /// Distance from the waypoint at which the tip begins to turn to the next, m; 0: it stops.
    pub blend: f64,
    /// Load after the arrival; None: unchanged.
    pub load: Option<Load>,
    /// Time over which the load changes after the arrival, s; 0: at once.
    pub over: f64,
}

/// A load carried in addition to the machine's own payload; mass 0: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass from the tip T4, in T4's axes, m.
    pub com: [f64; 3],
}

impl Load {
    /// Interpolates from `before` (s = 0) to this load (s = 1): mass and first moment are linear in
    /// `s`; a load that appears or disappears stays in its place.
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

/// Pose of the tip at a given time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time, s.
    pub t: f64,
    /// Position, m.
    pub position: Vector3<f64>,
    /// Orientation; given in all samples or in none.
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
    /// Defaults: careful motion of a crane.
    pub const DEFAULT: Self = Self {
        speed: 0.1,
        acceleration: 0.2,
        jerk: 1.0,
        angular_speed: 0.2,
        angular_acceleration: 0.4,
        angular_jerk: 2.0,
    };

    /// Names and values, in the order of the fields.
    pub(crate) fn fields(&self) -> [(&'static str, f64); 6] {
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

/// The waypoints so many times, and the first once more.
pub(crate) fn in_laps(waypoints: &[Waypoint], laps: usize) -> Vec<Waypoint> {
    let all = laps * waypoints.len() + 1;
    waypoints.iter().copied().cycle().take(all).collect()
}
