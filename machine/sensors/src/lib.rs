//! Sensors of the manipulator, between its plants and its controller: encoders of motors, joints
//! and rods, speeds that are estimated rather than known, currents, forces, calibration errors, and
//! the time that communication takes.
//!
//! A sensor samples at communication points. Its reading follows the present inputs; what it
//! remembers (the reading before, filters, noise of the coming sample) is in [`State`]. Errors that
//! stay (zero of a joint, gain and offset of a current, bias of a force) are drawn once from the
//! seed, noise anew for each sample from the generator that the state carries. With every effect
//! off, which is [`Params::OFF`], values pass bit for bit. Each effect has its own place in the
//! generator's sequence: switching one on or off changes no number of another.
//!
//! SI units; currents in rotor coordinates, peak-valued; rod position and force positive when the
//! actuator extends.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod current;
mod encoder;
mod force;
mod normal;
mod params;
mod random;
mod sample;
mod sensors;
mod speed;

pub use params::{
    ACTUATORS, Current, DELAY_MAX, Encoder, Force, ForceKind, JOINTS, JointZero, Params, Speed,
    SpeedKind,
};
pub use random::{FixedErrors, Noise};
pub use sample::{Sample, Signals, State};
pub use sensors::Sensors;
