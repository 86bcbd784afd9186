//! The planned path, for the controller and the studies: motion and load of the tip over time.

use crate::error::{PathError, Place};
use crate::file::{Load, PathFile, Points, Sample, Waypoint};
use crate::legs::{Legs, Stop, rest};
use crate::spline::Spline;
use motion_check::{Pose, TipMotion};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The motion of the tip from its start pose to the end of a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TipPath {
    /// The whole path of waypoints, or the way to the first sample.
    legs: Legs,
    /// Start time, s, and curve of a sampled path.
    spline: Option<(f64, Spline)>,
    stops: Vec<Stop>,
    /// In order of time.
    loads: Vec<Change>,
    laps: Option<Laps>,
    duration: f64,
}

/// Equal laps of a path: the motion at any time of one is that at the same time of another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Laps {
    /// Begin of the first one, s.
    pub begins: f64,
    /// Duration of each, s.
    pub period: f64,
    /// Number of laps.
    pub count: usize,
}

impl Laps {
    /// End of the last one, s.
    pub fn end(&self) -> f64 {
        self.begins + self.count as f64 * self.period
    }

    /// The lap under way at `t`, s, from 1; 0: none.
    pub fn number(&self, t: f64) -> usize {
        if !(self.begins..self.end()).contains(&t) {
            return 0;
        }
        let past = ((t - self.begins) / self.period) as usize;
        past.min(self.count - 1) + 1
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Change {
    /// Start, s.
    from: f64,
    /// Duration, s.
    over: f64,
    load: Load,
}

impl TipPath {
    /// Plans the path of a file for a tip that rests in the pose `start` and moves to the first
    /// point in a straight line. An error if a time of arrival is too early for the path's limits.
    pub fn new(file: &PathFile, start: Pose) -> Result<Self, PathError> {
        let offset = if file.relative {
            start.position
        } else {
            Vector3::zeros()
        };
        match &file.points {
            Points::Waypoints(waypoints) => Self::along(file, start, offset, waypoints),
            Points::Samples(samples) => Self::through(file, start, offset, samples),
        }
    }

    fn along(
        file: &PathFile,
        start: Pose,
        offset: Vector3<f64>,
        waypoints: &[Waypoint],
    ) -> Result<Self, PathError> {
        let moved = |waypoint: &Waypoint| Waypoint {
            position: waypoint.position + offset,
            ..*waypoint
        };
        let waypoints: Vec<_> = waypoints.iter().map(moved).collect();
        let (legs, stops) = Legs::new(start, &waypoints, &file.limits)?;
        let change = |(waypoint, stop): (&Waypoint, &Stop)| {
            Some(Change {
                from: stop.arrives,
                over: waypoint.over,
                load: waypoint.load?,
            })
        };
        // At the first waypoint the tip stops in each lap.
        let times = stops.first().zip(stops.last());
        let laps = |(count, (first, last)): (usize, (&Stop, &Stop))| Laps {
            begins: first.arrives,
            period: (last.arrives - first.arrives) / count as f64,
            count,
        };
        Ok(Self {
            laps: file.laps.zip(times).map(laps),
            legs,
            spline: None,
            loads: waypoints.iter().zip(&stops).filter_map(change).collect(),
            duration: stops.last().map_or(0.0, |stop| stop.leaves),
            stops,
        })
    }

    fn through(
        file: &PathFile,
        start: Pose,
        offset: Vector3<f64>,
        samples: &[Sample],
    ) -> Result<Self, PathError> {
        let approach = Waypoint {
            position: samples[0].position + offset,
            orientation: samples[0].orientation,
            ..Waypoint::default()
        };
        let (legs, stops) = Legs::new(start, &[approach], &file.limits)?;
        let begins = stops[0].arrives;
        let spline = Spline::new(samples, &start, offset, begins);
        Ok(Self {
            legs,
            duration: spline.end(),
            spline: Some((begins, spline)),
            stops: Vec::new(),
            loads: Vec::new(),
            laps: None,
        })
    }

    /// Time to the end of the last rest, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Equal laps, if it has some.
    pub fn laps(&self) -> Option<Laps> {
        self.laps
    }

    /// Motion of the tip at `t`, s; at rest before the beginning and after the end.
    pub fn at(&self, t: f64) -> TipMotion {
        match &self.spline {
            Some((_, spline)) if t >= self.duration => rest(spline.at(self.duration).pose),
            Some((begins, spline)) if t >= *begins => spline.at(t),
            _ => self.legs.at(t),
        }
    }

    /// Times near which acceleration or speed is largest, s, ascending.
    pub(crate) fn extremes(&self) -> Vec<f64> {
        let mut times = Vec::from_iter(self.legs.extremes());
        times.extend(self.spline.iter().flat_map(|(_, spline)| spline.extremes()));
        times.sort_by(f64::total_cmp);
        times
    }

    /// The load at `t`, s, in addition to the machine's own payload; None before its first change.
    /// It changes smoothly, as 3 p² − 2 p³ of the elapsed part p.
    pub fn load(&self, t: f64) -> Option<Load> {
        let next = self.loads.partition_point(|change| change.from <= t);
        let last = next.checked_sub(1)?;
        let Change { from, over, load } = self.loads[last];
        if t >= from + over {
            return Some(load);
        }
        let before = last.checked_sub(1).map(|k| self.loads[k].load);
        let p = (t - from) / over;
        Some(load.after(&before.unwrap_or_default(), p * p * (3.0 - 2.0 * p)))
    }

    /// When the tip is at each waypoint; empty for a sampled path.
    pub fn stops(&self) -> &[Stop] {
        &self.stops
    }

    /// Where the tip is at `t`, s.
    pub fn place(&self, t: f64) -> Place {
        if let Some((begins, spline)) = &self.spline {
            return if t < *begins {
                Place::Approach
            } else {
                Place::Samples(spline.interval(t) + 1)
            };
        }
        let next = self.stops.iter().find(|stop| stop.leaves >= t);
        match next {
            None => Place::At(self.stops.len()),
            Some(stop) if t >= stop.arrives => Place::At(stop.waypoint),
            Some(stop) if stop.waypoint == 1 => Place::Approach,
            Some(stop) => Place::Between(stop.waypoint - 1),
        }
    }
}
