//! The section `geometry` of a machine file, for `hdrm` and `motion-check`: mechanism dimensions.

use crate::check::{Findings, examine};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Dimensions, m and rad.
///
/// World frame: x forward, y up, z = x × y. Points with two coordinates lie in the boom plane,
/// which turns with `zeta_1` about y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Lift joint O in T1.
    pub r_T1_O: [f64; 3],
    /// Radius of the slew mechanism: `x_1 = x1_mid + r_B·zeta_1`.
    pub r_B: f64,
    /// Slew stroke at `zeta_1 = 0`.
    pub x1_mid: f64,
    /// Distance O to the lift cylinder's rod pin, L_1_2.
    pub L1_2: f64,
    /// Distance O to the lift cylinder's foot, L_2_2.
    pub L2_2: f64,
    /// Angle of the foot from the downward vertical, rad.
    pub beta1: f64,
    /// Angle from O→rod pin up to the boom axis, rad.
    pub beta2: f64,
    /// Length of the lift actuator at stroke zero.
    pub x0_2: f64,
    /// Length of the lift actuator's rod body behind its pin, l_c2.
    pub lc_2: f64,
    /// Tilt joint B from O in boom axes.
    pub r_O_B: [f64; 3],
    /// Rocker pivot A from B in boom axes.
    pub A_in_boom: [f64; 2],
    /// Tilt actuator's foot E from B in boom axes.
    pub E_in_boom: [f64; 2],
    /// Coupler pivot C from B in tilt-boom axes.
    pub C_in_tilt: [f64; 2],
    /// Rocker length |AD|, d_4.
    pub d4: f64,
    /// Coupler length |CD|, d_5.
    pub d5: f64,
    /// Length of the tilt actuator at stroke zero.
    pub x0_3: f64,
    /// Length of the tilt actuator's rod body behind its pin, l_c3.
    pub lc_3: f64,
    /// Wrist base B4 from B in tilt-boom axes.
    pub r_B_B4: [f64; 3],
    /// First wrist joint A4 from B4 in B4 axes.
    pub r_B4_A4: [f64; 3],
    /// Second wrist joint C4 from A4 in A4 axes.
    pub r_A4_C4: [f64; 3],
    /// Third wrist joint D4 from C4 in C4 axes.
    pub r_C4_D4: [f64; 3],
    /// Tip T4 from D4 in D4 axes.
    pub r_D4_T4: [f64; 3],
}

impl Geometry {
    pub(crate) fn examine(&self, found: &mut Findings) {
        examine! { found, "geometry" of self;
            positive: r_B L1_2 L2_2 x0_2 lc_2 d4 d5 x0_3 lc_3;
        }
        found.finite("geometry.x1_mid", [self.x1_mid]);
        for (name, beta) in [("beta1", self.beta1), ("beta2", self.beta2)] {
            if !(-PI..=PI).contains(&beta) {
                let rule = format!("within ±π rad; in degrees it is `{name}_deg`");
                found.refuse(format_args!("geometry.{name}"), beta, rule);
            }
        }
        let rods = [("2", self.lc_2, self.x0_2), ("3", self.lc_3, self.x0_3)];
        for (k, lc, x0) in rods {
            if lc > x0 {
                let rule = format!("at most `x0_{k}` = {x0}, the length of the retracted actuator");
                found.refuse(format_args!("geometry.lc_{k}"), lc, rule);
            }
        }
        examine! { found, "geometry" of self;
            finite: r_T1_O r_O_B A_in_boom E_in_boom C_in_tilt r_B_B4 r_B4_A4 r_A4_C4 r_C4_D4
                r_D4_T4;
        }
    }
}
