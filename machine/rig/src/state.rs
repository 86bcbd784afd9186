//! State of the actuator, which the FMU saves, its energy balance, and its derivative for `step`.

use machine_file::Dq;
use model_rules::{StepError, check_finite};
use serde::{Deserialize, Serialize};

/// State of the actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Direct-axis current, A.
    pub i_d: f64,
    /// Quadrature-axis current, A.
    pub i_q: f64,
    /// Motor angle, rad; the nut position is `ρ/(2πN)·θ_m`.
    pub theta_m: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Deflection of the friction's bristles, m at the nut.
    pub z: f64,
    /// Rod position in [`crate::Drive::Force`], m.
    pub x: f64,
    /// Rod velocity in [`crate::Drive::Force`], m/s.
    pub x_dot: f64,
    /// Temperatures of winding and housing, K.
    pub T: [f64; 2],
    /// Voltages that the inverter holds over a switching period.
    pub hold: HeldVoltages,
    /// Integral parts of the current loop's voltages, V.
    pub regulator: [f64; 2],
    /// Mean force over the last step, N; at the start the present force.
    pub F_mean: f64,
    /// Time over which the force is predicted, s.
    pub lead: f64,
    /// Energies since the start.
    pub energy: Balance,
    /// Mean powers over the last step; at the start the present ones.
    pub mean: Powers,
    /// Mean current from the DC side over the last step, A; at the start the present one.
    pub i_dc_mean: f64,
    /// Work on the load by shifts of the rod between steps since the start, J: see
    /// [`crate::Rig::work_of_shift`].
    pub shift: f64,
    /// Whether undervoltage has tripped the drive: gates off, brake applied.
    pub tripped: bool,
    /// How long ago the brake was commanded, s, at most its closing time; 0 without command.
    pub braked: f64,
}

/// Voltages of the inverter, V, in stator coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldVoltages {
    /// Voltage of this switching period.
    pub acting: [f64; 2],
    /// Voltage of the next one.
    pub next: [f64; 2],
    /// Time until the next one begins, s.
    pub left: f64,
}

/// Energy balance of the actuator: energies since the start, J, or their rates, W.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Taken from the DC side.
    pub supplied: f64,
    /// Given to the load.
    pub delivered: f64,
    /// Lost.
    pub lost: f64,
    /// Part of `lost` in the inverter, whose heat does not reach the motor.
    pub inverter: f64,
    /// Heat given to the air.
    pub heat: f64,
}

/// Powers, W.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Powers {
    /// Taken from the DC side.
    pub supplied: f64,
    /// Given to the load.
    pub delivered: f64,
    /// Lost.
    pub lost: f64,
}

impl Balance {
    fn plus(self, dt: f64, power: &Self) -> Self {
        Self {
            supplied: self.supplied + dt * power.supplied,
            delivered: self.delivered + dt * power.delivered,
            lost: self.lost + dt * power.lost,
            inverter: self.inverter + dt * power.inverter,
            heat: self.heat + dt * power.heat,
        }
    }

    /// Mean powers over the `h` s since `before`.
    pub(crate) fn mean_since(&self, before: &Self, h: f64) -> Powers {
        Powers {
            supplied: (self.supplied - before.supplied) / h,
            delivered: (self.delivered - before.delivered) / h,
            lost: (self.lost - before.lost) / h,
        }
    }
}

/// Time derivative of the [`State`]; `F` integrates to the impulse behind `F_mean`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rates {
    pub i: Dq,
    pub theta_m: f64,
    pub w_m: f64,
    pub x: f64,
    pub x_dot: f64,
    pub T: [f64; 2],
    pub F: f64,
    pub energy: Balance,
}

impl State {
    /// `self + dt·rates`, where `F_mean` is an impulse in N·s; bristles and inverter are held.
    #[inline(always)]
    pub(crate) fn plus(&self, dt: f64, rates: &Rates) -> Self {
        Self {
            i_d: self.i_d + dt * rates.i.d,
            i_q: self.i_q + dt * rates.i.q,
            theta_m: self.theta_m + dt * rates.theta_m,
            w_m: self.w_m + dt * rates.w_m,
            x: self.x + dt * rates.x,
            x_dot: self.x_dot + dt * rates.x_dot,
            T: [self.T[0] + dt * rates.T[0], self.T[1] + dt * rates.T[1]],
            F_mean: self.F_mean + dt * rates.F,
            energy: self.energy.plus(dt, &rates.energy),
            ..*self
        }
    }

    pub(crate) fn current(&self) -> Dq {
        Dq {
            d: self.i_d,
            q: self.i_q,
        }
    }

    /// Checks that all values are finite; `t`, s, is the time in the error message.
    pub(crate) fn check_finite(&self, t: f64) -> Result<(), StepError> {
        let hold = &self.hold;
        let values = [
            ("i_d", self.i_d),
            ("i_q", self.i_q),
            ("theta_m", self.theta_m),
            ("w_m", self.w_m),
            ("z", self.z),
            ("x", self.x),
            ("x_dot", self.x_dot),
            ("T_winding", self.T[0]),
            ("T_housing", self.T[1]),
            (
                "voltage",
                hold.acting[0]
                    + hold.acting[1]
                    + hold.next[0]
                    + hold.next[1]
                    + self.regulator[0]
                    + self.regulator[1],
            ),
            ("F_mean", self.F_mean),
            ("i_dc_mean", self.i_dc_mean),
            ("energy.in", self.energy.supplied),
            ("energy.out", self.energy.delivered),
            ("energy.shift", self.shift),
            ("energy.loss", self.energy.lost),
            ("energy.heat", self.energy.heat + self.energy.inverter),
        ];
        check_finite(t, values)
    }
}
