//! Accuracy and repeatability after ISO 9283:1998 while a run follows one of its test paths: of
//! poses at rest (AP and RP) or of lines (AT and RT); for `run`, `compare` and the report.
//!
//! The attained position is the plant's tip, the commanded one the controller's reference at the
//! same communication point. On lines only the deviation normal to the line counts, as in the
//! standard. With the deviations `d_j` of n cycles at one point
//! ```text
//! accuracy = |d̄|,   repeatability = l̄ + 3·S_l,   l_j = |d_j − d̄|
//! ```
//! and for lines both are the largest over all points.

use std::fmt;

use anyhow::Result;
use cosim::{Experiment, Master, Port, Signals, System};
use motion_check::Pose;
use nalgebra::{UnitQuaternion, Vector3};
use tip_path::{Iso9283, PathFile, TestKind, TipPath};

/// Measured points on each straight line.
const PER_LINE: usize = 10;

/// A point of a cycle at which the tip is measured.
struct Sample {
    /// Time from the start of the path, s.
    t: f64,
    /// Direction of the line, if the tip is on one.
    along: Option<Vector3<f64>>,
}

/// Takes the measurements while a test path runs.
pub struct Meter {
    test: Iso9283,
    /// All cycles, in the order of time.
    samples: Vec<Sample>,
    per_cycle: usize,
    /// Time at which the path starts, s, once it is known.
    begins: Option<f64>,
    settle_time: Port,
    /// Desired, then attained position.
    signals: Signals,
    /// Attained minus desired, m.
    deviations: Vec<Vector3<f64>>,
}

/// Accuracy at one point of the cycle, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Distance from the commanded point to the mean of the attained ones.
    pub accuracy: f64,
    /// `None` after a single cycle.
    pub repeatability: Option<f64>,
}

/// Result of a whole test.
#[derive(Clone, Debug, PartialEq)]
pub struct Measures {
    /// The test.
    pub test: Iso9283,
    /// Accuracy at each point of the cycle.
    pub points: Vec<Accuracy>,
}

impl Meter {
    /// A meter for the test path that `experiment` sets, if it sets one.
    pub fn from_experiment(system: &System, experiment: &Experiment) -> Result<Option<Self>> {
        let Some((port, file, test)) = test_path(system, experiment) else {
            return Ok(None);
        };
        let plant = system.port("tip.position[1]")?.component;
        let mut ports = system.elements(port.component, "desired.position", 3)?;
        ports.extend(system.elements(plant, "tip.position", 3)?);
        let samples = samples(&test, &file)?;
        Ok(Some(Self {
            per_cycle: samples.len() / test.cycles,
            test,
            samples,
            begins: None,
            settle_time: system.port_of(port.component, "settle_time")?,
            signals: Signals::new(system, &ports)?,
            deviations: Vec::new(),
        }))
    }

    /// Adds the present communication point.
    pub fn add(&mut self, master: &Master) -> Result<()> {
        let begins = match self.begins {
            Some(begins) => begins,
            None => master.time() + master.number(self.settle_time)?,
        };
        self.begins = Some(begins);
        while let Some(sample) = self.samples.get(self.deviations.len()) {
            // Communication points carry rounding.
            if master.time() < begins + sample.t - 1e-9 {
                break;
            }
            let v = self.signals.read(master)?;
            let mut d = Vector3::new(v[3] - v[0], v[4] - v[1], v[5] - v[2]);
            if let Some(along) = sample.along {
                d -= along * along.dot(&d);
            }
            self.deviations.push(d);
        }
        Ok(())
    }

    /// The result of the cycles finished so far; `None` before the first.
    pub fn measures(&self) -> Option<Measures> {
        let cycles: Vec<_> = self.deviations.chunks_exact(self.per_cycle).collect();
        let point = |i: usize| {
            let of_cycles: Vec<_> = cycles.iter().map(|cycle| cycle[i]).collect();
            Accuracy::from_deviations(&of_cycles)
        };
        (!cycles.is_empty()).then(|| Measures {
            test: self.test,
            points: (0..self.per_cycle).map(point).collect(),
        })
    }
}

/// The parameter `path_file`, the test path that `experiment` sets there, and its test.
fn test_path(system: &System, experiment: &Experiment) -> Option<(Port, PathFile, Iso9283)> {
    let port = system.port("path_file").ok()?;
    let set = experiment.settings.iter().rev().find(|s| s.port == port)?;
    let file = PathFile::built_in(&set.value)?.ok()?;
    let test = file.test?;
    Some((port, file, test))
}

/// The points at which the tip is measured. They do not depend on where the tip starts.
fn samples(test: &Iso9283, file: &PathFile) -> Result<Vec<Sample>> {
    let start = Pose {
        position: Vector3::zeros(),
        orientation: UnitQuaternion::identity(),
    };
    let path = TipPath::new(file, start)?;
    let stops = &path.stops()[..=test.cycles * test.points().len()];
    Ok(match test.kind {
        // The end of each rest; the last pose belongs to the next cycle.
        TestKind::Poses => {
            let ends = stops[..stops.len() - 1].iter().map(|stop| stop.leaves);
            ends.map(|t| Sample { t, along: None }).collect()
        }
        TestKind::Lines => {
            let lines = stops.windows(2).flat_map(|pair| {
                let (from, to) = (pair[0].leaves, pair[1].arrives);
                let (path, start) = (&path, path.at(from).pose.position);
                let way = path.at(to).pose.position - start;
                let along = way.normalize();
                (0..PER_LINE).map(move |k| {
                    let part = (k as f64 + 0.5) / PER_LINE as f64;
                    let gone = |t: f64| along.dot(&(path.at(t).pose.position - start));
                    let (mut early, mut late) = (from, to);
                    for _ in 0..50 {
                        let t = 0.5 * (early + late);
                        if gone(t) < part * way.norm() {
                            early = t;
                        } else {
                            late = t;
                        }
                    }
                    Sample {
                        t: late,
                        along: Some(along),
                    }
                })
            });
            lines.collect()
        }
    })
}

impl Accuracy {
    /// Accuracy from the deviations of all cycles at one point.
    fn from_deviations(deviations: &[Vector3<f64>]) -> Self {
        let n = deviations.len() as f64;
        let mean = deviations.iter().sum::<Vector3<f64>>() / n;
        let lengths: Vec<_> = deviations.iter().map(|d| (d - mean).norm()).collect();
        let l = lengths.iter().sum::<f64>() / n;
        let squares: f64 = lengths.iter().map(|length| (length - l).powi(2)).sum();
        let spread = (squares / (n - 1.0)).sqrt();
        Self {
            accuracy: mean.norm(),
            repeatability: (deviations.len() > 1).then_some(l + 3.0 * spread),
        }
    }
}

impl Measures {
    /// The largest accuracy and repeatability over all points: AT and RT of lines.
    pub fn largest(&self) -> Accuracy {
        let accuracy = self.points.iter().map(|p| p.accuracy).fold(0.0, f64::max);
        let repeatability = self.points.iter().map(|p| p.repeatability);
        Accuracy {
            accuracy,
            repeatability: repeatability.reduce(|a, b| Some(a?.max(b?))).flatten(),
        }
    }
}

impl fmt::Display for Measures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cycles = self.test.cycles;
        let mm = |point: &Accuracy| {
            let repeatability = point.repeatability.map(|r| format!("{:.4}", 1e3 * r));
            let repeatability = repeatability.unwrap_or("-".into());
            format!("{:>12.4}{repeatability:>16}", 1e3 * point.accuracy)
        };
        writeln!(
            f,
            "ISO 9283, {cycles} cycle(s), tip of the plant relative to its reference, mm"
        )?;
        match self.test.kind {
            TestKind::Poses => {
                writeln!(f, "pose   accuracy AP    repeatab. RP")?;
                for (name, point) in ["P1", "P5", "P4", "P3", "P2"].iter().zip(&self.points) {
                    writeln!(f, "{name:<6}{}", mm(point))?;
                }
                Ok(())
            }
            TestKind::Lines => {
                writeln!(f, "lines  accuracy AT    repeatab. RT")?;
                writeln!(f, "{:<6}{}", "", mm(&self.largest()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: deviations (1, 0, 0) and (3, 0, 0) have the mean 2, distances 1 and 1 from it, and
    /// no spread.
    #[test]
    fn accuracy_and_repeatability_are_those_of_the_standard() {
        let d = [1.0, 3.0].map(|x| Vector3::new(x, 0.0, 0.0));
        let found = Accuracy::from_deviations(&d);
        assert_eq!((found.accuracy, found.repeatability), (2.0, Some(1.0)));
        // Distances 1, 1, 2 from the mean 0: their mean is 4/3, their spread 1/√3.
        let d = [[1.0, 0.0], [1.0, 0.0], [-2.0, 0.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
        let found = Accuracy::from_deviations(&d)
            .repeatability
            .expect("three cycles");
        assert!(
            (found - (4.0 / 3.0 + 3.0_f64.sqrt())).abs() < 1e-12,
            "{found}"
        );
        assert_eq!(Accuracy::from_deviations(&d[..1]).repeatability, None);
    }

    #[test]
    fn poses_are_measured_at_the_end_of_their_rest_and_lines_along_the_way() {
        let file = PathFile::built_in("iso9283-cube:2")
            .expect("known")
            .expect("valid");
        let poses = samples(&file.test.expect("test"), &file).expect("timed");
        assert_eq!(poses.len(), 10);
        assert!(poses.windows(2).all(|pair| pair[0].t < pair[1].t));
        assert!((poses[0].t - 1.0).abs() < 1e-12, "{}", poses[0].t);
        let file = PathFile::built_in("iso9283-rectangle:3")
            .expect("known")
            .expect("valid");
        let lines = samples(&file.test.expect("test"), &file).expect("timed");
        assert_eq!(lines.len(), 3 * 4 * PER_LINE);
        assert!(lines.windows(2).all(|pair| pair[0].t < pair[1].t));
        let across = lines[0].along.expect("on a line");
        assert!((across.x + across.y).abs() < 1e-12, "in the diagonal plane");
    }
}
