//! What is drawn of the experiments: the evaluation as a page ([`report`]), machines on a sheet ([`machines`]), signals over time ([`plot`]),
//! figures of sizing and of paths. Numbers come from crate `studies`.
#![forbid(unsafe_code)]

pub mod machines;
pub mod margins_figure;
pub mod plot;
pub mod report;
pub mod sizing_figure;
