//! Model of the DC link that supplies electric drives: a battery pack, the link capacitor,
//! precharge, and a brake chopper. The FMU `DcLink` wraps it.
//!
//! ```text
//!        R_0    R_1‖C_1  R_2‖C_2   R_line (+ R_precharge)
//!   ┌───▭▭▭────▭▭▭─────▭▭▭────────▭▭▭──[limit]──┬───────┬────────┐ v_dc
//!  v_oc(soc)                                     │ C     ▯ R_brake ↓ Σ i_load
//!   └────────────────────────────────────────────┴───────┴────────┘
//! ```
//!
//! The pack is an equivalent circuit (Plett, *Battery Management Systems*, vol. I, ch. 2): an
//! open-circuit voltage that depends on the charge, a series resistance and up to two RC pairs,
//! with one thermal node. The capacitor's voltage is a state, so `v_dc` has no direct feedthrough
//! from `i_load`. The pack's current is limited in both directions. The chopper switches where the
//! voltage passes its thresholds; these instants are located as events inside a step.
//!
//! Currents are positive when they leave the pack. SI units throughout, except the capacity in
//! ampere hours. [`DcLink`] is the immutable configuration; [`State`] is passed by value, so a step
//! that fails changes nothing.
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
pub use model_rules::{ParamError, Seconds, StepError};
pub use output::Output;
pub use pack::Pack;
pub use params::{Battery, Brake, Link, POINTS, Params, Precharge};
pub use state::{Energies, Mode, Regime, State};
