//! Whether a machine can do a motion: what the motion demands of rods, wrist and motors, and the
//! margin to what the machine file allows.
//!
//! Statics and dynamics are those of `hdrm` and `emla` with the machine file's nominal parameters;
//! nothing is simulated. [`Kinematics`] finds the joint motion of a tip motion, [`DemandModel`] what
//! it demands ([`Demand`]), [`AllowedRanges`] what is allowed, each limit with its [`Margin`]. Frames and
//! symbols are those of `hdrm`. Nothing of these allocates. [`gain_rule`] makes the controller's
//! gains of a machine.
//!
//! Left out: the elasticity between nut and rod, the direct-axis current (zero) and the voltage
//! `L_q·di_q/dt` (0.3 V at 100 A/s on the reference machine).
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // symbols of the paper

mod allowed_ranges;
mod demand;
pub mod gain_rule;
mod kinematics;
mod quantity;
mod reach;
mod rotation;

pub use allowed_ranges::{AllowedRanges, Margin};
pub use demand::{Demand, DemandModel, Motion, Payload};
pub use kinematics::{Kinematics, NearestPose, Pose, TipMotion};
pub use quantity::Quantity;
pub use reach::Reach;
pub use rotation::{rotation_vector, turn};
