//! Values as people and files write them: tables, scenarios.

pub mod cells;
#[cfg(feature = "native")]
pub mod csv;
pub mod input_table;
pub mod numbers;
pub mod scenario;
