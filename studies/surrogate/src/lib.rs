//! The pipeline of the actuator's surrogate network: data of the rig ([`measurement`]), predictions
//! by physics, look-up map, network and hybrid ([`prediction`]), their errors on held-out profiles
//! ([`judgement`]), and the network's training (`training`, a default feature). The program
//! `hdrm-fmu-surrogate` runs it; crates `experiments` and `report` use it without training.
//!
//! The rig is a simulation of the actuator as built (crate `rig`), the same as in the machine of
//! the real world; nothing here is measured, unless a user brings a CSV file
//! ([`measurement::data`]). [`emla::Surrogate`] evaluates the trained network. SI units; dq
//! quantities peak-valued. Source: `[paper]`, "Surrogate-Enhanced Hybrid Model of the EMLA".
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

pub mod judgement;
pub mod measurement;
pub mod prediction;
#[cfg(feature = "training")]
pub mod training;

/// The network that was trained on the rig, `parameters/surrogate_rig.json`.
pub const RIG_NETWORK: &str = include_str!("../../../parameters/surrogate_rig.json");
