//! Data of the rig, and what physics, hybrid and network predict of it.
//!
//! The rig is a simulation of the actuator as built (crate `rig`), the same that the machine is
//! tried with; nothing here is a measurement, unless a user brings a CSV file of his own
//! ([`data`]). SI units; dq quantities peak-valued. Source: the paper's section "Surrogate-Enhanced
//! Hybrid Model of the EMLA".
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

pub mod campaign;
pub mod conformal;
pub mod coupled_run;
pub mod data;
pub mod drive_control;
pub mod efficiency_map;
pub mod free_run;
pub mod identification;
pub mod judgement;
pub mod least_squares;
pub mod lookup;
pub mod prediction;
pub mod profile;
pub mod resampling;
pub mod responses;
pub mod rig_run;
pub mod signal_file;
pub mod windows;

/// The network that was trained on the rig, `parameters/surrogate_rig.json`.
pub const RIG_NETWORK: &str = include_str!("../../../parameters/surrogate_rig.json");
