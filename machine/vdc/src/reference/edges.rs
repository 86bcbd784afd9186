//! The paper's cubic and triangular trajectories, for `reference`: straight edges from rest to rest
//! with a quintic time law and a dwell at every vertex. The orientation is constant.

use crate::reference::desired::DesiredMotion;
use machine_file::{CubicPath, TriangularPath};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Straight edges between vertices, each travelled rest to rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Edges {
    /// The tip's pose at the start, at rest.
    start: DesiredMotion,
    /// Vertices relative to the start, world frame, m.
    vertices: Vec<Vector3<f64>>,
    /// Time for one edge, s.
    edge_time: f64,
    /// Dwell at the end of an edge, s.
    dwell: f64,
}

impl Edges {
    /// Edges of a cube, from the pose `start`.
    pub(crate) fn cubic(path: &CubicPath, start: DesiredMotion) -> Self {
        Self::new(start, &path.world_vertices(), path.edge_time, path.dwell)
    }

    /// A triangle in the boom plane, from the pose `start`.
    pub(crate) fn triangular(path: &TriangularPath, start: DesiredMotion) -> Self {
        Self::new(start, &path.vertices, path.edge_time, path.dwell)
    }

    fn new(start: DesiredMotion, vertices: &[[f64; 3]], edge_time: f64, dwell: f64) -> Self {
        Self {
            start,
            vertices: vertices.iter().copied().map(Vector3::from).collect(),
            edge_time,
            dwell,
        }
    }

    /// Duration including the last dwell, s.
    pub(crate) fn duration(&self) -> f64 {
        (self.vertices.len() - 1) as f64 * (self.edge_time + self.dwell)
    }

    /// The tip's motion `t` s after the path began.
    pub(crate) fn at(&self, t: f64) -> DesiredMotion {
        let [x, v, a] = self.displacement(t);
        DesiredMotion {
            position: self.start.position + x,
            velocity: v,
            acceleration: a,
            ..self.start
        }
    }

    /// Displacement from the start and its first two derivatives, `t` s after the path began.
    fn displacement(&self, t: f64) -> [Vector3<f64>; 3] {
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
/// `s = 10 u³ − 15 u⁴ + 6 u⁵`, `u = t/T` clamped to [0, 1].
fn quintic(t: f64, T: f64) -> [f64; 3] {
    let u = (t / T).clamp(0.0, 1.0);
    [
        u * u * u * (10.0 + u * (-15.0 + 6.0 * u)),
        30.0 * u * u * (1.0 - u) * (1.0 - u) / T,
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (T * T),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::Machine;
    use nalgebra::UnitQuaternion;

    /// The cube's edges and the triangle's, from the origin.
    fn paths() -> [Edges; 2] {
        let trajectories = Machine::reference().trajectories;
        let start = DesiredMotion::rest(Vector3::zeros(), UnitQuaternion::identity());
        [
            Edges::cubic(&trajectories.cubic, start),
            Edges::triangular(&trajectories.triangular, start),
        ]
    }

    /// Closed form: an edge of length 0.2 m in 2 s has its peak speed 15/8·l/T at the middle and
    /// rests at both ends.
    #[test]
    fn an_edge_is_travelled_rest_to_rest() {
        let [path, _] = paths();
        let [x, v, a] = path.displacement(0.0);
        assert_eq!([x, v, a], [Vector3::zeros(); 3]);
        let [x, v, a] = path.displacement(1.0);
        assert!((x - Vector3::new(-0.1, 0.0, 0.0)).norm() < 1e-15);
        assert!((v - Vector3::new(-0.1875, 0.0, 0.0)).norm() < 1e-15);
        assert!(a.norm() < 1e-15);
        for t in [2.0, 2.1, 2.25] {
            let [x, v, a] = path.displacement(t);
            assert!((x - Vector3::new(-0.2, 0.0, 0.0)).norm() < 1e-15, "{t}");
            assert_eq!([v, a], [Vector3::zeros(); 2], "{t}");
        }
    }

    /// After the last edge the tip stays at the last vertex, which the machine file gives for both paths.
    #[test]
    fn the_path_ends_at_its_last_vertex() {
        let [cubic, triangular] = paths();
        let [x, v, _] = cubic.displacement(1000.0);
        assert!((x - Vector3::new(0.0, 0.0, 0.2)).norm() < 1e-15);
        assert_eq!(v, Vector3::zeros());
        let [x, v, _] = triangular.displacement(1000.0);
        assert_eq!([x, v], [Vector3::zeros(); 2]);
    }

    /// The derivatives against central differences. Tolerance: δ²/6 times the next derivative but
    /// one (quintic on 2 s: |s⁗| ≤ 360/T⁴, |s⁽³⁾| ≤ 60/T³) times the edge, and rounding ε/δ.
    #[test]
    fn rates_are_the_derivatives_of_the_position() {
        let [path, _] = paths();
        let (edge, T, d) = (0.2, 2.0_f64, 1e-4);
        for k in 0..2000 {
            let t = 0.011 * f64::from(k) + 0.0005;
            let phase = t % 2.25;
            if phase < d || (phase - T).abs() < d {
                continue; // the third derivative jumps at a vertex
            }
            let [before, now, after] = [
                path.displacement(t - d),
                path.displacement(t),
                path.displacement(t + d),
            ];
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

    /// Nine edges of 2 s along the cube, three of 3 s about the triangle, and a rest of 0.25 s
    /// after each.
    #[test]
    fn a_path_lasts_as_long_as_its_edges_and_rests() {
        for (path, expected) in paths().iter().zip([9.0 * 2.25, 3.0 * 3.25]) {
            let duration = path.duration();
            assert!((duration - expected).abs() < 1e-12, "{duration}");
        }
    }
}
