//! The sections `controller` and `trajectories` of a machine file, for `vdc` and its FMU: gains,
//! and the paper's reference paths.

use crate::check::{Findings, MachineError, examine};
use serde::{Deserialize, Serialize};

/// Gains of the adaptive modular controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Time for which the start pose is held before the trajectory begins, s.
    pub settle_time: f64,
    /// Inverse-kinematics feedback on position, Λ, 1/s.
    pub Lambda_position: f64,
    /// Inverse-kinematics feedback on orientation, Λ, 1/s.
    pub Lambda_orientation: f64,
    /// Feedback on a rod's position where the actuators follow rod references of their own, λ, 1/s.
    #[serde(default = "Lambda_rod")]
    pub Lambda_rod: f64,
    /// `K_A = kappa_KA · (nominal 6×6 inertia of the body)`, 1/s.
    pub kappa_KA: f64,
    /// Shares of `kappa_KA` that act on slew, lift and tilt joint, whose motors have a feedback of
    /// their own (`K_v`); left out: 1, as in the paper.
    #[serde(default = "kappa_share")]
    pub kappa_share: [f64; 3],
    /// Current feedback, V/A.
    pub K_i: f64,
    /// Force feedback, V/N.
    pub K_f: f64,
    /// Velocity feedback on the motor side, V·s/m.
    pub K_v: f64,
    /// Decay rate λ_i of the required d-axis current, 1/s.
    #[serde(default = "lambda_i")]
    pub lambda_i: f64,
    /// Integral rate ω_i of the voltage law, 1/s; left out: none, as in the paper.
    #[serde(default)]
    pub omega_i: f64,
    /// Bandwidth ω_d of the disturbance observer, 1/s; left out: none, as in the paper.
    #[serde(default)]
    pub omega_d: f64,
    /// Rate ω_tip of the integral of the tip's error in the modes with integral, 1/s; left out: a
    /// quarter of the reference machine's `Lambda_position`, which makes the error's two roots
    /// equal.
    #[serde(default = "omega_tip")]
    pub omega_tip: f64,
    /// Bandwidth ω of the observer of the joint rates, rad/s; left out: none, the measured rates
    /// count, as in the paper.
    #[serde(default)]
    pub omega_speed: f64,
    /// Rate ω_f at which the friction of the wrist is estimated, 1/s; left out: it is not, as in the
    /// paper.
    #[serde(default)]
    pub omega_friction: f64,
    /// Age of the measurements when they are read, s: they are compared with the reference of then;
    /// left out: none, as in the paper.
    #[serde(default)]
    pub reading_age: f64,
    /// Leakage σ of the adaptation towards the nominal inertias, 1/s; left out: none, as in the
    /// paper.
    #[serde(default)]
    pub leakage: f64,
    /// Adaptation gain γ of the natural adaptation law (larger is slower).
    pub gamma: f64,
    /// Bounds on the inverse pseudo-inertia: `lower·P_0 < P < upper·P_0`.
    pub inverse_bounds: [f64; 2],
    /// Time constant of the filter behind d(i_qr)/dt, s.
    pub di_qr_filter_time: f64,
    /// Rod-velocity damping of the `pd` mode, N·s/m.
    pub pd_actuator_damping: f64,
    /// Wrist damping of the `pd` mode, N·m·s/rad.
    pub pd_wrist_damping: [f64; 3],
}

/// Default of λ_i for older files, which lack it; the paper gives no value.
fn lambda_i() -> f64 {
    50.0
}

/// Default, the paper's.
fn kappa_share() -> [f64; 3] {
    [1.0; 3]
}

/// Default for older files, which lack it: the reference machine's `Lambda_position`.
fn Lambda_rod() -> f64 {
    20.0
}

/// Default for older files, which lack it.
fn omega_tip() -> f64 {
    5.0
}

impl Controller {
    /// Checks every gain; also called when an importer changes a tunable parameter.
    pub fn check(&self) -> Result<(), MachineError> {
        Findings::collect(|found| self.examine(found))
    }

    pub(crate) fn examine(&self, found: &mut Findings) {
        examine! { found, "controller" of self;
            positive: Lambda_position Lambda_orientation Lambda_rod gamma di_qr_filter_time;
            not_negative: settle_time kappa_KA K_i K_f K_v lambda_i omega_i omega_d omega_tip
                omega_speed omega_friction leakage reading_age pd_actuator_damping;
        }
        for (i, &d) in self.pd_wrist_damping.iter().enumerate() {
            found.not_negative(format_args!("controller.pd_wrist_damping[{}]", i + 1), d);
        }
        for (i, &share) in self.kappa_share.iter().enumerate() {
            found.not_negative(format_args!("controller.kappa_share[{}]", i + 1), share);
        }
        let [lower, upper] = self.inverse_bounds;
        if !(lower > 0.0 && lower < 1.0 && upper > 1.0 && upper.is_finite()) {
            found.refuse(
                "controller.inverse_bounds",
                format_args!("[{lower}, {upper}]"),
                "0 < lower < 1 < upper < ∞",
            );
        }
    }
}

/// The paper's two tip trajectories.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Trajectories {
    /// Cube edges in three dimensions.
    pub cubic: CubicPath,
    /// Triangle in the boom plane.
    pub triangular: TriangularPath,
}

/// Vertices on a cube, in edge lengths along three axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CubicPath {
    /// Edge length, m.
    pub edge: f64,
    /// Time for one edge, s.
    pub edge_time: f64,
    /// Rest at each vertex, s.
    pub dwell: f64,
    /// Directions of the cube's edges in the world frame.
    pub axes: CubeAxes,
    /// Vertices in edge lengths, relative to the start.
    pub vertices: Vec<[f64; 3]>,
}

/// World directions of a cube's edges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "three directions")]
pub struct CubeAxes {
    pub first: [f64; 3],
    pub second: [f64; 3],
    pub third: [f64; 3],
}

impl CubeAxes {
    fn rows(&self) -> [[f64; 3]; 3] {
        [self.first, self.second, self.third]
    }
}

/// Vertices relative to the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TriangularPath {
    /// Time for one edge, s.
    pub edge_time: f64,
    /// Rest at each vertex, s.
    pub dwell: f64,
    /// Vertices in the world frame relative to the start, m.
    pub vertices: Vec<[f64; 3]>,
}

impl CubicPath {
    /// Vertices in the world frame relative to the start, m.
    pub fn world_vertices(&self) -> Vec<[f64; 3]> {
        let [first, second, third] = self.axes.rows();
        let along = |v: &[f64; 3], j: usize| {
            self.edge * (v[0] * first[j] + v[1] * second[j] + v[2] * third[j])
        };
        self.vertices
            .iter()
            .map(|v| [along(v, 0), along(v, 1), along(v, 2)])
            .collect()
    }
}

impl Trajectories {
    pub(crate) fn examine(&self, found: &mut Findings) {
        let (cubic, plane) = (&self.cubic, &self.triangular);
        found.positive("trajectories.cubic.edge", cubic.edge);
        let axes = cubic.axes.rows();
        found.finite("trajectories.cubic.axes", axes.as_flattened());
        for (name, edge_time, dwell, vertices) in [
            ("cubic", cubic.edge_time, cubic.dwell, &cubic.vertices),
            ("triangular", plane.edge_time, plane.dwell, &plane.vertices),
        ] {
            found.positive(format_args!("trajectories.{name}.edge_time"), edge_time);
            found.not_negative(format_args!("trajectories.{name}.dwell"), dwell);
            let name = format!("trajectories.{name}.vertices");
            found.finite(&name, vertices.as_flattened());
            if vertices.len() < 2 {
                let value = format!("{} vertices", vertices.len());
                found.refuse(&name, value, "two or more");
            }
        }
    }
}
