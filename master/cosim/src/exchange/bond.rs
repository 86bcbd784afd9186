//! Power residual of a bond of effort and flow (force and velocity, voltage and current): the power
//! that the coupling itself creates or destroys. Reports, supervision and step control use it.
//!
//! The component that exerts the effort delivers over a step the mean power `F̄·u_v`: its mean
//! effort times the flow it was given. The other one receives `u_F·v̄`: the effort it was given
//! times its own mean flow. Solved together, the two would be equal. The residual
//! `P = F̄·u_v − u_F·v̄` is the error of the coupling, measured while it runs (Sadjina et al. 2017,
//! here with means over the step in place of end values). With `P < 0` the coupling creates energy.
//!
//! If the component takes the power instead, as a drive does by the current it draws
//! (`power="drawn"`), both signs are reversed. Where connections transform values, all powers are
//! counted in the values of the receiver of the effort.

use serde::{Deserialize, Serialize};

use crate::structure::Power;
use crate::wiring::Port;
use crate::wiring::transformation::Linear;

/// Slots of the values of a bond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BondSlots {
    /// Effort output.
    pub effort: Port,
    pub effort_slot: usize,
    pub flow_slot: usize,
    /// Slot among the means.
    pub mean_slot: usize,
    /// The receiver of the effort is stepped later: the Gauss–Seidel schedule gives it the mean.
    pub mean_given: bool,
    /// Slots of the derivatives of effort and flow, if derivatives are passed.
    pub derivative_slots: (Option<usize>, Option<usize>),
    /// Transformation of the effort.
    pub transformation: Linear,
    pub power: Power,
}

/// What a bond passed in the step just made.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(crate) struct BondStep {
    pub effort_exerted: f64,
    pub flow_given: f64,
    pub effort_given: f64,
    pub flow_before: f64,
    /// Length of the step, s.
    pub length: f64,
    /// Mean effort and flow less those at the beginning, in the values of the outputs.
    pub effort_lacked: f64,
    pub flow_lacked: f64,
}

/// Power residual of one bond, accumulated over a run.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Residual {
    /// Name of the effort output.
    pub bond: String,
    /// Residual of the last step, W.
    pub power: f64,
    /// Largest magnitude so far, W.
    pub peak: f64,
    /// Sum of the residuals times h, J: energy lost (> 0) or created (< 0) by the coupling.
    pub energy: f64,
    /// Energy that went through the bond in either direction, J.
    pub turnover: f64,
    /// Energy that the receiver of the effort counts, J, positive in the direction of the power.
    pub passed: f64,
}

impl Residual {
    /// A residual before the first step.
    pub fn new(bond: String) -> Self {
        Self {
            bond,
            ..Self::default()
        }
    }

    /// Add a step of length `h`, s, in which the component that exerts the effort counts the power
    /// `exerted`, and the one that receives it `received`, W, both in the direction `power`.
    pub fn add(&mut self, h: f64, power: Power, exerted: f64, received: f64) {
        self.power = match power {
            Power::Delivered => exerted - received,
            Power::Drawn => received - exerted,
        };
        self.peak = self.peak.max(self.power.abs());
        self.energy += self.power * h;
        self.turnover += received.abs() * h;
        self.passed += received * h;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_powers_leave_nothing_and_signs_are_kept() {
        let mut r = Residual::new("a.F".into());
        r.add(0.5, Power::Delivered, 6.0, 6.0);
        assert_eq!((r.power, r.energy, r.turnover), (0.0, 0.0, 3.0));
        r.add(0.5, Power::Delivered, 6.0, 7.0); // 1 W created
        assert_eq!(
            (r.power, r.peak, r.energy, r.turnover),
            (-1.0, 1.0, -0.5, 6.5)
        );
        r.add(0.5, Power::Drawn, 6.0, 8.0); // drawn 6 W, given 8 W: 2 W lost
        assert_eq!(
            (r.power, r.peak, r.energy, r.turnover, r.passed),
            (2.0, 2.0, 0.5, 10.5, 10.5)
        );
        r.add(0.5, Power::Drawn, -6.0, -6.0);
        assert_eq!((r.energy, r.turnover, r.passed), (0.5, 13.5, 7.5));
    }
}
