//! The mechanism as a tree of 12 joints, each driven by one coordinate with a variable gear ratio,
//! for the dynamics, the controller, `motion-check` and the studies.
//!
//! Body k is attached to its parent by a joint q_k that depends on one coordinate `zeta_c(k)`, with
//! the gear `g_k(zeta) = dq_k/dzeta_c`; with the joint's unit twist `s_k` and change of frame `X`
//! ```text
//! V_k = X V_parent + s_k g_k zeta_c_dot
//! A_k = X A_parent + s_k (g_k zeta_c_ddot + g_k′ zeta_c_dot²) + crm(V_k) s_k g_k zeta_c_dot
//! Q_i = Σ_{k: c(k)=i} g_k s_kᵀ F_k,   F_k the wrench accumulated from the subtree of k
//! ```
//! The joint motions solve the closed loops exactly, so no constraint equations are needed.

use crate::geometry::lift::Lift;
use crate::geometry::planar::{Polar, relative, turned, unit};
use crate::geometry::tilt::{FourBar, Tilt};
use crate::{Body, DOF};
use machine_file::Machine;
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};
use spatial::Pose;
use thiserror::Error;

/// Constant geometry of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tree {
    /// Lift joint O in T1, m.
    pub r_T1_O: Vector3<f64>,
    /// Slew radius, m.
    pub r_B: f64,
    /// Slew stroke at `zeta_1 = 0`, m.
    pub x1_mid: f64,
    /// Lift triangle.
    pub lift: Lift,
    /// Tilt joint B from O in A2's axes, m.
    pub r_A2_B: Vector3<f64>,
    /// Rocker pivot A from O in A2's axes, m.
    pub r_A2_A: Vector3<f64>,
    /// Foot E of the tilt actuator from O in A2's axes, m.
    pub r_A2_E: Vector3<f64>,
    /// Tilt four-bar.
    pub tilt: Tilt,
    /// First wrist joint A4 in A3, m.
    pub r_A3_A4: Vector3<f64>,
    /// Second wrist joint C4 in A4, m.
    pub r_A4_C4: Vector3<f64>,
    /// Third wrist joint D4 in C4, m.
    pub r_C4_D4: Vector3<f64>,
    /// Tip T4 in D4, m.
    pub r_D4_T4: Vector3<f64>,
    /// Unit vector of the boom axis in A2's axes, e(beta2).
    e_boom: Vector2<f64>,
}

/// A body's joint at one configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link {
    /// Pose of the body in its parent.
    pub pose: Pose,
    /// Gear `g_k = dq_k/dzeta_c(k)`; q is an angle, or for a rod a length in m.
    pub gear: f64,
    /// `g_k′ = d²q_k/dzeta²`.
    pub gear_prime: f64,
    /// `g_k″ = d³q_k/dzeta³`.
    pub gear_second: f64,
}

/// Stroke of one actuator as a function of its coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stroke {
    /// `x_i`, m.
    pub x: f64,
    /// `dx_i/dzeta_i`, m/rad; the force `f_i` gives the generalised force `x′·f_i`.
    pub prime: f64,
    /// `d²x_i/dzeta_i²`.
    pub second: f64,
}

/// The tree at one pose of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Configuration {
    /// By body index.
    pub links: [Link; Body::COUNT],
    /// Slew, lift, tilt.
    pub strokes: [Stroke; 3],
}

/// Error: the geometry is not a working machine.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GeometryError {
    /// The four-bar cannot be closed.
    #[error(
        "the four-bar does not close at zeta_3 = {zeta_3:.4} rad: \
         |AC| must lie between |d4 − d5| and d4 + d5 over the tilt range and {MARGIN} rad beyond"
    )]
    FourBarOpen {
        /// Joint angle, rad.
        zeta_3: f64,
    },
    /// An actuator passes a dead point inside the joint range.
    #[error(
        "dx_{actuator}/dzeta_{actuator} = {x_prime:.6} m/rad at {zeta:.4} rad: \
         it must be positive over the whole joint range and {MARGIN} rad beyond"
    )]
    DeadPoint {
        /// 2 for lift, 3 for tilt.
        actuator: usize,
        /// Joint angle, rad.
        zeta: f64,
        /// Slope there, m/rad.
        x_prime: f64,
    },
}

/// Angle beyond the joint limits, rad, over which the loops must work: end stops are compliant.
const MARGIN: f64 = 0.05;

impl Tree {
    /// The tree of a machine; an error if a loop does not close or an actuator has a dead point
    /// within the joint limits.
    pub fn new(machine: &Machine) -> Result<Self, GeometryError> {
        let g = &machine.geometry;
        let lift = Lift::new(g);
        let range = machine.limits.zeta();
        let tilt = Tilt::new(g, 0.5 * (range[2][0] + range[2][1]));
        let e_boom = unit(g.beta2);
        // A, E: relative to B in boom axes; A2's x axis is the boom axis turned by −beta2.
        let r_A2_B = in_plane(e_boom, g.r_O_B.into());
        let from_B = |p: Vector2<f64>| r_A2_B + turned(p, e_boom).push(0.0);
        let tree = Self {
            r_T1_O: g.r_T1_O.into(),
            r_B: g.r_B,
            x1_mid: g.x1_mid,
            lift,
            r_A2_B,
            r_A2_A: from_B(tilt.A),
            r_A2_E: from_B(tilt.E),
            tilt,
            r_A3_A4: Vector3::from(g.r_B_B4) + Vector3::from(g.r_B4_A4),
            r_A4_C4: g.r_A4_C4.into(),
            r_C4_D4: g.r_C4_D4.into(),
            r_D4_T4: g.r_D4_T4.into(),
            e_boom,
        };
        tree.check(&range)?;
        Ok(tree)
    }

    fn check(&self, range: &[[f64; 2]; DOF]) -> Result<(), GeometryError> {
        const SAMPLES: u32 = 200;
        for actuator in [2, 3] {
            let [min, max] = range[actuator - 1];
            let (min, max) = (min - MARGIN, max + MARGIN);
            for k in 0..=SAMPLES {
                let zeta = min + (max - min) * f64::from(k) / f64::from(SAMPLES);
                let x_prime = if actuator == 2 {
                    self.lift.actuator(unit(zeta - self.lift.beta2)).length_d[0]
                } else if self.tilt.closes(zeta) {
                    self.tilt.four_bar(unit(zeta)).actuator.length_d[0]
                } else {
                    return Err(GeometryError::FourBarOpen { zeta_3: zeta });
                };
                if x_prime.is_nan() || x_prime <= 0.0 {
                    return Err(GeometryError::DeadPoint {
                        actuator,
                        zeta,
                        x_prime,
                    });
                }
            }
        }
        Ok(())
    }

    /// Solves both loops at `zeta`, rad.
    pub(crate) fn solve(&self, zeta: &[f64; DOF]) -> LoopSolution {
        let e: [Vector2<f64>; DOF] = std::array::from_fn(|i| unit(zeta[i]));
        let e_A2 = relative(e[1], self.e_boom);
        LoopSolution {
            e,
            e_A2,
            lift: self.lift.actuator(e_A2),
            tilt: self.tilt.four_bar(e[2]),
        }
    }

    /// Poses, gears and strokes at `zeta`, rad.
    pub fn configuration(&self, zeta: &[f64; DOF]) -> Configuration {
        let solved = self.solve(zeta);
        Configuration {
            links: self.links(&solved),
            strokes: self.strokes(zeta[0], &solved),
        }
    }

    fn links(&self, solved: &LoopSolution) -> [Link; Body::COUNT] {
        let &LoopSolution { e, e_A2, .. } = solved;
        let (lift, tilt) = (&solved.lift, &solved.tilt);
        let in_A2 = |e_in_boom: Vector2<f64>| turned(e_in_boom, self.e_boom);
        let turn_z = |r: Vector3<f64>, e: Vector2<f64>, d: [f64; 3]| Link {
            pose: Pose::turn_z(r, e.x, e.y),
            gear: d[0],
            gear_prime: d[1],
            gear_second: d[2],
        };
        let slide = |x: f64, d: [f64; 3]| Link {
            pose: Pose::translation(Vector3::new(x, 0.0, 0.0)),
            gear: d[0],
            gear_prime: d[1],
            gear_second: d[2],
        };
        let direct = |pose: Pose| Link {
            pose,
            gear: 1.0,
            ..Link::default()
        };
        let [b1, b2, b3] = tilt.coupler_d;
        let foot = self.r_T1_O + self.lift.foot.push(0.0);
        let x_D2 = lift.length - self.lift.lc;
        let x_D3 = tilt.actuator.length - self.tilt.lc;
        let e_coupler = relative(tilt.e_coupler, e[2]);

        // In the order of `Body`.
        [
            direct(Pose::turn_y(Vector3::zeros(), e[0].x, e[0].y)),
            direct(Pose::turn_z(self.r_T1_O, e_A2.x, e_A2.y)),
            turn_z(foot, lift.e, lift.angle_d),
            slide(x_D2, lift.length_d),
            turn_z(self.r_A2_B, in_A2(e[2]), [1.0, 0.0, 0.0]),
            turn_z(self.r_A2_E, in_A2(tilt.actuator.e), tilt.actuator.angle_d),
            slide(x_D3, tilt.actuator.length_d),
            turn_z(self.r_A2_A, in_A2(tilt.e_rocker), tilt.rocker_d),
            turn_z(self.tilt.C.push(0.0), e_coupler, [b1 - 1.0, b2, b3]),
            direct(Pose::turn_x(self.r_A3_A4, e[3].x, e[3].y)),
            direct(Pose::turn_z(self.r_A4_C4, e[4].x, e[4].y)),
            direct(Pose::turn_x(self.r_C4_D4, e[5].x, e[5].y)),
            Link::default(),
        ]
    }

    /// Strokes of slew (`x_1 = x1_mid + r_B·zeta_1`), lift and tilt.
    pub(crate) fn strokes(&self, zeta_1: f64, solved: &LoopSolution) -> [Stroke; 3] {
        let stroke = |actuator: &Polar, x0: f64| Stroke {
            x: actuator.length - x0,
            prime: actuator.length_d[0],
            second: actuator.length_d[1],
        };
        [
            Stroke {
                x: self.x1_mid + self.r_B * zeta_1,
                prime: self.r_B,
                second: 0.0,
            },
            stroke(&solved.lift, self.lift.x0),
            stroke(&solved.tilt.actuator, self.tilt.x0),
        ]
    }
}

/// Solution of both loops at one pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoopSolution {
    /// Unit vectors of the six joint angles.
    pub e: [Vector2<f64>; DOF],
    /// Unit vector of A2's x axis in T1's axes.
    pub e_A2: Vector2<f64>,
    /// Lift actuator in T1's axes.
    pub lift: Polar,
    /// Four-bar in boom axes.
    pub tilt: FourBar,
}

impl Configuration {
    /// Joint of one body.
    pub fn link(&self, body: Body) -> &Link {
        &self.links[body as usize]
    }

    /// Poses of all bodies in the world frame.
    pub fn world_poses(&self) -> [Pose; Body::COUNT] {
        let mut poses = [Pose::identity(); Body::COUNT];
        for body in crate::BODIES {
            let local = self.link(body).pose;
            poses[body as usize] = match body.parent() {
                Some(parent) => poses[parent as usize] * local,
                None => local,
            };
        }
        poses
    }
}

/// `r` with x and y rotated by the angle of `e`.
fn in_plane(e: Vector2<f64>, r: Vector3<f64>) -> Vector3<f64> {
    turned(r.xy(), e).push(r.z)
}
