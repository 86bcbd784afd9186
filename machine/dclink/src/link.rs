//! A DC link as the FMU `DcLink` builds it: checked parameters, and constants computed from them.

use crate::pack::Pack;
use crate::params::Params;
use model_rules::ParamError;
use serde::{Deserialize, Serialize};

/// Longest substep in units of the fastest time constant: two substeps per millisecond for the
/// reference link. The error of the method's e^z is z⁷/1512 (its seventh power has the factor
/// −1/2160 instead of 1/5040), so a step response is off by at most `z⁶ e^(z−1)/1512`, 3e-7 here.
const SUBSTEP: f64 = 0.31;

/// A DC link: checked parameters, and constants that follow from them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DcLink {
    pub(crate) p: Params,
    pub(crate) pack: Pack,
    /// 1/resistance in the way of the pack's current, S: during precharge and after.
    pub(crate) conductance: [f64; 2],
    /// 1/C of the capacitor, 1/F, and 1/R of the brake resistor, S.
    pub(crate) inverse: [f64; 2],
    /// Longest substep, s.
    pub(crate) dt_max: f64,
}

impl DcLink {
    /// The link with the parameters `p`, or the first parameter that is out of its range.
    pub fn new(p: Params) -> Result<Self, ParamError> {
        p.check()?;
        let R = p.battery.R_0 + p.link.R;
        Ok(Self {
            p,
            pack: Pack::new(&p.battery),
            conductance: [1.0 / (R + p.precharge.R), 1.0 / R],
            inverse: [1.0 / p.link.C, 1.0 / p.brake.R],
            dt_max: longest_substep(&p),
        })
    }

    /// The parameters it was made with.
    pub fn params(&self) -> &Params {
        &self.p
    }
}

/// Longest substep for these parameters, s.
fn longest_substep(p: &Params) -> f64 {
    let (b, link) = (&p.battery, &p.link);
    let mut fastest = link.C * (b.R_0 + link.R);
    if p.brake.fitted {
        fastest = 1.0 / (1.0 / fastest + 1.0 / (link.C * p.brake.R));
    }
    for k in [0, 1] {
        if b.R[k] > 0.0 {
            fastest = fastest.min(b.tau[k]);
        }
    }
    SUBSTEP * fastest
}
