//! Stability conditions of the voltage law ([eq:EMLA_stability_conditions]) and its accompanying
//! function ([eq:v_EMLA]) for given gains: for the outputs in `proof` and a warning of the FMU.
//!
//! The paper bounds the cross term of ν̇_a by Young's inequality with weight 1, which adds N² to A²
//! and cannot hold with these units: its first condition needs β₂ ≤ 2 N/A, passed at 0.05 A. With a
//! weight ε (A/N), `F·i ≤ (ε F² + i²/ε)/2`, the conditions become
//! ```text
//! β₁ K_f/L_q ≥ ε β₂ K_i/(2 L_d),   K_2 ≥ K_1 β₂/(2 ε),   K_1 = L_q/(β₁ K_v)
//! ```
//! and any ε up to [`Conditions::epsilon_max`] serves.

use emla::maps;
use machine_file::{Controller as Gains, Emla};

/// The conditions in numbers, for the largest current.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conditions {
    /// β₁ at `i_d = 0`, N/A.
    pub beta_1: f64,
    /// |β₂| at `|i_q| = i_max`, N/A.
    pub beta_2: f64,
    /// Left over right side of the paper's first condition as printed (ε = 1); holds if ≥ 1.
    pub printed_margin: f64,
    /// Largest weight ε for which the first condition holds, A/N.
    pub epsilon_max: f64,
    /// `K_1` of ν_a, m/(N·s)·… as in the paper's third condition.
    pub K_1: f64,
    /// `K_2` of ν_a: twice the least value at ε = epsilon_max/2.
    pub K_2: f64,
}

impl Conditions {
    /// Evaluates the conditions for the nominal actuator and the gains.
    #[must_use]
    pub fn new(p: &Emla, gains: &Gains) -> Self {
        let beta_1 = maps::beta_1(p, 0.0);
        let beta_2 = maps::beta_2(p, p.i_max);
        let left = beta_1 * gains.K_f / p.L_q;
        let right = beta_2 * gains.K_i / (2.0 * p.L_d);
        let epsilon_max = left / right;
        let K_1 = p.L_q / (beta_1 * gains.K_v);
        Self {
            beta_1,
            beta_2,
            printed_margin: left / right,
            epsilon_max,
            K_1,
            K_2: 2.0 * K_1 * beta_2 / epsilon_max,
        }
    }

    /// The conditions with the smallest margin; failing ones come first.
    #[must_use]
    pub fn weakest(all: [Self; 3]) -> Self {
        let margin = |c: &Self| {
            if c.hold() {
                c.printed_margin
            } else {
                f64::NEG_INFINITY
            }
        };
        let [first, rest @ ..] = all;
        (rest.into_iter()).fold(first, |a, b| if margin(&b) < margin(&a) { b } else { a })
    }

    /// Whether some weight satisfies the conditions: all three quantities must be positive, and not
    /// so small or large that results overflow.
    #[must_use]
    pub fn hold(&self) -> bool {
        let positive = |v: f64| (1e-100..1e100).contains(&v);
        positive(self.epsilon_max) && positive(self.K_1) && positive(self.K_2)
    }

    /// Dissipation in the bound on ν̇_a, besides the virtual power flow ([eq:dv_EMLA3]), W, with
    /// the weight ε = epsilon_max/2 that `K_2` belongs to:
    /// `K_1 (β₁ K_f/L_q − ε β₂ K_i/(2 L_d)) F² + K_i/L_d (K_2 − K_1 β₂/(2 ε)) i²`; 0 where the
    /// conditions fail.
    pub(crate) fn dissipation(
        &self,
        p: &Emla,
        gains: &Gains,
        force_error: f64,
        i_d_error: f64,
    ) -> f64 {
        if !self.hold() {
            return 0.0;
        }
        let epsilon = 0.5 * self.epsilon_max;
        let of_force = self.K_1
            * (self.beta_1 * gains.K_f / p.L_q - epsilon * self.beta_2 * gains.K_i / (2.0 * p.L_d));
        let of_current = gains.K_i / p.L_d * (self.K_2 - self.K_1 * self.beta_2 / (2.0 * epsilon));
        of_force * force_error * force_error + of_current * i_d_error * i_d_error
    }

    /// ν_a of one actuator ([eq:v_EMLA]); 0 where the conditions fail, which leaves it undefined.
    pub(crate) fn accompanying(&self, force_error: f64, i_d_error: f64) -> f64 {
        if !self.hold() {
            return 0.0;
        }
        0.5 * (self.K_1 * force_error * force_error + self.K_2 * i_d_error * i_d_error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::Machine;

    /// The bound by Young's inequality with ε = epsilon_max/2, term by term: what the feedbacks
    /// dissipate, less the cross term's share.
    #[test]
    fn dissipation_is_what_the_cross_term_leaves() {
        let machine = Machine::reference();
        let (p, gains) = (&machine.emla.lift, &machine.controller);
        let c = Conditions::new(p, gains);
        let (F, i) = (1200.0, 3.0);
        let of_force = c.K_1 * c.beta_1 * (gains.K_f / p.L_q) * F * F;
        let of_current = c.K_2 * (gains.K_i / p.L_d) * i * i;
        let epsilon = c.epsilon_max / 2.0;
        let cross = c.K_1 * c.beta_2 * gains.K_i / p.L_d;
        let young = cross * (epsilon * F * F + i * i / epsilon) / 2.0;
        let expected = of_force + of_current - young;
        let found = c.dissipation(p, gains, F, i);
        assert!(found > 0.0 && expected > 0.1 * of_force);
        assert!((found / expected - 1.0).abs() < 1e-13, "{found} {expected}");
        // At the ε of the conditions half of the force's dissipation is left, and as much of the
        // current's as of the cross term.
        assert!((c.dissipation(p, gains, F, 0.0) / of_force - 0.5).abs() < 1e-13);
        assert!((c.dissipation(p, gains, 0.0, i) / of_current - 0.5).abs() < 1e-13);
    }

    /// ν_a = ½ (K_1 F² + K_2 i²), with K_1 and the weight by the paper's equations.
    #[test]
    fn the_accompanying_function_weighs_both_errors() {
        let machine = Machine::reference();
        let (p, gains) = (&machine.emla.tilt, &machine.controller);
        let c = Conditions::new(p, gains);
        assert!((c.K_1 * c.beta_1 * gains.K_v / p.L_q - 1.0).abs() < 1e-14);
        let sides = (c.beta_1 * gains.K_f / p.L_q) / (c.beta_2 * gains.K_i / (2.0 * p.L_d));
        assert!((c.epsilon_max / sides - 1.0).abs() < 1e-14);
        assert_eq!(c.printed_margin, c.epsilon_max);
        assert_eq!(c.accompanying(300.0, 0.0), 0.5 * c.K_1 * 300.0 * 300.0);
        assert_eq!(c.accompanying(0.0, 4.0), 8.0 * c.K_2);
    }

    #[test]
    fn where_the_conditions_fail_nothing_is_claimed() {
        let machine = Machine::reference();
        let mut gains = machine.controller;
        gains.K_v = 0.0;
        let p = &machine.emla.lift;
        let c = Conditions::new(p, &gains);
        assert!(!c.hold());
        assert_eq!(c.dissipation(p, &gains, 1.0, 1.0), 0.0);
        assert_eq!(c.accompanying(1.0, 1.0), 0.0);
        let good = Conditions::new(p, &machine.controller);
        assert!(good.hold());
        assert_eq!(Conditions::weakest([good, c, good]), c);
        for wrong in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            let mut each = [good; 3];
            each[0].epsilon_max = wrong;
            each[1].K_1 = wrong;
            each[2].K_2 = wrong;
            assert!(each.iter().all(|c| !c.hold()), "{wrong}");
        }
        let half = Conditions {
            printed_margin: 0.5 * good.printed_margin,
            ..good
        };
        assert_eq!(Conditions::weakest([good, half, good]), half);
    }
}
