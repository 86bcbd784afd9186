//! Reach of the stretched arm, to test whether a point is in reach, for `tip-path` and `vdc`.

use machine_file::Geometry;
use serde::{Deserialize, Serialize};

/// Reach of the arm: position of the lift joint in the boom plane, and the length of the stretched
/// arm from there to the tip, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    radius: f64,
    height: f64,
    length: f64,
}

impl Reach {
    /// The reach of a machine with these dimensions.
    pub fn new(geometry: &Geometry) -> Self {
        let size = |v: &[f64; 3]| libm::hypot(libm::hypot(v[0], v[1]), v[2]);
        let links = [
            &geometry.r_O_B,
            &geometry.r_B_B4,
            &geometry.r_B4_A4,
            &geometry.r_A4_C4,
            &geometry.r_C4_D4,
            &geometry.r_D4_T4,
        ];
        let [x, y, z] = geometry.r_T1_O;
        Self {
            radius: libm::hypot(x, z),
            height: y,
            length: links.into_iter().map(size).sum(),
        }
    }

    /// Length of the stretched arm from the lift joint to the tip, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Smallest distance of a position from the lift joint over all slew angles, m.
    pub fn distance(&self, [x, y, z]: [f64; 3]) -> f64 {
        let (ahead, above) = ((x * x + z * z).sqrt() - self.radius, y - self.height);
        (ahead * ahead + above * above).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::Machine;

    /// By hand: lift joint at (0.1, 1.5, 0), links 2 + 1.5 + 0.2 + 0.2 + 0.15 + 0.4 m.
    #[test]
    fn the_reference_arm_reaches_four_metres_and_a_half() {
        let reach = Reach::new(&Machine::reference().geometry);
        assert!((reach.length() - 4.45).abs() < 1e-12);
        assert!((reach.distance([0.0, 1.5, -4.1]) - 4.0).abs() < 1e-12);
        assert!((reach.distance([3.1, 5.5, 0.0]) - 5.0).abs() < 1e-12);
    }
}
