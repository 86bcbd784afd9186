//! Sensor models between the plants and the controller: encoders of motors, joints and rods, speed
//! estimates from positions, currents, forces, calibration errors, and communication delay, for the
//! FMU `Sensors` and for the virtual test rig of the study `surrogate`.
//!
//! A sensor samples at communication points. Its reading depends on the present inputs and on
//! [`State`]: the previous reading, filters, and the noise of the next sample. Constant errors
//! (joint zeros, gains, offsets, biases) are drawn once from the seed; noise is drawn for each
//! sample from the generator in the state. With every effect off ([`Params::OFF`]) values pass bit
//! for bit. Switching an effect on or off does not change the random numbers of the others.
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
    SpeedKind, W_M_MAX, X_DOT_MAX, ZETA_DOT_MAX,
};
pub use random::{FixedErrors, Noise};
pub use sample::{Sample, Signals, State};
pub use sensors::Sensors;
