//! How a run comes from its start to its end.

mod fixed;

pub use fixed::FixedSteps;
