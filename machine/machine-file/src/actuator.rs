//! The sections `emla` and `ratings` of a machine file: parameters of an electromechanical linear
//! actuator and its ratings, for actuator models, controller, motion check and studies.

use crate::check::{Findings, MachineError, examine};
use serde::{Deserialize, Serialize};

/// Motor, gear, screw and rod of one actuator. dq quantities are peak-valued
/// (amplitude-invariant): torque carries the factor 3/2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Emla {
    /// Pole pairs.
    pub p: u32,
    /// Stator resistance, Ω.
    pub R_s: f64,
    /// d-axis inductance, H.
    pub L_d: f64,
    /// q-axis inductance, H.
    pub L_q: f64,
    /// Permanent-magnet flux linkage, Wb (peak).
    pub lambda_m: f64,
    /// Rotor inertia, kg·m².
    pub J_m: f64,
    /// Viscous friction of the motor, N·m·s/rad.
    pub C_m: f64,
    /// Coulomb friction of the motor, N·m.
    pub tau_C: f64,
    /// Speed over which the Coulomb friction changes sign, rad/s.
    pub w_C: f64,
    /// Gear reduction ratio.
    pub N_gear: f64,
    /// Gear efficiency.
    pub eta_gear: f64,
    /// Speed over which the gear loss changes sign, rad/s.
    pub w_eta: f64,
    /// Screw lead, m per revolution.
    pub rho: f64,
    /// Screw inertia, kg·m².
    pub J_s: f64,
    /// Viscous friction of the screw, N·m·s/rad.
    pub C_s: f64,
    /// Axial rigidity of the screw (the paper's K_s), N.
    pub EA: f64,
    /// Bearing stiffness, N/m.
    pub K_br: f64,
    /// Nut stiffness, N/m.
    pub K_n: f64,
    /// Rod stiffness, N/m.
    pub K_r: f64,
    /// Torsional rigidity of the screw (the paper's K_rot), N·m².
    pub GJ: f64,
    /// Distance between the screw's bearings, m.
    pub L_s: f64,
    /// Damping between nut and rod, N·s/m.
    pub C_b: f64,
    /// Mass of the rod and what moves with it, kg.
    pub M_act: f64,
    /// Viscous friction of the rod, N·s/m.
    pub C_act: f64,
    /// Largest phase current (peak), A.
    pub i_max: f64,
    /// Largest phase voltage (peak), V.
    pub v_max: f64,
    /// Iron losses; left out: none.
    #[serde(default)]
    pub core: Option<CoreLosses>,
    /// Inverter losses; left out: an ideal inverter.
    #[serde(default)]
    pub inverter: Option<InverterLosses>,
    /// Holding brake; left out: [`Brake::TYPICAL`].
    #[serde(default)]
    pub brake: Option<Brake>,
    /// Heat capacities and resistances; left out: [`Heat::TYPICAL`].
    #[serde(default)]
    pub heat: Option<Heat>,
    /// What winding and magnets do with their temperature; left out: [`Temperature::TYPICAL`].
    #[serde(default)]
    pub temperature: Option<Temperature>,
}

/// Holding brake on the motor's shaft, applied by a spring: dry friction that sticks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Brake {
    /// Torque up to which it holds and with which it slips, N·m.
    pub torque: f64,
    /// Time from the command until its torque acts, s; left out: 0.
    #[serde(default)]
    pub closing_time: f64,
}

impl Brake {
    /// Of a motor of 37 N·m: 1.35 times its rated torque, which holds 110 kN at the rod of the
    /// reference machine. It acts at once.
    pub const TYPICAL: Self = Self {
        torque: 50.0,
        closing_time: 0.0,
    };
}

/// Winding and housing as two bodies of one temperature each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Heat {
    /// Heat capacity of the winding, J/K.
    pub C_w: f64,
    /// Thermal resistance from winding to housing, K/W.
    pub R_wh: f64,
    /// Heat capacity of the housing, J/K.
    pub C_h: f64,
    /// Thermal resistance from housing to air, K/W.
    pub R_ha: f64,
}

impl Heat {
    /// Of a motor of 12 kW with its screw: at rated torque, 316 W of copper, the winding settles 66
    /// K above the air.
    pub const TYPICAL: Self = Self {
        C_w: 2e3,
        R_wh: 0.06,
        C_h: 15e3,
        R_ha: 0.15,
    };
}

/// `R_s = R_s,ref·(1 + α_Cu·ΔT)` with the winding's and `λ_m = λ_m,ref·(1 + α_m·ΔT)` with the
/// housing's temperature, which the rotor follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Temperature {
    /// Temperature at which `R_s` and `lambda_m` hold, K.
    pub reference: f64,
    /// Rise of the resistance α_Cu, 1/K.
    pub copper: f64,
    /// Rise of the magnets' flux α_m, 1/K.
    pub magnet: f64,
}

impl Temperature {
    /// Copper and neodymium magnets, from 20 °C.
    pub const TYPICAL: Self = Self {
        reference: 293.15,
        copper: 0.00393,
        magnet: -0.0011,
    };
}

/// Iron losses `P_core = (k_h·|w_e| + k_e·w_e²)·(lambda_d² + lambda_q²)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CoreLosses {
    /// Hysteresis coefficient, W·s/(rad·Wb²).
    pub k_h: f64,
    /// Eddy-current coefficient, W·s²/(rad²·Wb²).
    pub k_e: f64,
}

/// Losses of a two-level inverter with sinusoidal current of amplitude `i`:
/// conduction `3·(2/π·v_0·i + r_0·i²/2)`, switching `6/π·f_sw·k_sw·v_dc·i`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct InverterLosses {
    /// DC-link voltage, V.
    pub v_dc: f64,
    /// Switching frequency, Hz.
    pub f_sw: f64,
    /// Switching energy per volt and ampere, on and off together, J/(V·A).
    pub k_sw: f64,
    /// Threshold voltage of a device, V.
    pub v_0: f64,
    /// Differential resistance of a device, Ω.
    pub r_0: f64,
}

/// What the actuator is rated for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Ratings {
    /// Largest rod force, N.
    pub force_max: f64,
    /// Largest rod speed, m/s.
    pub rod_speed_max: f64,
    /// Rated motor power, W.
    pub motor_power: f64,
    /// Rated motor torque, N·m.
    pub motor_torque: f64,
    /// Rated motor speed, rev/min.
    pub motor_speed_rpm: f64,
}

impl Emla {
    /// Default voltage of the DC link, V: the inverter's `v_dc`; without one, the voltage at which
    /// [`largest_voltage`](Emla::largest_voltage) is `v_max`.
    pub fn link_voltage(&self) -> f64 {
        let given = self.inverter.map_or(0.0, |inverter| inverter.v_dc);
        if given > 0.0 {
            given
        } else {
            3.0_f64.sqrt() * self.v_max
        }
    }

    /// Largest phase voltage (peak) of the inverter with the DC-link voltage `v_dc`, V: `v_dc/√3`,
    /// the limit of space-vector modulation, but at most `v_max`.
    pub fn largest_voltage(&self, v_dc: f64) -> f64 {
        (v_dc / 3.0_f64.sqrt()).min(self.v_max)
    }

    /// Checks every value; for parameters that were not read by [`crate::Machine::from_json`].
    pub fn check(&self) -> Result<(), MachineError> {
        Findings::collect(|found| self.examine(found))
    }

    pub(crate) fn examine(&self, found: &mut Findings) {
        found.positive("emla.p", f64::from(self.p));
        examine! { found, "emla" of self;
            positive: R_s L_d L_q lambda_m J_m w_C N_gear w_eta rho J_s EA K_br K_n K_r GJ L_s
                M_act i_max v_max;
            not_negative: C_m tau_C C_s C_b C_act;
        }
        if !(self.eta_gear > 0.0 && self.eta_gear <= 1.0) {
            found.refuse("emla.eta_gear", self.eta_gear, "in (0, 1]");
        }
        if let Some(core) = self.core {
            examine! { found, "emla.core" of core; not_negative: k_h k_e; }
        }
        if let Some(inverter) = self.inverter {
            examine! { found, "emla.inverter" of inverter; not_negative: v_dc f_sw k_sw v_0 r_0; }
        }
        if let Some(brake) = self.brake {
            examine! { found, "emla.brake" of brake; not_negative: torque closing_time; }
        }
        if let Some(heat) = self.heat {
            examine! { found, "emla.heat" of heat; positive: C_w R_wh C_h R_ha; }
        }
        if let Some(t) = self.temperature {
            examine! { found, "emla.temperature" of t; positive: reference; }
            found.finite("emla.temperature", [t.copper, t.magnet]);
        }
    }
}

impl Ratings {
    pub(crate) fn examine(&self, found: &mut Findings) {
        examine! { found, "ratings" of self;
            positive: force_max rod_speed_max motor_power motor_torque motor_speed_rpm;
        }
    }
}
