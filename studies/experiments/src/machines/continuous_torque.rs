//! The torque that each motor can give continuously at standstill; `machine check`, load chart and
//! legend of `machine draw` compare it with the torque that holds the machine.
#![allow(non_snake_case)] // symbols of the machine file

use machine_file::{Emla, Heat, Machine, Ratings};
use surrogate::measurement::windows::{magnets, resistance};

use crate::analyses::sizing::WINDING_LIMIT;

/// Air around the motors, K: the 40 °C for which IEC 60034-1 rates machines.
const AIR: f64 = 313.15;

/// Continuous torque at standstill and its cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuousTorque {
    /// Torque, N·m.
    pub torque: f64,
    /// What limits it: the rated torque, or the winding's temperature.
    pub by: &'static str,
}

const RATED: &str = "rated";
const WINDING: &str = "winding at 155 °C";

impl ContinuousTorque {
    /// The torques of slew, lift and tilt.
    pub fn from_machine(machine: &Machine) -> [Self; 3] {
        let (emla, ratings) = (machine.emla.in_order(), machine.ratings.in_order());
        std::array::from_fn(|i| Self::new(emla[i], ratings[i]))
    }

    /// The lower of the rated torque and the one at which the winding settles at its limit.
    fn new(emla: &Emla, ratings: &Ratings) -> Self {
        let (warm, rated) = (warm_torque(emla), ratings.motor_torque);
        let (torque, by) = match warm < rated {
            true => (warm, WINDING),
            false => (rated, RATED),
        };
        Self { torque, by }
    }
}

/// Torque at which winding and housing settle with the winding at its limit T, N·m: copper losses
/// flow through both thermal resistances,
/// ```text
/// 3/2 R_s(T) i² = (T − T_air)/(R_wh + R_ha),   τ = 3/2 p λ_m(T_h) i,   T_h = T_air + R_ha·(T − T_air)/(R_wh + R_ha)
/// ```
fn warm_torque(emla: &Emla) -> f64 {
    let heat = emla.heat.unwrap_or(Heat::TYPICAL);
    let P = (WINDING_LIMIT - AIR) / (heat.R_wh + heat.R_ha);
    let i = (P / (1.5 * resistance(emla, WINDING_LIMIT))).sqrt();
    1.5 * f64::from(emla.p) * magnets(emla, AIR + heat.R_ha * P) * i
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::EmlaFields;

    /// Oracle: the heat balance of two nodes and a warm motor, stepped to its steady state at the
    /// torque that was found, ends at the winding's limit.
    #[test]
    fn at_the_warm_torque_the_winding_settles_at_its_limit() {
        let emla = Emla {
            heat: Some(Heat {
                C_w: 900.0,
                R_wh: 0.07,
                C_h: 3000.0,
                R_ha: 0.23,
            }),
            ..Machine::reference().emla.lift
        };
        let fields = EmlaFields::new(emla);
        let (heat, warm) = (fields.heat, fields.temperature);
        let torque = warm_torque(&emla);
        let [mut winding, mut housing] = [AIR; 2];
        for _ in 0..40_000 {
            let flux = emla.lambda_m * (1.0 + warm.magnet * (housing - warm.reference));
            let i = torque / (1.5 * f64::from(emla.p) * flux);
            let R = emla.R_s * (1.0 + warm.copper * (winding - warm.reference));
            let inwards = (winding - housing) / heat.R_wh;
            winding += (1.5 * R * i * i - inwards) / heat.C_w;
            housing += (inwards - (housing - AIR) / heat.R_ha) / heat.C_h;
        }
        assert!((winding - WINDING_LIMIT).abs() < 1e-3, "{winding}");
    }

    #[test]
    fn the_lower_of_rating_and_winding_counts() {
        let mut machine = Machine::reference();
        machine.ratings.lift.motor_torque = 1e3;
        machine.ratings.tilt.motor_torque = 1.0;
        let [_, lift, tilt] = ContinuousTorque::from_machine(&machine);
        assert_eq!(lift.by, WINDING);
        assert_eq!((tilt.by, tilt.torque), (RATED, 1.0));
    }
}
