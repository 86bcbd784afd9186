//! Native co-simulation master for FMI 2.0: runs a system of FMUs as its SSP system structure describes it.
//!
//! The structure says which FMUs there are, who is wired to whom, in which order they are stepped and which connections are power bonds
//! ([`ssd`]); the model descriptions say which outputs depend directly on which inputs ([`description`]); both give the order of the
//! exchange ([`wiring`], [`exchange`]). [`master`] initializes and steps, [`run`] makes an experiment of it, [`table`] many in parallel.
//! FMUs are unpacked and called through the `fmi` crate ([`fmu`], [`slave`]).
//!
//! Nothing here knows the physics: names that experiments refer to (`tip_error_norm`, `settle_time`, `trajectory`, `mode`,
//! `inertia_scale`) are variables of the FMUs.
#![deny(unsafe_code)]

pub mod bond;
pub mod description;
pub mod endurance;
pub mod energy;
pub mod exchange;
pub mod fmu;
pub mod master;
pub mod messages;
pub mod noise;
pub mod package;
pub mod recording;
pub mod report;
pub mod robustness;
pub mod run;
pub mod signals;
pub mod slave;
pub mod ssd;
pub mod stability;
pub mod system;
pub mod table;
pub mod testbed;
pub mod tip;
pub mod wiring;
