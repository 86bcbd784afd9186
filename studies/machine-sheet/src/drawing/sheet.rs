//! The data of a machine's sheet, which `drawing` fills in and all views draw, and its fonts.

use machine_file::Machine;

use super::bands::Bands;
use crate::load_chart::LoadChart;
use crate::side_view::SideView;

pub(super) const FONT: (&str, i32) = ("sans-serif", 15);
pub(super) const SMALL: (&str, i32) = ("sans-serif", 13);
pub(super) const HEAD: (&str, i32) = ("sans-serif", 20);

/// A machine with all that its sheet shows.
pub struct Sheet {
    pub(super) name: String,
    pub(super) machine: Machine,
    pub(super) view: SideView,
    pub(super) chart: LoadChart,
    pub(super) bands: Bands,
}
