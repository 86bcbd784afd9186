//! The DC link of electric drives: a battery pack, the capacitor that the drives draw from,
//! precharge, and a brake chopper.
//!
//! ```text
//!        R_0    R_1‖C_1  R_2‖C_2   R_line (+ R_precharge)
//!   ┌───▭▭▭────▭▭▭─────▭▭▭────────▭▭▭──[limit]──┬───────┬────────┐ v_dc
//!  v_oc(soc)                                     │ C     ▯ R_brake ↓ Σ i_load
//!   └────────────────────────────────────────────┴───────┴────────┘
//! ```
//!
//! The pack is the equivalent circuit of the textbooks (Plett, *Battery Management Systems*, vol.
//! I, ch. 2): an open-circuit voltage that follows the charge, a series resistance and up to two RC
//! pairs, with one heat node. The voltage of the capacitor is a state, so that `v_dc` never depends
//! on `i_load` at once. What the pack may give and take is limited; the chopper switches where the
//! voltage passes its thresholds, which are located as events inside a step, not averaged.
//!
//! Currents are positive where they leave the pack. SI units throughout, but the capacity in ampere
//! hours. [`DcLink`] is the configuration; [`State`] is passed by value, so a step that fails
//! changes nothing.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // symbols of the books

mod circuit;
mod continuous;
mod input;
mod link;
mod output;
mod pack;
mod params;
mod state;
mod step;

pub use continuous::ENDS;
pub use input::{Input, LOADS};
pub use link::DcLink;
pub use model_rules::{ParamError, StepError};
pub use output::Output;
pub use pack::Pack;
pub use params::{Battery, Brake, Link, POINTS, Params, Precharge};
pub use state::{Energies, Mode, Regime, State};
