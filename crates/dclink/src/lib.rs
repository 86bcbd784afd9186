//! The DC link of electric drives: a battery pack, the capacitor that the drives draw from, precharge, and a brake chopper.
//!
//! ```text
//!        R_0    R_1‖C_1  R_2‖C_2   R_line (+ R_precharge)
//!   ┌───▭▭▭────▭▭▭─────▭▭▭────────▭▭▭──[limit]──┬───────┬────────┐ v_dc
//!  v_oc(soc)                                     │ C     ▯ R_brake ↓ Σ i_load
//!   └────────────────────────────────────────────┴───────┴────────┘
//! ```
//!
//! The pack is the equivalent circuit of the textbooks (Plett, *Battery Management Systems*, vol. I, ch. 2): an open-circuit voltage that
//! follows the charge, a series resistance and up to two RC pairs, with one heat node. The voltage of the capacitor is a state, so that
//! `v_dc` never depends on `i_load` at once. What the pack may give and take is limited; the chopper switches where the voltage passes its
//! thresholds, which are located as events inside a step, not averaged.
//!
//! Currents are positive where they leave the pack. SI units throughout, but the capacity in ampere hours. [`DcLink`] is the configuration;
//! [`State`] is passed by value, so a step that fails changes nothing.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // symbols of the books

mod circuit;
mod pack;
mod params;
mod state;
mod step;

pub use circuit::{Mode, Regime};
pub use pack::Pack;
pub use params::{Battery, Brake, Link, POINTS, ParamError, Params, Precharge};
pub use state::{Energies, Output, State};
pub use step::StepError;

use serde::{Deserialize, Serialize};

/// Drives on the link.
pub const LOADS: usize = 3;

/// What acts on the link; held over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Currents that the drives draw, A; negative where they give back.
    pub i_load: [f64; LOADS],
    /// Temperature around the pack, K.
    pub T_ambient: f64,
}

/// The link: parameters that have been checked, and what follows from them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DcLink {
    p: Params,
    pack: Pack,
    /// 1/resistance in the way of the pack's current, S: during precharge and after.
    conductance: [f64; 2],
    /// 1/C of the capacitor, 1/F, and 1/R of the brake resistor, S.
    inverse: [f64; 2],
    /// Longest substep, s.
    dt_max: f64,
}

impl DcLink {
    /// The link with the parameters `p`.
    ///
    /// # Errors
    /// The first parameter that does not fit, with its value and what must hold.
    pub fn new(p: Params) -> Result<Self, ParamError> {
        p.check()?;
        let R = p.battery.R_0 + p.link.R;
        Ok(Self {
            p,
            pack: Pack::new(&p.battery),
            conductance: [1.0 / (R + p.precharge.R), 1.0 / R],
            inverse: [1.0 / p.link.C, 1.0 / p.brake.R],
            dt_max: step::longest_substep(&p),
        })
    }

    /// Its parameters.
    pub fn params(&self) -> &Params {
        &self.p
    }
}
