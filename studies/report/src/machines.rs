//! A machine on a sheet: its drawing and its load chart.

pub mod drawing;
pub mod load_chart;
mod side_view;
