//! State of the actuator: the FMU saves it, `step` and `vdc`'s prediction integrate a part of it.

use machine_file::Dq;
use model_rules::{StepError, check_finite};
use serde::{Deserialize, Serialize};

/// State of the actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Direct-axis current, A (peak).
    pub i_d: f64,
    /// Quadrature-axis current, A (peak).
    pub i_q: f64,
    /// Motor angle, rad; the nut position is `x_n = ρ/(2πN)·θ_m`.
    pub theta_m: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Rod position in [`crate::Drive::Force`], m; stays at its start value in
    /// [`crate::Drive::Motion`].
    pub x: f64,
    /// Rod velocity in [`crate::Drive::Force`], m/s; stays at its start value in
    /// [`crate::Drive::Motion`].
    pub x_dot: f64,
    /// The surrogate network's residual at the state's torque and speed, held over the next step.
    pub residual: Residual,
    /// Mean force on the load over the last step, N; at the start the present force.
    pub F_mean: f64,
    /// Mean power from the DC side over the last step, W; at the start the present power.
    pub P_in_mean: f64,
    /// Mean current from the DC side over the last step, A; at the start the present current.
    pub i_dc_mean: f64,
    /// Time over which [`crate::Output::F`] is predicted, s.
    pub lead: f64,
    /// Energies since the start.
    pub energy: Balance,
    /// Work on the load by shifts of the rod between steps since the start, J: see
    /// [`crate::Emla::work_of_shift`].
    pub shift: f64,
    /// Losses by where their heat goes; see [`LossKinds`].
    pub kinds: LossKinds,
    /// Temperatures.
    pub thermal: Thermal,
    /// Whether undervoltage has tripped the drive: gates off, brake applied.
    pub tripped: bool,
    /// How long ago the brake was commanded, s, at most its closing time; 0 without command.
    pub braked: f64,
}

/// Energy balance of the actuator: energies since the start, J, or their rates, W.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Taken from the DC side, core and inverter losses included.
    pub supplied: f64,
    /// Given to the load.
    pub delivered: f64,
    /// Lost.
    pub lost: f64,
}

impl Balance {
    fn advanced(self, dt: f64, power: Self) -> Self {
        Self {
            supplied: self.supplied + dt * power.supplied,
            delivered: self.delivered + dt * power.delivered,
            lost: self.lost + dt * power.lost,
        }
    }
}

/// The part of the [`State`] that is integrated from substep to substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Point {
    pub i_d: f64,
    pub i_q: f64,
    pub theta_m: f64,
    pub w_m: f64,
    pub x: f64,
    pub x_dot: f64,
    /// Integral of the force on the load, N·s.
    pub impulse: f64,
    pub energy: Balance,
}

/// Outputs of the network, and its correction of the physics; all zero without a network.
///
/// Source: `[paper]` Eq. (eq:residual_blending_hat), on the quasi-static maps. `α·dF` acts as a
/// load on the nut, `F_nut = F_spring − α·dF`, so that in steady state the delivered force is
/// `F_qs + α·dF = F_hyb`. On the rod side it would lack the motor's inertia and peak.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// `F_net − F_qs`, both inside the network's guards, N.
    pub dF: f64,
    /// Force of the network, N.
    pub F_net: f64,
    /// Rod velocity of the network, m/s.
    pub x_dot_net: f64,
    /// Whether the point is in the trained range.
    pub in_trained_range: bool,
}

/// Temperatures and the heat given to the air.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Thermal {
    /// Temperature of the winding, K.
    pub T_winding: f64,
    /// Temperature of the housing, K.
    pub T_housing: f64,
    /// Heat given to the air since the start, J.
    pub given: f64,
}

/// Losses since the start, J, whose heat does not go to the housing; computed if heat is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LossKinds {
    /// Copper losses, which heat the winding.
    pub copper: f64,
    /// Losses of the inverter, which has its own cooling.
    pub inverter: f64,
}

/// Time derivative of a [`Point`]; `F` is that of the impulse.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rates {
    pub i: Dq,
    pub theta_m: f64,
    pub w_m: f64,
    pub x: f64,
    pub x_dot: f64,
    pub F: f64,
    pub energy: Balance,
    pub kinds: LossKinds,
}

impl State {
    /// Number of continuous states.
    pub const MOVING: usize = 13;

    fn moving_fields(&mut self) -> [&mut f64; Self::MOVING] {
        let (energy, thermal) = (&mut self.energy, &mut self.thermal);
        [
            &mut self.i_d,
            &mut self.i_q,
            &mut self.theta_m,
            &mut self.w_m,
            &mut self.x,
            &mut self.x_dot,
            &mut energy.supplied,
            &mut energy.delivered,
            &mut energy.lost,
            &mut thermal.T_winding,
            &mut thermal.T_housing,
            &mut thermal.given,
            &mut self.kinds.inverter,
        ]
    }

    /// The continuous states: currents, motor, free rod, energies, heat.
    #[must_use]
    pub fn moving(&self) -> [f64; Self::MOVING] {
        let mut state = *self;
        state.moving_fields().map(|place| *place)
    }

    /// The inverse of [`State::moving`].
    pub fn set_moving(&mut self, moving: &[f64]) {
        for (place, value) in self.moving_fields().into_iter().zip(moving) {
            *place = *value;
        }
    }

    pub(crate) fn point(&self) -> Point {
        Point {
            i_d: self.i_d,
            i_q: self.i_q,
            theta_m: self.theta_m,
            w_m: self.w_m,
            x: self.x,
            x_dot: self.x_dot,
            impulse: 0.0,
            energy: self.energy,
        }
    }

    /// Checks that the state, and products of up to four of its numbers (powers), are finite.
    pub(crate) fn check_finite(&self, t: f64) -> Result<(), StepError> {
        let values = [
            ("i_d", self.i_d),
            ("i_q", self.i_q),
            ("theta_m", self.theta_m),
            ("w_m", self.w_m),
            ("x", self.x),
            ("x_dot", self.x_dot),
            ("residual.dF", self.residual.dF),
            ("F_mean", self.F_mean),
            ("i_dc_mean", self.i_dc_mean),
            ("energy.supplied", self.energy.supplied),
            ("energy.delivered", self.energy.delivered),
            ("energy.shift", self.shift),
            ("energy.lost", self.energy.lost),
            ("T_winding", self.thermal.T_winding),
            ("T_housing", self.thermal.T_housing),
            ("energy.heat", self.thermal.given),
            ("i_d^4", self.i_d.powi(4)),
            ("i_q^4", self.i_q.powi(4)),
            ("theta_m^4", self.theta_m.powi(4)),
            ("w_m^4", self.w_m.powi(4)),
            ("x^4", self.x.powi(4)),
            ("x_dot^4", self.x_dot.powi(4)),
        ];
        check_finite(t, values)
    }
}

impl Point {
    /// `self + dt·rates`, without `rates.kinds`.
    #[inline(always)]
    pub(crate) fn advanced(&self, dt: f64, rates: &Rates) -> Self {
        Self {
            i_d: self.i_d + dt * rates.i.d,
            i_q: self.i_q + dt * rates.i.q,
            theta_m: self.theta_m + dt * rates.theta_m,
            w_m: self.w_m + dt * rates.w_m,
            x: self.x + dt * rates.x,
            x_dot: self.x_dot + dt * rates.x_dot,
            impulse: self.impulse + dt * rates.F,
            energy: self.energy.advanced(dt, rates.energy),
        }
    }

    pub(crate) fn current(&self) -> Dq {
        Dq {
            d: self.i_d,
            q: self.i_q,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Found by random calls: currents that ran away within a step were finite, and `P_in`, which
    /// is ∞ − ∞ then, was not a number.
    #[test]
    fn numbers_whose_powers_are_no_numbers_are_refused() {
        let run_away = State {
            i_d: 1e200,
            i_q: -1e200,
            ..State::default()
        };
        let error = run_away.check_finite(0.5).expect_err("1e800");
        let expected = "t = 0.5 s: `i_d^4` became inf; it must be finite";
        assert_eq!(error.to_string(), expected);
        let largest = State {
            i_d: 1e77,
            ..State::default()
        };
        assert!(largest.check_finite(0.5).is_ok());
    }
}
