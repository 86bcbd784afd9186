//! Levenberg–Marquardt training as in the paper, on scaled inputs and targets.

pub mod lm;
pub mod network;
mod normal;
pub mod progress;

pub use normal::Form;
