//! Checks whether a machine can do a given motion, without simulating it: inverse kinematics and
//! inverse dynamics give the forces, speeds, torques, currents and voltages that the motion
//! requires, which are compared with the limits of the machine file. Used by `tip-path` before a
//! path starts, by the controller, the studies and the Python package.
//!
//! [`Kinematics`] turns a tip motion into a joint motion, [`DemandModel`] computes the [`Demand`]
//! of that, and [`AllowedRanges`] the [`Margin`] of each quantity to its limits. The equations are
//! those of `hdrm` and `emla` with the nominal parameters. None of them allocates. Apart from that,
//! [`gain_rule`] computes gains of the controller for a machine.
//!
//! Neglected: the elasticity between nut and rod, the direct-axis current (zero) and the voltage
//! `L_q·di_q/dt` (0.3 V at 100 A/s on the reference machine).
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // symbols of the paper

mod allowed_ranges;
mod demand;
mod drive_loop;
pub mod gain_rule;
mod kinematics;
mod quantity;
mod reach;
mod rotation;

pub use allowed_ranges::{AllowedRanges, Margin};
pub use demand::{Demand, DemandModel, Motion, Payload};
pub use drive_loop::Mode;
pub use kinematics::{Kinematics, NearestPose, Pose, TipMotion};
pub use quantity::Quantity;
pub use reach::Reach;
pub use rotation::{rotation_vector, turn};
