//! Values as people and files write them: tables, scenarios, standard output.

pub mod cells;
#[cfg(feature = "native")]
pub mod csv;
pub mod input_table;
pub mod numbers;
pub mod output;
pub mod scenario;
pub mod value;
