//! Desired tip motion: the paper's cubic and triangular trajectories, or an external one.
//!
//! Position, velocity and acceleration of T4 in the world frame. An edge is a straight line
//! travelled rest to rest with a quintic time law; at every vertex the tip dwells. The
//! orientation stays that of the start pose unless the reference is external.

use machine::Trajectories;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Which desired motion the controller follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trajectory {
    /// Edges of a cube (the paper's three-dimensional benchmark).
    Cubic,
    /// Triangle in the boom plane.
    Triangular,
    /// Given by the inputs `reference.*`.
    External,
    /// Made of the commanded rates `rate.*`.
    Rates,
    /// Given as a file, by [`crate::Controller::following`]; rest until then.
    Path,
}

/// Desired motion of the tip, world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Desired {
    /// Position of T4, m.
    pub position: Vector3<f64>,
    /// Velocity of T4, m/s.
    pub velocity: Vector3<f64>,
    /// Acceleration of T4, m/s².
    pub acceleration: Vector3<f64>,
    /// Orientation of T4.
    pub orientation: UnitQuaternion<f64>,
    /// Angular velocity of T4, rad/s.
    pub angular_velocity: Vector3<f64>,
}

impl Desired {
    /// What was desired a short time `age` ago, s: extrapolated with the present acceleration, the orientation with its angular velocity.
    pub(crate) fn earlier(&self, age: f64) -> Self {
        let back = turn(self.angular_velocity * -age);
        Self {
            position: self.position - self.velocity * age + self.acceleration * (0.5 * age * age),
            velocity: self.velocity - self.acceleration * age,
            orientation: back * self.orientation,
            ..*self
        }
    }

    /// Rest at a pose.
    pub(crate) fn rest(position: Vector3<f64>, orientation: UnitQuaternion<f64>) -> Self {
        Self {
            position,
            velocity: Vector3::zeros(),
            acceleration: Vector3::zeros(),
            orientation,
            angular_velocity: Vector3::zeros(),
        }
    }
}

/// Straight edges between vertices, each travelled rest to rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Path {
    /// Vertices relative to the start, world frame, m.
    vertices: Vec<Vector3<f64>>,
    /// Time for one edge, s.
    edge_time: f64,
    /// Rest at the end of an edge, s.
    dwell: f64,
}

impl Path {
    /// The path of `trajectory`; none for an external reference and for rates.
    pub(crate) fn of(trajectory: Trajectory, paths: &Trajectories) -> Option<Self> {
        let (vertices, edge_time, dwell) = match trajectory {
            Trajectory::Cubic => {
                let cubic = &paths.cubic;
                (cubic.world_vertices(), cubic.edge_time, cubic.dwell)
            }
            Trajectory::Triangular => {
                let triangular = &paths.triangular;
                (
                    triangular.vertices.clone(),
                    triangular.edge_time,
                    triangular.dwell,
                )
            }
            Trajectory::Path => (vec![[0.0; 3]; 2], 1.0, 0.0),
            Trajectory::External | Trajectory::Rates => return None,
        };
        let vertices = vertices.into_iter().map(Vector3::from).collect();
        Some(Self {
            vertices,
            edge_time,
            dwell,
        })
    }

    /// Time from the first edge to the end of the last rest, s.
    pub(crate) fn duration(&self) -> f64 {
        (self.vertices.len() - 1) as f64 * (self.edge_time + self.dwell)
    }

    /// Displacement from the start and its first two derivatives, `t` s after the path began.
    pub(crate) fn at(&self, t: f64) -> [Vector3<f64>; 3] {
        let edges = self.vertices.len() - 1;
        let k = ((t / (self.edge_time + self.dwell)).floor().max(0.0) as usize).min(edges - 1);
        let [from, to] = [self.vertices[k], self.vertices[k + 1]];
        let t_edge = t - k as f64 * (self.edge_time + self.dwell);
        let [s, s_dot, s_ddot] = quintic(t_edge, self.edge_time);
        [
            from + (to - from) * s,
            (to - from) * s_dot,
            (to - from) * s_ddot,
        ]
    }
}

/// Rest-to-rest quintic from 0 to 1 in time `T`, with its derivatives:
/// `s = 10 u³ − 15 u⁴ + 6 u⁵`, `u = t/T` held to [0, 1].
fn quintic(t: f64, T: f64) -> [f64; 3] {
    let u = (t / T).clamp(0.0, 1.0);
    [
        u * u * u * (10.0 + u * (-15.0 + 6.0 * u)),
        30.0 * u * u * (1.0 - u) * (1.0 - u) / T,
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (T * T),
    ]
}

/// The turn about an axis by the length of the vector, rad, with the same bits on every platform.
pub(crate) fn turn(rotation: Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = rotation.norm();
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let per_angle = if angle > 0.0 { sine / angle } else { 0.5 };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, rotation * per_angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine::Machine;

    fn path(trajectory: Trajectory) -> Path {
        Path::of(trajectory, &Machine::reference().trajectories).expect("has a path")
    }

    /// Closed form: an edge of length 0.2 m in 2 s has its peak speed 15/8·l/T at the middle and
    /// rests at both ends.
    #[test]
    fn an_edge_is_travelled_rest_to_rest() {
        let path = path(Trajectory::Cubic);
        let [x, v, a] = path.at(0.0);
        assert_eq!([x, v, a], [Vector3::zeros(); 3]);
        let [x, v, a] = path.at(1.0);
        assert!((x - Vector3::new(-0.1, 0.0, 0.0)).norm() < 1e-15);
        assert!((v - Vector3::new(-0.1875, 0.0, 0.0)).norm() < 1e-15);
        assert!(a.norm() < 1e-15);
        for t in [2.0, 2.1, 2.25] {
            let [x, v, a] = path.at(t);
            assert!((x - Vector3::new(-0.2, 0.0, 0.0)).norm() < 1e-15, "{t}");
            assert_eq!([v, a], [Vector3::zeros(); 2], "{t}");
        }
    }

    /// On a path of constant acceleration with a constant turn the extrapolation is exact: closed form.
    #[test]
    fn what_was_desired_is_found_from_what_is() {
        let at = |t: f64| Desired {
            position: Vector3::new(0.3, -0.7, 1.1) * (t * t / 2.0)
                + Vector3::new(0.2, 0.1, -0.4) * t,
            velocity: Vector3::new(0.3, -0.7, 1.1) * t + Vector3::new(0.2, 0.1, -0.4),
            acceleration: Vector3::new(0.3, -0.7, 1.1),
            orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.5, 0.9, -0.2) * t),
            angular_velocity: Vector3::new(0.5, 0.9, -0.2),
        };
        let (found, expected) = (at(1.3).earlier(0.2), at(1.1));
        assert!((found.position - expected.position).norm() < 1e-15);
        assert!((found.velocity - expected.velocity).norm() < 1e-15);
        assert!(found.orientation.angle_to(&expected.orientation) < 1e-7);
    }

    /// After the last edge the tip stays at the last vertex: for both paths known from the JSON.
    #[test]
    fn the_path_ends_at_its_last_vertex() {
        let [x, v, _] = path(Trajectory::Cubic).at(1000.0);
        assert!((x - Vector3::new(0.0, 0.0, 0.2)).norm() < 1e-15);
        assert_eq!(v, Vector3::zeros());
        let [x, v, _] = path(Trajectory::Triangular).at(1000.0);
        assert_eq!([x, v], [Vector3::zeros(); 2]);
    }

    /// The derivatives against central differences. Tolerance: δ²/6 times the next derivative but
    /// one (quintic on 2 s: |s⁗| ≤ 360/T⁴, |s⁽³⁾| ≤ 60/T³) times the edge, and rounding ε/δ.
    #[test]
    fn rates_are_the_derivatives_of_the_position() {
        let path = path(Trajectory::Cubic);
        let (edge, T, d) = (0.2, 2.0_f64, 1e-4);
        for k in 0..2000 {
            let t = 0.011 * f64::from(k) + 0.0005;
            let phase = t % 2.25;
            if phase < d || (phase - T).abs() < d {
                continue; // the third derivative jumps at a vertex
            }
            let [before, now, after] = [path.at(t - d), path.at(t), path.at(t + d)];
            let v = (after[0] - before[0]) / (2.0 * d);
            let a = (after[1] - before[1]) / (2.0 * d);
            let tol_v = edge * d * d / 6.0 * 60.0 / T.powi(3) + 4.0 * f64::EPSILON / d;
            let tol_a = edge * d * d / 6.0 * 360.0 / T.powi(4) + 4.0 * f64::EPSILON / d;
            assert!(
                (v - now[1]).norm() < tol_v,
                "t = {t}: {}",
                (v - now[1]).norm()
            );
            assert!(
                (a - now[2]).norm() < tol_a,
                "t = {t}: {}",
                (a - now[2]).norm()
            );
        }
    }

    /// Nine edges of 2 s along the cube, three of 3 s about the triangle, and a rest of 0.25 s after each.
    #[test]
    fn a_path_lasts_as_long_as_its_edges_and_rests() {
        for (trajectory, expected) in [
            (Trajectory::Cubic, 9.0 * 2.25),
            (Trajectory::Triangular, 3.0 * 3.25),
        ] {
            let duration = path(trajectory).duration();
            assert!((duration - expected).abs() < 1e-12, "{duration}");
        }
    }
}
