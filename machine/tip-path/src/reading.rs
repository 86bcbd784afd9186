//! Reads and checks a path from text or a built-in one, for the FMU, Python and the studies.

use crate::error::{PathError, refused};
use crate::file::{MotionLimits, PathFile, Points, Sample, Waypoint, in_laps};
use crate::iso9283::{Iso9283, TestKind};
use crate::{csv_file, json_file};
use model_rules::Range;
use nalgebra::Vector3;

/// Name of the built-in path that moves all six joints: up to 2 m/s², rotations of more than 60°,
/// rods up to their rated speed.
pub const SIX_JOINTS: &str = "six-joints";
/// Name of the built-in path that passes the paper's triangle six times.
pub const TRIANGLE: &str = "triangle-laps";
/// Names of the built-in paths.
pub const BUILT_IN: [&str; 4] = ["iso9283-cube", "iso9283-rectangle", SIX_JOINTS, TRIANGLE];

/// Distance, m and rad, below which two waypoints count as the same.
const SAME: f64 = 1e-9;
/// Rest at a pose of a test, s, in which the tip settles.
const REST: f64 = 1.0;

impl PathFile {
    /// Reads a file's text: JSON if it begins with a brace, otherwise CSV.
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

    /// The built-in path `name`: [`SIX_JOINTS`], [`TRIANGLE`], `iso9283-cube`, or `iso9283-cube:3` with another
    /// number of cycles; None for any other text.
    pub fn built_in(name: &str) -> Option<Result<Self, PathError>> {
        if name == SIX_JOINTS {
            return Some(Self::parse(include_str!("../paths/six_joints.json")));
        }
        if name == TRIANGLE {
            return Some(Self::parse(include_str!("../paths/triangle_laps.json")));
        }
        Iso9283::named(name).map(|test| test.map(test_path))
    }

    fn check(&self) -> Result<(), PathError> {
        for (name, value) in self.limits.fields() {
            check("limits", name, value, Range::Positive)?;
        }
        match &self.points {
            Points::Waypoints(waypoints) => check_waypoints(waypoints),
            Points::Samples(samples) => check_samples(samples),
        }
    }
}

/// The path of an ISO 9283 test; it ends where its first cycle began.
fn test_path(test: Iso9283) -> PathFile {
    let points = test.points();
    let dwell = match test.kind {
        TestKind::Poses => REST,
        TestKind::Lines => 0.0,
    };
    let at = |position: &Vector3<f64>| Waypoint {
        position: *position,
        dwell,
        ..Waypoint::default()
    };
    let waypoints: Vec<_> = points.iter().map(at).collect();
    PathFile {
        points: Points::Waypoints(in_laps(&waypoints, test.cycles)),
        relative: true,
        limits: MotionLimits::DEFAULT,
        laps: Some(test.cycles),
        test: Some(test),
    }
}

fn check_waypoints(waypoints: &[Waypoint]) -> Result<(), PathError> {
    at_least_two(waypoints.len(), "waypoint(s)")?;
    let mut earlier = 0.0;
    for (k, waypoint) in (1..).zip(waypoints) {
        let place = format!("waypoint {k}");
        finite(&place, "position", waypoint.position.as_slice())?;
        check(&place, "dwell", waypoint.dwell, Range::NotNegative)?;
        check(&place, "blend", waypoint.blend, Range::NotNegative)?;
        if let Some(speed) = waypoint.speed {
            check(&place, "speed", speed, Range::Positive)?;
        }
        if let Some(time) = waypoint.time {
            if !(time.is_finite() && time >= earlier) {
                let rule = format!("finite and not before the waypoints before it, {earlier} s");
                return Err(refused(&place, "time", time, rule));
            }
            earlier = time;
        }
        if let Some(load) = waypoint.load {
            check(&place, "load.mass", load.mass, Range::NotNegative)?;
            finite(&place, "load.com", &load.com)?;
            check(&place, "load.over", waypoint.over, Range::NotNegative)?;
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

fn finite(place: &str, name: &str, values: &[f64]) -> Result<(), PathError> {
    let mut values = values.iter();
    values.try_for_each(|value| check(place, name, *value, Range::Finite))
}

fn check(place: &str, name: &str, value: f64, range: Range) -> Result<(), PathError> {
    if range.contains(value) {
        return Ok(());
    }
    Err(refused(place, name, value, range.rule()))
}
