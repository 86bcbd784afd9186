//! The desired motion of the tip at one instant, which each kind of reference gives `tracking`.

use motion_check::turn;
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Desired motion of the tip, world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesiredMotion {
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

impl DesiredMotion {
    /// The desired motion a short time `age`, s, ago, extrapolated from the present one.
    pub(crate) fn earlier(&self, age: f64) -> Self {
        let back = turn(self.angular_velocity * -age);
        Self {
            position: self.position - self.velocity * age + self.acceleration * (0.5 * age * age),
            velocity: self.velocity - self.acceleration * age,
            orientation: back * self.orientation,
            ..*self
        }
    }

    /// The motion with a shift of its position, m, that has these first and second derivatives.
    pub(crate) fn shifted(&self, [shift, first, second]: &[Vector3<f64>; 3]) -> Self {
        Self {
            position: self.position + shift,
            velocity: self.velocity + first,
            acceleration: self.acceleration + second,
            ..*self
        }
    }

    pub(crate) fn is_moving(&self) -> bool {
        [self.velocity, self.angular_velocity] != [Vector3::zeros(); 2]
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    /// On a path of constant acceleration with a constant turn the extrapolation is exact: closed
    /// form.
    #[test]
    fn what_was_desired_is_found_from_what_is() {
        let at = |t: f64| DesiredMotion {
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
}
