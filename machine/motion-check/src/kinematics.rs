//! Kinematics of the arm, forward and inverse, for the path check, the controller and the studies.

use hdrm::{DOF, GeometryError, Tip, Tree};
use machine_file::Machine;
use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use crate::demand::Motion;
use crate::rotation::rotation_vector;

/// Largest number of iterations; near a solution two or three are needed.
const ITERATIONS: u32 = 100;
/// Error of a solution, m and rad: rounding of the pose of an arm of some metres leaves 1e-15.
const TOLERANCE: f64 = 1e-11;
/// Keeps the iteration's matrix regular at a singularity; small compared with the square of any
/// singular value elsewhere.
const DAMPING: f64 = 1e-10;

/// Position and orientation of the tip T4 in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position, m.
    pub position: Vector3<f64>,
    /// Orientation.
    pub orientation: UnitQuaternion<f64>,
}

/// Motion of the tip at one instant, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipMotion {
    /// Position and orientation.
    pub pose: Pose,
    /// Velocity and angular velocity, m/s and rad/s.
    pub velocity: Vector6<f64>,
    /// Acceleration and angular acceleration, m/s² and rad/s².
    pub acceleration: Vector6<f64>,
}

/// The closest joint angles to a pose for which no solution was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPose {
    /// Joint angles at which the search ended, rad.
    pub zeta: [f64; DOF],
    /// Their error of the position, m.
    pub distance: f64,
    /// Their error of the orientation, rad.
    pub angle: f64,
}

/// The arm's kinematics, forward and inverse.
#[derive(Clone, Debug)]
pub struct Kinematics {
    tree: Tree,
}

impl Kinematics {
    /// The kinematics of a machine.
    pub fn new(machine: &Machine) -> Result<Self, GeometryError> {
        Ok(Self {
            tree: Tree::new(machine)?,
        })
    }

    /// Pose of the tip at the joint angles `zeta`, rad.
    pub fn pose(&self, zeta: &[f64; DOF]) -> Pose {
        Pose {
            position: self.tip(zeta).position,
            orientation: UnitQuaternion::new_unchecked(Tip::orientation(zeta)),
        }
    }

    fn tip(&self, zeta: &[f64; DOF]) -> Tip {
        Tip::new(&self.tree, &self.tree.configuration(zeta))
    }

    /// Joint angles of a pose, on the branch of the angles `near`, rad: Levenberg–Marquardt steps
    /// whose damping is the squared error (Sugihara, IEEE Trans. Robotics 27(5), 2011). Joint
    /// limits are not checked. An error if the pose cannot be reached, at least not from `near`.
    pub fn inverse(&self, pose: &Pose, near: &[f64; DOF]) -> Result<[f64; DOF], NearestPose> {
        let mut zeta = Vector6::from(*near);
        for _ in 0..ITERATIONS {
            let angles = zeta.into();
            let tip = self.tip(&angles);
            let e = error(pose, &tip, &angles);
            if e.amax() < TOLERANCE {
                return Ok(angles);
            }
            let J = tip.jacobian();
            let damping = Matrix6::from_diagonal_element(0.5 * e.norm_squared() + DAMPING);
            let normal = J.transpose() * J + damping;
            let Some(step) = normal.cholesky().map(|c| c.solve(&(J.transpose() * e))) else {
                break;
            };
            zeta += step;
        }
        let zeta = zeta.into();
        let e = error(pose, &self.tip(&zeta), &zeta);
        Err(NearestPose {
            zeta,
            distance: e.fixed_rows::<3>(0).norm(),
            angle: e.fixed_rows::<3>(3).norm(),
        })
    }

    /// Joint motion of a tip motion at the joint angles `zeta`, rad, of its pose; None at a
    /// singularity of the arm.
    /// ```text
    /// ζ̇ = J⁻¹ V,   ζ̈ = J⁻¹ (V̇ − J̇ ζ̇)
    /// ```
    pub fn motion(&self, tip: &TipMotion, zeta: &[f64; DOF]) -> Option<Motion> {
        let now = self.tip(zeta);
        let inverse = now.jacobian().lu();
        let zeta_dot: [f64; DOF] = inverse.solve(&tip.velocity)?.into();
        let J_dot = now.jacobian_dot(&zeta_dot);
        let zeta_ddot = inverse.solve(&(tip.acceleration - J_dot * Vector6::from(zeta_dot)))?;
        Some(Motion {
            zeta: *zeta,
            zeta_dot,
            zeta_ddot: zeta_ddot.into(),
        })
    }
}

/// Desired minus actual pose: position, m, and rotation vector in world axes, rad.
fn error(pose: &Pose, tip: &Tip, zeta: &[f64; DOF]) -> Vector6<f64> {
    let now = UnitQuaternion::new_unchecked(Tip::orientation(zeta));
    let position = pose.position - tip.position;
    let turn = rotation_vector(&(pose.orientation * now.inverse()));
    Vector6::new(position.x, position.y, position.z, turn.x, turn.y, turn.z)
}
