//! Data of the rig, and training of the actuator's surrogate network on them.
//!
//! The rig is a simulation of the actuator as built (crate `rig`), the same that the machine is tried with; nothing here is a measurement,
//! unless a user brings a CSV file of his own ([`data`]). Training is Levenberg–Marquardt as in the paper
//! ([`lm`], [`training`]) on scaled inputs and targets; the trained network is evaluated by
//! [`emla::Surrogate`]. SI units; dq quantities peak-valued. Source: the paper's section
//! "Surrogate-Enhanced Hybrid Model of the EMLA".
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

pub mod campaign;
pub mod commands;
pub mod coupled_run;
pub mod data;
pub mod lm;
pub mod network;
pub mod normal;
pub mod plots;
pub mod prediction;
pub mod profile;
pub mod rig_commands;
pub mod rig_plots;
pub mod rig_run;
pub mod training;
pub mod windows;

/// The network that was trained on the rig, `parameters/surrogate_rig.json`.
pub const RIG_NETWORK: &str = include_str!("../../../parameters/surrogate_rig.json");
