//! Damaged saved states of the FMU; its source is included, because a library with C symbols is
//! never linked into another.
#![no_main]

#[path = "../../../fmu-controller/src/lib.rs"]
#[allow(missing_docs)]
mod fmu;
#[path = "../saved_state.rs"]
mod saved_state;

use fmu::ControllerFmu;

libfuzzer_sys::fuzz_target!(|data: &[u8]| saved_state::run::<ControllerFmu>(data));
