//! The tip T4 for plant, controller and studies: position, orientation, Jacobian and its rate.

use crate::{Body, Configuration, DOF, Tree};
use nalgebra::{Matrix6, Quaternion, Vector3};

/// Bodies between ground and tip; each joint rotates with its own coordinate (gear 1).
const CHAIN: [Body; DOF] = [Body::T1, Body::A2, Body::A3, Body::A4, Body::C4, Body::D4];

/// Joint axes, joint positions and the tip in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// Tip position, m.
    pub position: Vector3<f64>,
    /// Unit joint axes by coordinate.
    axes: [Vector3<f64>; DOF],
    /// A point on each joint axis, m.
    origins: [Vector3<f64>; DOF],
}

impl Tip {
    /// Tip and joint axes at a configuration.
    pub fn new(tree: &Tree, configuration: &Configuration) -> Self {
        let mut pose = spatial::Pose::identity();
        let mut axes = [Vector3::zeros(); DOF];
        let mut origins = axes;
        for (i, body) in CHAIN.into_iter().enumerate() {
            pose = pose * configuration.link(body).pose;
            axes[i] = pose.R * body.axis().w;
            origins[i] = pose.r;
        }
        Self {
            position: pose.r + pose.R * tree.r_D4_T4,
            axes,
            origins,
        }
    }

    /// Geometric Jacobian, world axes, rows `[v; w]`: column i is `[a_i × (p − o_i); a_i]`.
    pub fn jacobian(&self) -> Matrix6<f64> {
        let mut J = Matrix6::zeros();
        for (i, (a, o)) in self.axes.iter().zip(&self.origins).enumerate() {
            J.fixed_view_mut::<3, 1>(0, i)
                .copy_from(&a.cross(&(self.position - o)));
            J.fixed_view_mut::<3, 1>(3, i).copy_from(a);
        }
        J
    }

    /// Time derivative of [`Tip::jacobian`] at the joint rates `zeta_dot`, rad/s. The tip's
    /// acceleration is `J·zeta_ddot + J_dot·zeta_dot`.
    pub fn jacobian_dot(&self, zeta_dot: &[f64; DOF]) -> Matrix6<f64> {
        let mut w = Vector3::zeros();
        // Angular velocity and velocity of the joint's origin, up the chain.
        let mut o_dot = Vector3::zeros();
        let mut rates = [(Vector3::zeros(), Vector3::zeros()); DOF];
        for i in 0..DOF {
            if i > 0 {
                o_dot += w.cross(&(self.origins[i] - self.origins[i - 1]));
            }
            rates[i] = (w.cross(&self.axes[i]), o_dot);
            w += self.axes[i] * zeta_dot[i];
        }
        let p_dot = o_dot + w.cross(&(self.position - self.origins[DOF - 1]));

        let mut J_dot = Matrix6::zeros();
        for (i, (a_dot, o_dot)) in rates.iter().enumerate() {
            let (a, o) = (self.axes[i], self.origins[i]);
            let v = a_dot.cross(&(self.position - o)) + a.cross(&(p_dot - o_dot));
            J_dot.fixed_view_mut::<3, 1>(0, i).copy_from(&v);
            J_dot.fixed_view_mut::<3, 1>(3, i).copy_from(a_dot);
        }
        J_dot
    }

    /// Orientation of T4 in the world, unit quaternion: the product of the joints' half-angle
    /// quaternions. It is smooth in `zeta` (the sign never jumps), and w > 0 near `zeta = 0`.
    pub fn orientation(zeta: &[f64; DOF]) -> Quaternion<f64> {
        let turn = |angle: f64, axis: Vector3<f64>| {
            let (s, c) = libm::sincos(0.5 * angle);
            Quaternion::from_parts(c, axis * s)
        };
        turn(zeta[0], Vector3::y())
            * turn(zeta[1] + zeta[2], Vector3::z())
            * turn(zeta[3], Vector3::x())
            * turn(zeta[4], Vector3::z())
            * turn(zeta[5], Vector3::x())
    }
}
