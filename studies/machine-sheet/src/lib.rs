//! A machine on a sheet, for the command `machine draw`: its drawing and its load chart.

pub mod drawing;
pub mod load_chart;
mod side_view;
