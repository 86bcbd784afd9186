//! Singular poses and the inverse of the tip's Jacobian, damped near them, for `clik` and `rates`.

use hdrm::{DOF, Tree};
use nalgebra::{Matrix6, Vector6};
use serde::{Deserialize, Serialize};

/// |sin zeta_5| below which the inverse is damped; at 0 the first and third wrist axes align.
const NEAR_SINGULAR: f64 = 0.05;
/// Damping at the wrist's singularity, in the Jacobian's mixed units (m and rad).
const DAMPING: f64 = 0.03;
/// Sine of the elbow's angle from the stretched arm below which the inverse is damped; at 0 the tip
/// cannot move along the arm.
const NEAR_STRETCHED: f64 = 0.1;
/// Damping with the arm stretched.
const STRETCHED_DAMPING: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Singularities {
    /// `zeta_3` of the stretched arm, rad: lift joint, tilt joint and wrist centre C4 in line.
    stretched: f64,
}

impl Singularities {
    pub(crate) fn new(tree: &Tree) -> Self {
        // B from O in A2's axes, which are the boom's turned by −beta2; C4 from B in A3's.
        let to_B = tree.r_A2_B;
        let to_C4 = tree.r_A3_A4 + tree.r_A4_C4;
        let boom = tree.lift.beta2 + libm::atan2(to_C4.y, to_C4.x);
        Self {
            stretched: libm::atan2(to_B.y, to_B.x) - boom,
        }
    }

    /// Whether the inverse is damped because of the wrist.
    pub(crate) fn is_near_wrist(&self, zeta_5: f64) -> bool {
        libm::sin(zeta_5).abs() < NEAR_SINGULAR
    }

    /// Angle from `zeta_3` in this direction (±1) until the arm is stretched or folded, rad.
    pub(crate) fn stretch_ahead(&self, zeta_3: f64, direction: f64) -> f64 {
        use std::f64::consts::PI;
        let beyond = (zeta_3 - self.stretched).rem_euclid(PI);
        if direction > 0.0 { PI - beyond } else { beyond }
    }

    /// μ² of the damped inverse; 0 away from singularities.
    fn damping(&self, zeta: &[f64; DOF]) -> f64 {
        let near = |sine: f64, range: f64| (1.0 - (sine / range).powi(2)).max(0.0);
        let wrist = near(libm::sin(zeta[4]), NEAR_SINGULAR);
        let elbow = near(libm::sin(zeta[2] - self.stretched), NEAR_STRETCHED);
        DAMPING * DAMPING * wrist + STRETCHED_DAMPING * STRETCHED_DAMPING * elbow
    }
}

/// `J⁻¹`, or `Jᵀ(J·Jᵀ + μ²)⁻¹` near a singularity; μ grows smoothly from zero.
pub(crate) struct Inverse {
    lu: nalgebra::LU<f64, nalgebra::U6, nalgebra::U6>,
    /// Jᵀ if the inverse is damped.
    transposed: Option<Matrix6<f64>>,
}

impl Inverse {
    pub(crate) fn new(J: Matrix6<f64>, singularities: &Singularities, zeta: &[f64; DOF]) -> Self {
        let mu2 = singularities.damping(zeta);
        if mu2 == 0.0 {
            return Self {
                lu: J.lu(),
                transposed: None,
            };
        }
        let damped = J * J.transpose() + Matrix6::from_diagonal_element(mu2);
        Self {
            lu: damped.lu(),
            transposed: Some(J.transpose()),
        }
    }

    pub(crate) fn apply(&self, b: Vector6<f64>) -> Vector6<f64> {
        // Only singular with the wrist centre on the slew axis, outside the joint limits: no
        // motion.
        let x = self.lu.solve(&b).unwrap_or_else(Vector6::zeros);
        match &self.transposed {
            None => x,
            Some(J_transposed) => J_transposed * x,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdrm::Tip;
    use machine_file::Machine;

    fn tree() -> Tree {
        Tree::new(&Machine::reference()).expect("works")
    }

    fn pose(zeta_5: f64) -> [f64; DOF] {
        let mut zeta = Machine::reference().start.zeta;
        zeta[4] = zeta_5;
        zeta
    }

    fn jacobian(tree: &Tree, zeta: &[f64; DOF]) -> Matrix6<f64> {
        Tip::new(tree, &tree.configuration(zeta)).jacobian()
    }

    fn inverse(zeta: &[f64; DOF]) -> (Matrix6<f64>, Inverse) {
        let tree = tree();
        let J = jacobian(&tree, zeta);
        (J, Inverse::new(J, &Singularities::new(&tree), zeta))
    }

    const B: Vector6<f64> = Vector6::new(0.3, -0.2, 0.1, 0.5, -0.7, 0.4);

    /// The solution minimises |J·x − b|² + μ²|x|², so its gradient is zero, and |x| ≤ |b|/(2μ)
    /// however singular J is. Tolerance: condition of J·Jᵀ + μ², some 1e5, times 36 rounded
    /// products.
    fn assert_damped(zeta: &[f64; DOF], mu2: f64) {
        let (J, inverse) = inverse(zeta);
        let x = inverse.apply(B);
        let gradient = J.transpose() * (J * x - B) + x * mu2;
        assert!(gradient.norm() < 1e-9, "{zeta:?}: {gradient}");
        assert!(x.norm() <= B.norm() / (2.0 * mu2.sqrt()), "{zeta:?}: {x}");
        assert!(x.norm() > 0.1, "{zeta:?}: {x}");
    }

    #[test]
    fn near_the_wrist_singularity_the_inverse_is_damped() {
        for zeta_5 in [-0.04, -1e-9, 0.0, 1e-9, 0.02] {
            let near = 1.0 - (f64::sin(zeta_5) / NEAR_SINGULAR).powi(2);
            assert_damped(&pose(zeta_5), DAMPING * DAMPING * near);
        }
    }

    /// The reference machine's arm is in line at zeta_3 = 0. There the tip cannot move along it:
    /// the Jacobian is singular, its inverse is not.
    #[test]
    fn with_the_arm_stretched_the_inverse_is_damped() {
        for zeta_3 in [-0.09, -1e-9, 0.0, 0.03] {
            let mut zeta = pose(-0.9);
            zeta[2] = zeta_3;
            let near = 1.0 - (f64::sin(zeta_3) / NEAR_STRETCHED).powi(2);
            assert_damped(&zeta, STRETCHED_DAMPING * STRETCHED_DAMPING * near);
        }
        let mut stretched = pose(-0.9);
        stretched[2] = 0.0;
        let J = jacobian(&tree(), &stretched);
        assert!(J.determinant().abs() < 1e-12, "{}", J.determinant());
    }

    /// Where the damping begins the inverse is exact, and there is no jump.
    #[test]
    fn elsewhere_the_inverse_is_exact() {
        let at_edge = NEAR_SINGULAR.asin();
        for zeta_5 in [-0.9, at_edge, 1.1] {
            let (J, inverse) = inverse(&pose(zeta_5));
            assert!(
                (J * inverse.apply(B) - B).norm() < 1e-10,
                "zeta_5 = {zeta_5}"
            );
        }
        let J = jacobian(&tree(), &pose(at_edge));
        let singularities = Singularities::new(&tree());
        let [inside, outside] = [1.0 - 1e-9, 1.0 + 1e-9].map(|part| {
            let zeta = pose((part * NEAR_SINGULAR).asin());
            Inverse::new(J, &singularities, &zeta).apply(B)
        });
        assert!((inside - outside).norm() < 1e-5 * outside.norm());
    }

    /// The way to the stretched and to the folded arm, in both directions.
    #[test]
    fn the_way_to_the_stretched_arm_is_the_angle_to_it() {
        use std::f64::consts::PI;
        let ahead = |zeta_3, rate| Singularities::new(&tree()).stretch_ahead(zeta_3, rate);
        for (zeta_3, rate, expected) in [
            (-0.7, 0.1, 0.7),
            (-0.7, -0.1, PI - 0.7),
            (0.2, -0.1, 0.2),
            (0.2, 0.1, PI - 0.2),
        ] {
            let found = ahead(zeta_3, rate);
            assert!((found - expected).abs() < 1e-12, "{zeta_3}: {found}");
        }
    }
}
