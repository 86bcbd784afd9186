//! Files and texts with values: CSV logs, input tables, scenarios, and numbers as users write them.

pub mod cells;
#[cfg(feature = "native")]
pub mod csv;
pub mod input_table;
pub mod numbers;
pub mod scenario;
