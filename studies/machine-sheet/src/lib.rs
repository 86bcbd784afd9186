//! A machine on a sheet, for the command `machine draw` and the Python package: its drawing
//! ([`Sheet`]) and its load chart ([`LoadChart`]).
#![forbid(unsafe_code)]

mod drawing;
mod load_chart;
mod side_view;

pub use drawing::Sheet;
pub use load_chart::{LoadChart, LoadPoint};
