//! Results as text, CSV and JSON, for the commands and the report.

pub mod comparison;
pub mod energy;
pub mod output;
pub mod sizing;
pub mod stability;
pub mod surrogate_loop;
pub mod testbed;
pub mod tip_errors;
