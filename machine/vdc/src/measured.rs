//! Which measurements the control law is given: joint rates of an observer, samples that are held,
//! and predictions over a delay.

mod observer;
mod prediction;
mod sampling;

pub(crate) use observer::JointObserver;
pub(crate) use prediction::{Plan, predict};
pub use sampling::{DELAY_MAX, Timing};
pub(crate) use sampling::{SAMPLES_MAX, SLACK, Sampling};
