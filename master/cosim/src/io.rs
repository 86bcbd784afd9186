//! Files and texts with values, for programs, Python, pages: CSV, input tables, scenarios, numbers,
//! digests.

pub mod cells;
#[cfg(feature = "native")]
pub mod csv;
pub mod digest;
pub mod input_table;
pub mod numbers;
pub mod scenario;
