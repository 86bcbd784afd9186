//! The gain conditions of the low-level law's stability proof in numbers, at the largest current,
//! for the subcommand `stability` and the report.
#![allow(non_snake_case)] // the paper's symbols

use serde::Serialize;

/// Constants of the gain conditions.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Gains {
    /// β₁, N/A.
    pub beta_1: f64,
    /// |β₂|, N/A.
    pub beta_2: f64,
    /// Left over right side of the first condition as printed in the paper.
    pub printed_margin: f64,
    /// Largest weight of Young's inequality with which the first condition holds, A/N.
    pub epsilon_max: f64,
    /// K₁, m/N.
    pub K_1: f64,
    /// K₂, H.
    pub K_2: f64,
}

/// A gain condition: `value` must be at least `bound`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Condition {
    /// The inequality.
    pub statement: &'static str,
    /// Weight ε of Young's inequality, A/N.
    pub weight: f64,
    /// Its left side.
    pub value: f64,
    /// Its right side.
    pub bound: f64,
    /// Unit of both.
    pub unit: &'static str,
}

impl Condition {
    /// Whether the condition is met.
    pub fn holds(&self) -> bool {
        self.value >= self.bound
    }
}

impl Gains {
    /// The first condition as printed (weight 1 A/N), the first with half of the largest weight, and
    /// the second with the latter. The third one, `K₁ = L_q/(β₁ K_v)`, is an equality by construction.
    pub fn conditions(&self) -> [Condition; 3] {
        let weight = 0.5 * self.epsilon_max;
        let first = Condition {
            statement: "β₁ K_f/L_q over ε β₂ K_i/(2 L_d)",
            weight: 1.0,
            value: self.printed_margin,
            bound: 1.0,
            unit: "1",
        };
        [
            first,
            Condition {
                weight,
                value: self.epsilon_max / weight,
                ..first
            },
            Condition {
                statement: "K₂ against K₁ β₂/(2 ε)",
                weight,
                value: self.K_2,
                bound: self.K_1 * self.beta_2 / (2.0 * weight),
                unit: "H",
            },
        ]
    }

    /// The conditions with weights that were not fitted to them but are energies of the machine:
    /// `K₁ = 1/K_b`, so that ν_a's first part is the energy in the actuator's springs, and `K₂ =
    /// 3/2·L_d`, so that its second is that of the direct-axis field. The third condition is then
    /// no longer an equality by construction.
    pub(crate) fn unfitted(&self, compliance: f64, L_d: f64) -> [Condition; 2] {
        let weight = 0.5 * self.epsilon_max;
        [
            Condition {
                statement: "K₂ = 3/2 L_d against K₁ β₂/(2 ε)",
                weight,
                value: 1.5 * L_d,
                bound: compliance * self.beta_2 / (2.0 * weight),
                unit: "H",
            },
            Condition {
                statement: "K₁ = 1/K_b against L_q/(β₁ K_v)",
                weight,
                value: compliance,
                bound: self.K_1,
                unit: "m/N",
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Young's inequality `a b <= ε a²/2 + b²/(2 ε)`: the first condition gets harder in proportion
    /// to the weight.
    #[test]
    fn gain_conditions_follow_from_the_weight() {
        let gains = Gains {
            beta_1: 700.0,
            beta_2: 12.0,
            printed_margin: 0.05,
            epsilon_max: 0.05,
            K_1: 2e-6,
            K_2: 3e-4,
        };
        let [printed, weighted, second] = gains.conditions();
        assert!(!printed.holds() && weighted.holds());
        let at_one = weighted.value * weighted.weight;
        assert!((at_one - printed.value).abs() < 1e-15, "{at_one}");
        let [energy, equality] = gains.unfitted(4e-6, 2e-3);
        // 4e-6 · 12 / 0.05 against 1.5 · 2e-3
        assert!((energy.bound - 9.6e-4).abs() < 1e-16 && energy.holds());
        assert!((equality.value / equality.bound - 2.0).abs() < 1e-15);
        // 2e-6 · 12 / 0.05
        assert!((second.bound - 4.8e-4).abs() < 1e-16 && !second.holds());
    }
}
