//! What is made of machine files: other sizes, load charts, drawings.

pub mod drawing;
pub mod lasting;
pub mod load_chart;
pub mod scaling;
mod side_view;
