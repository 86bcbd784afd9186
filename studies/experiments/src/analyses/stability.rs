//! The stability proof in numbers, for the subcommand `stability` and the report: its bound along
//! runs, by which cause the bound is exceeded, and the gain conditions.

mod causes;
mod gains;
mod run;
mod study;

pub(crate) use causes::{causes, compliance};
pub use gains::{Condition, Gains};
pub use run::{Power, Powers, Run};
pub(crate) use study::judge;
pub use study::{RUNS, run};
