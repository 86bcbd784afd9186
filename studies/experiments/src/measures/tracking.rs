//! Tracking errors of a run: how much of the tip's error the controller could have known, and how
//! far the plant's tip really was from the reference. For analyses, ended runs and Python.
//!
//! There are three errors of the tip's position, each between the reference and
//! - `known`: the controller's own kinematics at the joint angles as its encoders read them, with
//!   their zero errors but without noise and rounding: the part that a controller which measures
//!   joint angles can bring to zero;
//! - `joints`: the controller's own kinematics at the true joint angles;
//! - `plant`: the tip of the plant; errors of dimensions and encoder zeros mostly shift it.
//!
//! A plant that bends also reports where its tip would be if nothing bent: `rigid`.
//!
//! Zero errors are the mean difference of measured and true angles at rest before the motion.

use anyhow::{Context, Result};
use cosim::{Experiment, Port, Recording, System, start_value};
use hdrm::{Tip, Tree};
use nalgebra::{Quaternion, Vector3};
use serde::Serialize;

use super::run::{Distance, RecordedRun};
use crate::setup::machine_choice::MachineFile;

/// Joints of the manipulator.
const JOINTS: usize = 6;

/// An error of the tip's position over the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PositionError {
    /// Root mean square, m.
    pub rmse: f64,
    /// Largest, m.
    pub max: f64,
    /// Length of the mean error vector, m: the constant part.
    pub mean: f64,
    /// Root mean square of the error without its mean vector, m.
    pub varying: f64,
}

/// Tracking errors of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tracking {
    /// Error that the controller could have known.
    pub known: PositionError,
    /// Error by the controller's kinematics at the true joint angles.
    pub joints: PositionError,
    /// Error of the plant's tip.
    pub plant: PositionError,
    /// Root mean square and maximum of the angle between desired and true orientation, rad.
    pub orientation: [f64; 2],
    /// Largest speed of the plant's tip, m/s.
    pub speed: f64,
    /// Deflection, if the plant bends.
    #[serde(skip_serializing_if = "Option::is_none", rename = "bent")]
    pub sag: Option<Sag>,
    /// Root mean square of the known error of each lap, m, on a path of equal laps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub laps: Vec<f64>,
}

/// Deflection of a plant that bends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Sag {
    /// Error of the rigid tip: that of the plant's joints and dimensions if nothing bent.
    pub rigid: PositionError,
    /// Root mean square of the distance between tip and rigid tip, m.
    #[serde(rename = "sag_rms")]
    pub rms: f64,
    /// Largest such distance, m.
    #[serde(rename = "sag_max")]
    pub max: f64,
}

impl Tracking {
    /// The field's indicator for heavy-duty manipulators: largest known error divided by largest
    /// speed, s; smaller is better. It compares machines of different size and speed.
    pub fn rho(&self) -> f64 {
        self.known.max / self.speed
    }

    /// Runs and evaluates the motion; also returns the run, in which `more` is recorded too.
    pub fn record(
        system: &System,
        experiment: &Experiment,
        more: &[Port],
    ) -> Result<(Self, RecordedRun)> {
        let evaluation = Evaluation::new(system, experiment)?;
        let ports = [&evaluation.ports(), more].concat();
        let recorded = RecordedRun::record(system, experiment, &ports)?;
        let start = recorded.outcome.tip.motion_start;
        let tracking = evaluation.evaluate(&recorded.recording, start)?;
        Ok((tracking, recorded))
    }
}

/// The variables and parameters by which a run is evaluated; found before the run.
pub struct Evaluation {
    /// Desired position and orientation.
    desired: Vec<Port>,
    /// True joint angles, and those that the controller measures.
    zeta: [Vec<Port>; 2],
    /// Position, orientation and velocity of the plant's tip.
    tip: Vec<Port>,
    /// Rigid tip of a plant that bends; empty for other plants.
    rigid: Vec<Port>,
    /// Lap under way.
    lap: Option<Port>,
    /// The controller's kinematics.
    tree: Tree,
    /// Communication points by which the desired pose is ahead of the other values.
    late: usize,
}

impl Evaluation {
    /// For runs of `experiment` on `system`.
    pub fn new(system: &System, experiment: &Experiment) -> Result<Self> {
        let controller = system.port("desired.position[1]")?.component;
        let plant = system.port("tip.position[1]")?.component;
        let arrays = |component, names: &[(&str, usize)]| -> Result<Vec<Port>> {
            let all = names
                .iter()
                .map(|(n, count)| system.elements(component, n, *count));
            Ok(all.collect::<Result<Vec<_>>>()?.concat())
        };
        let wiring = system.wiring()?;
        let mut measured = Vec::new();
        for port in system.elements(controller, "zeta", JOINTS)? {
            let link = wiring.driver(port).context("nothing measures the joints")?;
            measured.push(wiring.links[link].from);
        }
        let file = system.port_of(controller, "machine_file")?;
        let nominal = MachineFile::from_parameter(system, &experiment.settings, file)?;
        let delay = system.port_of(controller, "delay")?;
        let delay = start_value(system, &experiment.settings, delay)?;
        let desired = [("desired.position", 3), ("desired.orientation", 4)];
        let tip = [
            ("tip.position", 3),
            ("tip.orientation", 4),
            ("tip.velocity", 3),
        ];
        Ok(Self {
            desired: arrays(controller, &desired)?,
            zeta: [system.elements(plant, "zeta", JOINTS)?, measured],
            tip: arrays(plant, &tip)?,
            rigid: (system.elements(plant, "tip.rigid_position", 3)).unwrap_or_default(),
            lap: system.port_of(controller, "lap").ok(),
            tree: Tree::new(&nominal.machine)?,
            // A delay of one step is predicted over: those outputs belong to the point of reading.
            late: (delay - 1.0).max(0.0) as usize,
        })
    }

    /// The variables that must be recorded at every communication point.
    pub fn ports(&self) -> Vec<Port> {
        let mut ports = [&self.desired[..], &self.zeta[0], &self.tip, &self.rigid].concat();
        ports.extend(self.zeta[1].iter().filter(|p| !self.zeta[0].contains(p)));
        ports.extend(self.lap);
        ports
    }

    /// Errors over the motion, which begins at `motion_start`, s, of a run that recorded
    /// [`Evaluation::ports`].
    pub fn evaluate(&self, recording: &Recording, motion_start: f64) -> Result<Tracking> {
        let (first, tree) = (recording.first_from(motion_start), &self.tree);
        let columns = |ports: &[Port]| -> Result<Vec<&[f64]>> {
            ports.iter().map(|p| recording.column(*p)).collect()
        };
        let desired = columns(&self.desired)?;
        let [true_zeta, measured] = [columns(&self.zeta[0])?, columns(&self.zeta[1])?];
        let (tip, rigid) = (columns(&self.tip)?, columns(&self.rigid)?);
        let zero = |(measured, own): (&&[f64], &&[f64])| mean_difference(measured, own, first);
        let zero: Vec<f64> = measured.iter().zip(&true_zeta).map(zero).collect();
        let vector = |c: &[&[f64]], row: usize| Vector3::new(c[0][row], c[1][row], c[2][row]);
        let quaternion =
            |c: &[&[f64]], row: usize| Quaternion::new(c[3][row], c[4][row], c[5][row], c[6][row]);
        let mut sums = [Sum::default(); 3];
        let mut orientation = Distance::default();
        let mut speed: f64 = 0.0;
        let lap = self.lap.map(|port| recording.column(port)).transpose()?;
        let mut laps: Vec<Distance> = Vec::new();
        let (mut to_rigid, mut sagging) = (Sum::default(), Distance::default());
        for (k, _) in recording.times.iter().enumerate().skip(first) {
            let seen = k.saturating_sub(self.late);
            let reference = vector(&desired, seen);
            let own = |share: f64| {
                let zeta = std::array::from_fn(|j| true_zeta[j][k] + share * zero[j]);
                Tip::new(tree, &tree.configuration(&zeta)).position
            };
            let places = [own(1.0), own(0.0), vector(&tip, k)];
            let number = lap.map_or(0, |lap| lap[seen] as usize);
            if number > 0 {
                laps.resize(laps.len().max(number), Distance::default());
                laps[number - 1].add((reference - places[0]).norm());
            }
            for (sum, place) in sums.iter_mut().zip(places) {
                sum.add(reference - place);
            }
            if !rigid.is_empty() {
                to_rigid.add(reference - vector(&rigid, k));
                sagging.add((vector(&tip, k) - vector(&rigid, k)).norm());
            }
            let cosine = quaternion(&desired, seen).dot(&quaternion(&tip, k));
            orientation.add(2.0 * cosine.abs().min(1.0).acos());
            speed = speed.max(vector(&tip[7..], k).norm());
        }
        let [known, joints, plant] = sums.map(|sum| sum.error());
        Ok(Tracking {
            laps: laps.iter().map(Distance::rms).collect(),
            known,
            joints,
            plant,
            orientation: [orientation.rms(), orientation.max],
            speed,
            sag: (!rigid.is_empty()).then(|| Sag {
                rigid: to_rigid.error(),
                rms: sagging.rms(),
                max: sagging.max,
            }),
        })
    }
}

/// Mean of `a − b` over the first `count` samples, or over all if `count` is 0.
fn mean_difference(a: &[f64], b: &[f64], count: usize) -> f64 {
    let count = if count == 0 { a.len() } else { count };
    a.iter().zip(b).take(count).map(|(a, b)| a - b).sum::<f64>() / count as f64
}

/// Sums over error vectors, from which a [`PositionError`] is computed.
#[derive(Clone, Copy, Default)]
struct Sum {
    vectors: Vector3<f64>,
    distance: Distance,
    count: f64,
}

impl Sum {
    fn add(&mut self, error: Vector3<f64>) {
        self.vectors += error;
        self.distance.add(error.norm());
        self.count += 1.0;
    }

    fn error(&self) -> PositionError {
        let mean = (self.vectors / self.count.max(1.0)).norm();
        let rmse = self.distance.rms();
        PositionError {
            rmse,
            max: self.distance.max,
            mean,
            varying: (rmse * rmse - mean * mean).max(0.0).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: a constant of (3, 4, 0) plus ±2 along z. A few roundings of 29 = 25 + 4,
    /// divided by 2·2.
    #[test]
    fn the_constant_part_is_told_from_the_rest() {
        let mut sum = Sum::default();
        for z in [2.0, -2.0, 2.0, -2.0] {
            sum.add(Vector3::new(3.0, 4.0, z));
        }
        let e = sum.error();
        assert_eq!((e.mean, e.max), (5.0, 29.0_f64.sqrt()));
        assert!((e.varying - 2.0).abs() < 29.0 * f64::EPSILON, "{e:?}");
        assert!((e.rmse - e.max).abs() < 8.0 * f64::EPSILON, "{e:?}");
    }

    #[test]
    fn zero_errors_are_taken_from_the_rest() {
        let (a, b) = ([1.5, 1.25, 9.0], [1.0, 1.0, 1.0]);
        assert_eq!(mean_difference(&a, &b, 2), 0.375);
    }
}
