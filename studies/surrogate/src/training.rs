//! Trains the network as the paper does: by Levenberg–Marquardt, on scaled inputs and targets.

pub mod lm;
pub mod network;
mod normal;
pub mod progress;

pub use normal::Form;
