//! Checks for controller and studies, before a path starts, whether the machine can follow it:
//! compares the required motion, forces, currents and voltages with the limits of the machine file.

use crate::error::Place;
use crate::file::{Load, PathFile, Points};
use crate::path::TipPath;
use hdrm::HdrmError;
use machine_file::{AXES, Machine};
use motion_check::{
    AllowedRanges, DemandModel, Kinematics, Margin, NearestPose, Payload, Quantity, Reach,
};
use thiserror::Error;

/// Time between two checked points, s.
const STEP: f64 = 0.01;
/// Largest number of checked points; on paths of more than 500 s they are further apart.
const POINTS: f64 = 50_000.0;
/// A moment between two points is checked too if a speed or an acceleration of the tip exceeds that
/// at both by this factor: a move that is shorter than [`STEP`].
const EXCEEDS: f64 = 1.01;

/// Margin of each quantity, in the order of [`Quantity::all`].
type Margins = [Margin; Quantity::COUNT];

/// Result of the check of a path.
#[derive(Clone, Debug)]
pub struct PathCheck {
    /// Smallest margin of each quantity with its time, s, in the order of [`Quantity::all`].
    pub least: [(f64, Margin); Quantity::COUNT],
    /// Root mean square of the motor torques over the path, N·m.
    pub torque_rms: [f64; 3],
    /// What the machine cannot do, in order of time.
    pub findings: Vec<Finding>,
}

/// A reason why the machine cannot follow the path.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Finding {
    /// A waypoint or sample farther away than the stretched arm.
    #[error(
        "{point} is {distance:.3} m from the lift joint, out of reach: it must be within {reach:.3} m, {:.3} m nearer",
        distance - reach
    )]
    Reach {
        /// "waypoint" or "sample" with its number.
        point: String,
        /// Distance from the lift joint, m.
        distance: f64,
        /// Length of the stretched arm, m.
        reach: f64,
    },
    /// A pose for which no joint angles were found, or where the arm is singular.
    #[error("{place}, t = {t:.2} s: {}", unreached(nearest))]
    Pose {
        /// Where on the path.
        place: Place,
        /// Time, s.
        t: f64,
        /// The nearest pose; None: the arm is singular there.
        nearest: Option<NearestPose>,
    },
    /// A limit that is exceeded.
    #[error("{place}, t = {t:.2} s: {worst}{}", later(*t, *t_worst))]
    Limit {
        /// Where it is first exceeded.
        place: Place,
        /// Time at which it is first exceeded, s.
        t: f64,
        /// Value and limit where it is exceeded most.
        worst: Margin,
        /// Time at which it is exceeded most, s.
        t_worst: f64,
    },
    /// A motor that would overheat if the path were repeated.
    #[error(
        "motor torque of {}: root mean square {rms:.2} N.m over the path must be at most the rated {rated} N.m: {:.2} N.m beyond ({:.1} %)",
        AXES[*axis], rms - rated, 100.0 * (rms / rated - 1.0)
    )]
    Torque {
        /// 0 slew, 1 lift, 2 tilt.
        axis: usize,
        /// Root mean square over the path, N·m.
        rms: f64,
        /// Rated torque, N·m.
        rated: f64,
    },
}

fn unreached(nearest: &Option<NearestPose>) -> String {
    match nearest {
        Some(nearest) => format!(
            "no joint angles reach this pose; the nearest that were found are {:.1} mm and {:.2} deg off",
            1e3 * nearest.distance,
            nearest.angle.to_degrees()
        ),
        None => "the arm is singular in this pose, its joints cannot follow the tip".into(),
    }
}

fn later(t: f64, t_worst: f64) -> String {
    match t_worst == t {
        true => String::new(),
        false => format!(" at t = {t_worst:.2} s"),
    }
}

/// Checks `path`, made from `file`, for the nominal machine with its payload, starting at the joint
/// angles `zeta`, rad. Calls `observe` with time and margins of each checked point.
pub fn check(
    file: &PathFile,
    path: &TipPath,
    machine: &Machine,
    zeta: &[f64; 6],
    mut observe: impl FnMut(f64, &Margins),
) -> Result<PathCheck, HdrmError> {
    let kinematics = Kinematics::new(machine)?;
    let limits = AllowedRanges::from_machine(machine);
    let start = kinematics.pose(zeta);
    let mut carried = None;
    let mut capability = loaded(machine, None)?;
    let mut log = Log::new(out_of_reach(file, machine, start.position.into()));
    let mut near = *zeta;
    let mut before = 0.0;
    for t in times(path) {
        let load = path.load(t);
        if load != carried {
            carried = load;
            capability = loaded(machine, load)?;
        }
        let stopped = |nearest| {
            let place = path.place(t);
            Some(Finding::Pose { place, t, nearest })
        };
        let tip = path.at(t);
        let angles = match kinematics.inverse(&tip.pose, &near) {
            Ok(angles) => angles,
            Err(nearest) => {
                log.stopped = stopped(Some(nearest));
                break;
            }
        };
        near = angles;
        let Some(motion) = kinematics.motion(&tip, &angles) else {
            log.stopped = stopped(None);
            break;
        };
        let demand = capability.demand(&motion);
        let margins = limits.margins(&demand);
        log.add(path, t, &margins, &demand.tau_e, t - before);
        before = t;
        observe(t, &margins);
    }
    Ok(log.finish(machine.ratings.in_order().map(|r| r.motor_torque)))
}

/// The checked times, s: evenly spaced ones, and what moves are shorter than the time between them.
fn times(path: &TipPath) -> Vec<f64> {
    let count = (path.duration() / STEP).ceil().clamp(1.0, POINTS);
    // Speed and acceleration, linear and angular.
    let sizes = |t: f64| -> [f64; 4] {
        let tip = path.at(t);
        let rates = [tip.velocity, tip.acceleration];
        std::array::from_fn(|k| rates[k / 2].fixed_rows::<3>(3 * (k % 2)).norm())
    };
    let mut extremes = path.extremes().into_iter().peekable();
    let mut times = vec![0.0];
    let mut last = sizes(0.0);
    for k in 1..=count as u32 {
        let t = path.duration() * (f64::from(k) / count);
        let next = sizes(t);
        let mut most: [_; 4] = std::array::from_fn(|k| (EXCEEDS * last[k].max(next[k]), None));
        while let Some(between) = extremes.next_if(|between| *between < t) {
            for (most, found) in most.iter_mut().zip(sizes(between)) {
                if found > most.0 {
                    *most = (found, Some(between));
                }
            }
        }
        let from = times.len();
        times.extend(most.iter().filter_map(|(_, between)| *between));
        times[from..].sort_by(f64::total_cmp);
        times.push(t);
        last = next;
    }
    times.dedup();
    times
}

/// Findings for waypoints or samples farther from the lift joint than the stretched arm.
fn out_of_reach(file: &PathFile, machine: &Machine, start: [f64; 3]) -> Vec<Finding> {
    let reach = Reach::new(&machine.geometry);
    let (what, positions): (_, Vec<_>) = match &file.points {
        Points::Waypoints(list) => ("waypoint", list.iter().map(|w| w.position).collect()),
        Points::Samples(list) => ("sample", list.iter().map(|s| s.position).collect()),
    };
    let offset = if file.relative { start } else { [0.0; 3] };
    let each = (1..).zip(positions).filter_map(|(k, position)| {
        let distance = reach.distance((position + nalgebra::Vector3::from(offset)).into());
        (distance > reach.length()).then(|| Finding::Reach {
            point: format!("{what} {k}"),
            distance,
            reach: reach.length(),
        })
    });
    each.collect()
}

/// Inverse dynamics of the machine with its payload and `load`.
fn loaded(machine: &Machine, load: Option<Load>) -> Result<DemandModel, HdrmError> {
    let own = Payload::from_machine(machine);
    match load {
        Some(load) if load.mass > 0.0 => DemandModel::with_load(machine, &own, load.mass, load.com),
        _ => DemandModel::new(machine, &own),
    }
}

/// Results up to the present point.
struct Log {
    reach: Vec<Finding>,
    least: [(f64, Margin); Quantity::COUNT],
    /// Where and when each limit was first exceeded.
    first: [Option<(Place, f64)>; Quantity::COUNT],
    stopped: Option<Finding>,
    /// Integral of the motors' squared torques, (N·m)²·s, and the time over which it goes, s.
    squares: [f64; 3],
    over: f64,
    is_empty: bool,
}

impl Log {
    fn new(reach: Vec<Finding>) -> Self {
        let nothing = |quantity| {
            let held = Margin {
                quantity,
                value: 0.0,
                range: [f64::NEG_INFINITY, f64::INFINITY],
            };
            (0.0, held)
        };
        Self {
            reach,
            least: Quantity::all().map(nothing),
            first: [None; Quantity::COUNT],
            stopped: None,
            squares: [0.0; 3],
            over: 0.0,
            is_empty: true,
        }
    }

    /// Adds the point at `t`, `dt` after the last one, s.
    fn add(&mut self, path: &TipPath, t: f64, margins: &Margins, tau_e: &[f64; 3], dt: f64) {
        for (k, margin) in margins.iter().enumerate() {
            // NaN counts as the smallest margin.
            let (least, part) = (&mut self.least[k], margin.part());
            if self.is_empty || part.is_nan() || part < least.1.part() {
                *least = (t, *margin);
            }
            if !margin.holds() && self.first[k].is_none() {
                self.first[k] = Some((path.place(t), t));
            }
        }
        for (square, tau) in self.squares.iter_mut().zip(tau_e) {
            *square += tau * tau * dt;
        }
        self.over += dt;
        self.is_empty = false;
    }

    fn finish(self, rated: [f64; 3]) -> PathCheck {
        let torque_rms = self
            .squares
            .map(|sum| (sum / self.over.max(f64::MIN_POSITIVE)).sqrt());
        let mut limits = Vec::new();
        for (first, (t_worst, worst)) in self.first.into_iter().zip(self.least) {
            if let Some((place, t)) = first {
                let limit = Finding::Limit {
                    place,
                    t,
                    worst,
                    t_worst,
                };
                limits.push((t, limit));
            }
        }
        limits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let limits = limits.into_iter().map(|(_, limit)| limit);
        let hot = (0..3).filter(|&axis| torque_rms[axis] > rated[axis]);
        let hot = hot.map(|axis| Finding::Torque {
            axis,
            rms: torque_rms[axis],
            rated: rated[axis],
        });
        let findings = self.reach.into_iter().chain(limits).chain(self.stopped);
        PathCheck {
            least: self.least,
            torque_rms,
            findings: findings.chain(hot).collect(),
        }
    }
}

/// Number of findings that a message lists.
const LISTED: usize = 5;

impl PathCheck {
    /// Message why the machine cannot follow the path; None if it can.
    pub fn refusal(&self) -> Option<String> {
        if self.findings.is_empty() {
            return None;
        }
        let listed = Vec::from_iter(self.findings.iter().take(LISTED).map(Finding::to_string));
        let more = match self.findings.len().saturating_sub(LISTED) {
            0 => String::new(),
            more => format!("; and {more} more"),
        };
        Some(format!(
            "the machine cannot do this path: {}{more}",
            listed.join("; ")
        ))
    }
}
