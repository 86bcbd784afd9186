//! Prepares the measurements for `controller`: joint rates by an observer, sample and hold, and
//! prediction over a delay.

mod observer;
mod prediction;
mod sampling;

pub(crate) use observer::JointObserver;
pub(crate) use prediction::{Plan, predict};
pub use sampling::{DELAY_MAX, Timing};
pub(crate) use sampling::{SAMPLES_MAX, SLACK, Sampling};
