//! The stability proof in numbers.

mod causes;
mod gains;
mod run;
mod study;

pub use causes::{causes, compliance};
pub use gains::{Condition, Gains};
pub use run::{Power, Powers, Run};
pub use study::{RUNS, judge, run};
