//! Training of the actuator's surrogate network, and pictures of what it does.
//!
//! Levenberg–Marquardt as in the paper ([`lm`], [`training`]) on scaled inputs and targets, on the
//! data of crate `rig-data` or on a user's CSV file; the trained network is evaluated by
//! [`emla::Surrogate`]. SI units. Source: the paper's section "Surrogate-Enhanced Hybrid Model of
//! the EMLA".
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

pub mod commands;
mod files;
pub mod lm;
pub mod network;
pub mod normal;
pub mod plots;
pub mod rig_commands;
pub mod rig_plots;
pub mod training;
