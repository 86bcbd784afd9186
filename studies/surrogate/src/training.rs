//! Trains the network as the paper does, by Levenberg–Marquardt on scaled data; for `train`.

pub mod lm;
pub mod network;
mod normal;
pub mod progress;

pub use normal::Form;
