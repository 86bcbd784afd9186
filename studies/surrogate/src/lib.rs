//! The actuator's surrogate network, from the rig to the judgement: what the rig measures
//! ([`measurement`]), what physics, look-up map, network and hybrid predict of it ([`prediction`]),
//! how well they do on profiles that none of them has seen ([`judgement`]), how the network is
//! trained (`training`, with the feature of this name, which is on by default). The program
//! `hdrm-fmu-surrogate` does all this and draws it.
//!
//! The rig is a simulation of the actuator as built (crate `rig`), the same that the machine is
//! tried with; nothing here is a measurement, unless a user brings a CSV file of his own
//! ([`measurement::data`]). The trained network is evaluated by [`emla::Surrogate`]. SI units; dq
//! quantities peak-valued. Source: the paper's section "Surrogate-Enhanced Hybrid Model of the
//! EMLA".
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

pub mod judgement;
pub mod measurement;
pub mod prediction;
#[cfg(feature = "training")]
pub mod training;

/// The network that was trained on the rig, `parameters/surrogate_rig.json`.
pub const RIG_NETWORK: &str = include_str!("../../../parameters/surrogate_rig.json");
