//! The sections `bodies`, `limits` and `start` of a machine file: inertial parameters, limits of
//! strokes, joints and wrist torques, and the start pose, for plant, controller and motion check.

use crate::check::Findings;
use serde::{Deserialize, Serialize};

/// One rigid body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in body axes, m.
    pub com: [f64; 3],
    /// Inertia about the centre of mass in body axes, kg·m².
    pub inertia_com: InertiaTensor,
}

/// Symmetric inertia tensor, kg·m². Off-diagonal entries are the tensor's own (−∫xy dm).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "the six entries of a symmetric tensor")]
pub struct InertiaTensor {
    pub xx: f64,
    pub yy: f64,
    pub zz: f64,
    pub xy: f64,
    pub xz: f64,
    pub yz: f64,
}

impl InertiaTensor {
    /// Rows of the full 3×3 tensor.
    pub fn rows(&self) -> [[f64; 3]; 3] {
        let i = self;
        [[i.xx, i.xy, i.xz], [i.xy, i.yy, i.yz], [i.xz, i.yz, i.zz]]
    }

    /// Whether a mass distribution with this tensor exists: exactly when Σ = ½tr(I)·1 − I is
    /// positive definite (the principal moments then obey the triangle inequality).
    fn is_physical(&self) -> bool {
        let half_trace = 0.5 * (self.xx + self.yy + self.zz);
        let mut s = self.rows().map(|row| row.map(|v| -v));
        for (i, row) in s.iter_mut().enumerate() {
            row[i] += half_trace;
        }
        let minor = s[0][0] * s[1][1] - s[0][1] * s[1][0];
        let det = s[0][0] * (s[1][1] * s[2][2] - s[1][2] * s[2][1])
            - s[0][1] * (s[1][0] * s[2][2] - s[1][2] * s[2][0])
            + s[0][2] * (s[1][0] * s[2][1] - s[1][1] * s[2][0]);
        s[0][0] > 0.0 && minor > 0.0 && det > 0.0
    }
}

/// The 13 bodies; frames as in the paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bodies {
    /// Base column.
    pub T1: Body,
    /// Lift boom.
    pub A2: Body,
    /// Lift cylinder.
    pub C2: Body,
    /// Lift rod.
    pub D2: Body,
    /// Tilt boom.
    pub A3: Body,
    /// Tilt cylinder.
    pub C3: Body,
    /// Tilt rod.
    pub D3: Body,
    /// Rocker A–D of the four-bar.
    pub RK: Body,
    /// Coupler C–D of the four-bar.
    pub CP: Body,
    /// First wrist body.
    pub A4: Body,
    /// Second wrist body.
    pub C4: Body,
    /// Third wrist body, carries the tip.
    pub D4: Body,
    /// Payload, rigid in D4 and given in D4 axes.
    pub PL: Body,
}

impl Bodies {
    /// Names in parent-before-child order, the order of [`Bodies::in_order`].
    pub const NAMES: [&'static str; 13] = [
        "T1", "A2", "C2", "D2", "A3", "C3", "D3", "RK", "CP", "A4", "C4", "D4", "PL",
    ];

    /// The bodies in parent-before-child order.
    pub fn in_order(&self) -> [&Body; 13] {
        [
            &self.T1, &self.A2, &self.C2, &self.D2, &self.A3, &self.C3, &self.D3, &self.RK,
            &self.CP, &self.A4, &self.C4, &self.D4, &self.PL,
        ]
    }

    /// The bodies as mutable references, in the same order.
    pub fn in_order_mut(&mut self) -> [&mut Body; 13] {
        let b = self;
        [
            &mut b.T1, &mut b.A2, &mut b.C2, &mut b.D2, &mut b.A3, &mut b.C3, &mut b.D3, &mut b.RK,
            &mut b.CP, &mut b.A4, &mut b.C4, &mut b.D4, &mut b.PL,
        ]
    }

    pub(crate) fn examine(&self, found: &mut Findings) {
        for (name, body) in Self::NAMES.iter().zip(self.in_order()) {
            found.positive(format_args!("bodies.{name}.mass"), body.mass);
            found.finite(format_args!("bodies.{name}.com"), body.com);
            let field = format_args!("bodies.{name}.inertia_com").to_string();
            found.finite(&field, body.inertia_com.rows().as_flattened());
            if !body.inertia_com.is_physical() {
                found.refuse(
                    field,
                    format_args!("{:?}", body.inertia_com.rows()),
                    "positive definite and obey the triangle inequality",
                );
            }
        }
    }
}

/// Ranges of strokes and joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Slew stroke range, m.
    pub stroke_1: [f64; 2],
    /// Lift stroke range, m.
    pub stroke_2: [f64; 2],
    /// Tilt stroke range, m.
    pub stroke_3: [f64; 2],
    /// Lower joint limits, degrees.
    pub zeta_min_deg: [f64; 6],
    /// Upper joint limits, degrees.
    pub zeta_max_deg: [f64; 6],
    /// Largest wrist torques, N·m.
    pub tau_wrist_max: [f64; 3],
}

impl Limits {
    /// Stroke ranges of the three actuators, m.
    pub fn strokes(&self) -> [[f64; 2]; 3] {
        [self.stroke_1, self.stroke_2, self.stroke_3]
    }

    /// Joint ranges, rad.
    pub fn zeta(&self) -> [[f64; 2]; 6] {
        std::array::from_fn(|i| [self.zeta_min_deg[i], self.zeta_max_deg[i]].map(f64::to_radians))
    }

    pub(crate) fn examine(&self, found: &mut Findings) {
        for (i, stroke) in self.strokes().into_iter().enumerate() {
            found.interval(format_args!("limits.stroke_{}", i + 1), stroke);
        }
        for i in 0..6 {
            let name = format!("limits.zeta_min_deg/zeta_max_deg[{}]", i + 1);
            found.interval(name, [self.zeta_min_deg[i], self.zeta_max_deg[i]]);
        }
        for (i, &tau) in self.tau_wrist_max.iter().enumerate() {
            found.positive(format_args!("limits.tau_wrist_max[{}]", i + 1), tau);
        }
    }
}

/// Where a run starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Joint angles, rad.
    pub zeta: [f64; 6],
}

impl Start {
    pub(crate) fn examine(&self, limits: &Limits, found: &mut Findings) {
        for (i, (&zeta, [min, max])) in self.zeta.iter().zip(limits.zeta()).enumerate() {
            if !(min..=max).contains(&zeta) {
                found.refuse(
                    format_args!("start.zeta[{}]", i + 1),
                    zeta,
                    format_args!(
                        "within the joint limits [{min}, {max}] rad; in degrees it is `zeta_deg`"
                    ),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tensor `tr(Σ)·1 − Σ` of `Σ = L D Lᵀ` with unit lower triangular L: by Sylvester's law Σ
    /// has as many positive eigenvalues as D has positive elements. All numbers are small integers
    /// or halves, so nothing is rounded.
    fn tensor(d: [f64; 3]) -> InertiaTensor {
        const L: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [3.0, 1.0, 0.0], [-2.0, 0.5, 1.0]];
        let s = |i: usize, j: usize| (0..3).map(|k| L[i][k] * d[k] * L[j][k]).sum::<f64>();
        let (x, y, z) = (s(0, 0), s(1, 1), s(2, 2));
        InertiaTensor {
            xx: y + z,
            yy: x + z,
            zz: x + y,
            xy: -s(0, 1),
            xz: -s(0, 2),
            yz: -s(1, 2),
        }
    }

    #[test]
    fn a_tensor_of_a_mass_distribution_is_known() {
        for x in [-2.0, 0.0, 3.0] {
            for y in [-1.0, 0.0, 4.0] {
                for z in [-4.0, 0.0, 2.0] {
                    let d = [x, y, z];
                    let expected = d.iter().all(|d| *d > 0.0);
                    assert_eq!(tensor(d).is_physical(), expected, "{d:?}");
                }
            }
        }
    }
}
