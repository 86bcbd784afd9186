//! Quantities of a motion that have limits, with names and units, for `tip-path` and the studies.

use machine_file::AXES;
use std::fmt;

/// A quantity with a limit; joints, actuators and wrist torques are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Joint angle, rad.
    Joint(usize),
    /// Stroke of an actuator, m.
    Stroke(usize),
    /// Rod speed, m/s.
    RodSpeed(usize),
    /// Force of an actuator on the manipulator, N.
    Force(usize),
    /// Wrist torque, N·m.
    WristTorque(usize),
    /// Motor speed, rad/s.
    MotorSpeed(usize),
    /// Quadrature-axis current (peak), A; the direct-axis current is zero.
    Current(usize),
    /// Length of the voltage vector (peak), V.
    Voltage(usize),
}

const JOINTS: [&str; 6] = ["slew", "lift", "tilt", "wrist 1", "wrist 2", "wrist 3"];

impl Quantity {
    /// Number of quantities.
    pub const COUNT: usize = 27;

    /// All quantities, kind by kind.
    pub fn all() -> [Self; Self::COUNT] {
        std::array::from_fn(|k| match k {
            0..6 => Self::Joint(k),
            6..9 => Self::Stroke(k - 6),
            9..12 => Self::RodSpeed(k - 9),
            12..15 => Self::Force(k - 12),
            15..18 => Self::WristTorque(k - 15),
            18..21 => Self::MotorSpeed(k - 18),
            21..24 => Self::Current(k - 21),
            _ => Self::Voltage(k - 24),
        })
    }

    /// Unit used in messages, and the factor from the SI unit to it.
    #[must_use]
    pub fn unit(self) -> (&'static str, f64) {
        match self {
            Self::Joint(_) => ("deg", 1.0_f64.to_degrees()),
            Self::Stroke(_) => ("mm", 1e3),
            Self::RodSpeed(_) => ("mm/s", 1e3),
            Self::Force(_) => ("kN", 1e-3),
            Self::WristTorque(_) => ("N.m", 1.0),
            Self::MotorSpeed(_) => ("rpm", 30.0 / std::f64::consts::PI),
            Self::Current(_) => ("A", 1.0),
            Self::Voltage(_) => ("V", 1.0),
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Joint(k) => write!(f, "joint {} ({})", k + 1, JOINTS[k]),
            Self::Stroke(k) => write!(f, "stroke of {}", AXES[k]),
            Self::RodSpeed(k) => write!(f, "rod speed of {}", AXES[k]),
            Self::Force(k) => write!(f, "force of {}", AXES[k]),
            Self::WristTorque(k) => write!(f, "wrist torque {}", k + 1),
            Self::MotorSpeed(k) => write!(f, "motor speed of {}", AXES[k]),
            Self::Current(k) => write!(f, "current of {}", AXES[k]),
            Self::Voltage(k) => write!(f, "voltage of {}", AXES[k]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn each_quantity_has_its_name() {
        let names: HashSet<_> = Quantity::all().iter().map(ToString::to_string).collect();
        assert_eq!(names.len(), Quantity::COUNT);
    }
}
