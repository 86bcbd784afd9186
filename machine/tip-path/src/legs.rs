//! Motion along waypoints, for `path`: a leg is a straight line with a rotation, travelled from
//! rest to rest; at a blended corner two legs overlap in time.
//!
//! Position and orientation are sums: `p = p_0 + Σ d_k·s_k(t)` and
//! `q = exp(φ_n·s_n(t))·…·exp(φ_1·s_1(t))·q_0`, with the displacement `d_k`, the rotation vector
//! `φ_k` in world axes and the profile `s_k` of leg k. Where the tip stops, legs follow each other.
//! At a blended corner the next leg begins during the last `blend` metres of the previous one. The
//! acceleration and jerk of both are reduced so that their sum stays within the path's limits. At
//! most two legs overlap, the first in its second half and the second in its first half.

use crate::error::PathError;
use crate::file::{MotionLimits, Waypoint};
use crate::profile::Profile;
use motion_check::{Pose, TipMotion, rotation_vector, turn};
use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// Shortest displacement or rotation, m and rad, that makes a leg.
const SHORTEST: f64 = 1e-9;

/// A straight line with its timing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Leg {
    /// Time at which it begins, s.
    begins: f64,
    profile: Profile,
    way: Way,
}

/// A straight line with a rotation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Way {
    from: Pose,
    /// Displacement, m.
    step: Vector3<f64>,
    /// Rotation vector, rad.
    turn: Vector3<f64>,
}

/// When the tip is at a waypoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stop {
    /// Counted from 1.
    pub waypoint: usize,
    /// Time of arrival, s; the middle of a blended corner.
    pub arrives: f64,
    /// End of the rest, s.
    pub leaves: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Legs {
    start: Pose,
    legs: Vec<Leg>,
}

impl Legs {
    /// Plans the legs from the pose `start` along the waypoints, and their times of arrival.
    pub(crate) fn new(
        start: Pose,
        waypoints: &[Waypoint],
        limits: &MotionLimits,
    ) -> Result<(Self, Vec<Stop>), PathError> {
        let ways = ways(start, waypoints);
        let mut legs: Vec<Leg> = Vec::with_capacity(ways.len());
        let mut stops: Vec<Stop> = Vec::with_capacity(waypoints.len());
        let mut leaves = 0.0;
        for (k, waypoint) in waypoints.iter().enumerate() {
            let place = ways.iter().position(|(waypoint, _)| *waypoint == k);
            let arrives = if let Some(place) = place {
                let way = ways[place].1;
                let fastest = way.profile(waypoint, limits, &lowering(&ways, waypoints, place));
                let longest = match place.checked_sub(1) {
                    Some(before) if waypoints[k - 1].blend > 0.0 => {
                        longest_overlap(&legs[before], waypoints[k - 1].blend)
                    }
                    _ => 0.0, // the tip stops
                };
                let (begins, profile) = schedule(k, waypoint, leaves, fastest, longest)?;
                if let (Some(stop), true) = (stops.last_mut(), longest > 0.0) {
                    // The middle of the corner.
                    stop.arrives = 0.5 * (stop.arrives + begins);
                    stop.leaves = stop.arrives;
                }
                legs.push(Leg {
                    begins,
                    profile,
                    way,
                });
                begins + profile.duration()
            } else {
                leaves.max(waypoint.time.unwrap_or(0.0))
            };
            leaves = arrives + waypoint.dwell;
            stops.push(Stop {
                waypoint: k + 1,
                arrives,
                leaves,
            });
        }
        Ok((Self { start, legs }, stops))
    }

    /// Times at which the acceleration or the speed of a leg is largest, s.
    pub(crate) fn extremes(&self) -> impl Iterator<Item = f64> {
        let of = |leg: &Leg| leg.profile.extremes().map(|t| leg.begins + t);
        self.legs.iter().flat_map(of)
    }

    /// Motion at `t`, s.
    pub(crate) fn at(&self, t: f64) -> TipMotion {
        let next = self.legs.partition_point(|leg| leg.begins <= t);
        let Some(last) = next.checked_sub(1) else {
            return rest(self.start);
        };
        // In a corner the previous leg may still move.
        let first = last.saturating_sub(1);
        let mut motion = rest(self.legs[first].way.from);
        for leg in &self.legs[first..=last] {
            leg.add_to(&mut motion, t);
        }
        motion
    }
}

pub(crate) fn rest(pose: Pose) -> TipMotion {
    TipMotion {
        pose,
        velocity: Vector6::zeros(),
        acceleration: Vector6::zeros(),
    }
}

impl Leg {
    /// Adds this leg to the motion of those before it:
    /// ```text
    /// ω = R·ω_before + φ·ṡ,   ω̇ = R·ω̇_before + φ·s̈ + (φ·ṡ) × (R·ω_before),   R = exp(φ·s)
    /// ```
    fn add_to(&self, motion: &mut TipMotion, t: f64) {
        let [s, v, a] = self.profile.at(t - self.begins);
        let Way {
            step, turn: way, ..
        } = self.way;
        let R = turn(way * s);
        let parts = |vector: &Vector6<f64>| -> (Vector3<f64>, Vector3<f64>) {
            (
                vector.fixed_rows::<3>(0).into(),
                vector.fixed_rows::<3>(3).into(),
            )
        };
        let (velocity, w) = parts(&motion.velocity);
        let (acceleration, w_dot) = parts(&motion.acceleration);
        let (w, w_dot, own) = (R * w, R * w_dot, way * v);
        motion.pose.position += step * s;
        motion.pose.orientation = R * motion.pose.orientation;
        motion.velocity = stacked(velocity + step * v, w + own);
        let turning = w_dot + way * a + own.cross(&w);
        motion.acceleration = stacked(acceleration + step * a, turning);
    }
}

/// The ways between waypoints that differ from the previous one, each with its waypoint's index.
fn ways(start: Pose, waypoints: &[Waypoint]) -> Vec<(usize, Way)> {
    let mut from = start;
    let mut ways = Vec::with_capacity(waypoints.len());
    for (k, waypoint) in waypoints.iter().enumerate() {
        let to = Pose {
            position: waypoint.position,
            orientation: waypoint.orientation.unwrap_or(from.orientation),
        };
        let step = to.position - from.position;
        let turn = rotation_vector(&(to.orientation * from.orientation.inverse()));
        if step.norm() > SHORTEST || turn.norm() > SHORTEST {
            ways.push((k, Way { from, step, turn }));
        }
        from = to;
    }
    ways
}

/// Factors on acceleration and jerk of a way that overlaps with its neighbours in a corner.
struct Lowering {
    acceleration: f64,
    jerk: f64,
}

/// In a corner the first leg brakes while the next accelerates, so the sum of accelerations along
/// the unit directions e is at most `|e_next − e_first|` times the limit; jerks have either sign.
fn lowering(ways: &[(usize, Way)], waypoints: &[Waypoint], place: usize) -> Lowering {
    let mut lowest = Lowering {
        acceleration: 1.0,
        jerk: 1.0,
    };
    let corners = ways.windows(2).enumerate();
    for (k, pair) in corners.filter(|(k, _)| *k == place || k + 1 == place) {
        if waypoints[ways[k].0].blend == 0.0 {
            continue;
        }
        for part in [|way: &Way| way.step, |way: &Way| way.turn] {
            let [a, b] = [&pair[0].1, &pair[1].1].map(|way| part(way).try_normalize(SHORTEST));
            if let (Some(a), Some(b)) = (a, b) {
                let (difference, sum) = ((b - a).norm(), (a + b).norm());
                lowest.acceleration = lowest.acceleration.min(1.0 / difference.max(1.0));
                lowest.jerk = lowest.jerk.min(1.0 / difference.max(sum).max(1.0));
            }
        }
    }
    lowest
}

impl Way {
    /// The fastest profile within the limits.
    fn profile(&self, waypoint: &Waypoint, limits: &MotionLimits, low: &Lowering) -> Profile {
        let speed = waypoint.speed.unwrap_or(limits.speed);
        let (length, angle) = (self.step.norm(), self.turn.norm());
        let rate = |linear: f64, angular: f64| (linear / length).min(angular / angle);
        Profile::fastest(
            rate(speed, limits.angular_speed),
            rate(limits.acceleration, limits.angular_acceleration) * low.acceleration,
            rate(limits.jerk, limits.angular_jerk) * low.jerk,
        )
    }
}

/// Longest overlap of the next leg with `before`, s: its last `blend` metres or second half.
fn longest_overlap(before: &Leg, blend: f64) -> f64 {
    let part = (blend / before.way.step.norm()).min(0.5);
    before.profile.time_to(part)
}

/// Start time and profile of the leg to waypoint `k` (from 0); the tip leaves the previous waypoint
/// at `leaves`, s, and the legs overlap by at most `longest`, s.
fn schedule(
    k: usize,
    waypoint: &Waypoint,
    leaves: f64,
    fastest: Profile,
    longest: f64,
) -> Result<(f64, Profile), PathError> {
    let Some(time) = waypoint.time else {
        let overlap = longest.min(0.5 * fastest.duration());
        return Ok((leaves - overlap, fastest));
    };
    // With the overlap τ the leg has the time − leaves + τ, of which τ is at most half.
    let overlap = longest.min((time - leaves).max(0.0));
    let begins = leaves - overlap;
    let (duration, needs) = (time - begins, fastest.duration());
    // Times in files are rounded.
    if duration < needs * (1.0 - 1e-9) {
        return Err(PathError::TooEarly {
            waypoint: k + 1,
            time,
            leaves: begins,
            needs,
        });
    }
    Ok((begins, fastest.stretched(duration)))
}

fn stacked(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::from_iterator(linear.iter().chain(&angular).copied())
}
