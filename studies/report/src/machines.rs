//! Machines on a sheet: load charts and drawings.

pub mod drawing;
pub mod load_chart;
mod side_view;
