//! Draws a machine on one sheet for `machine draw`, as crane makers print it: side view with named
//! points and dimensions, legend, workspace coloured by payload, payload over reach.

mod bands;
mod frame;
mod labels;
mod legend;
mod loads;
mod reach;
mod sheet;
mod side;

use std::path::Path;

use anyhow::Result;
use hdrm::Tree;
use machine_file::Machine;
use plotters::prelude::*;

use self::bands::Bands;
pub use self::sheet::Sheet;
use self::sheet::{FONT, HEAD};
use crate::load_chart::LoadChart;
use crate::side_view::SideView;
use charts::{Area, DrawResult, Picture, write};

/// Size of the sheet, of a view, of the title, pixels.
const SHEET: (u32, u32) = (1640, 1240);
const TITLE: u32 = 56;
const SPLIT: (u32, u32) = (820, 700);

impl Sheet {
    /// The sheet of a machine, with `name` as its title. Fails if the mechanism does not close.
    pub fn new(name: &str, machine: Machine, chart: LoadChart) -> Result<Self> {
        let tree = Tree::new(&machine)?;
        let view = SideView::new(&tree, &machine.start.zeta);
        let greatest = chart.points().filter_map(|p| p.payload).fold(0.0, f64::max);
        Ok(Self {
            name: name.into(),
            view,
            bands: Bands::new(greatest),
            machine,
            chart,
        })
    }

    /// Writes it as SVG or PNG, by the file's extension.
    pub fn write(&self, file: &Path) -> Result<()> {
        write(self, file, SHEET)
    }

    fn ratings(&self) -> String {
        let ratings = self.machine.ratings.in_order();
        let each = machine_file::AXES.into_iter().zip(ratings);
        let each = each.map(|(axis, r)| format!("{:.0} kN ({axis})", r.force_max / 1e3));
        Vec::from_iter(each).join(", ")
    }
}

impl Picture for Sheet {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.fill(&WHITE)?;
        let (title, rest) = area.split_vertically(TITLE);
        let start = self.machine.start.zeta.map(f64::to_degrees);
        title.draw(&Text::new(self.name.clone(), (24, 8), HEAD.into_font()))?;
        let subtitle = format!(
            "start pose: lift {:.0}°, tilt {:.0}°, tool at {:.0}° to the horizontal; lengths in mm; actuators rated for {}",
            start[1],
            start[2],
            self.chart.tool.to_degrees(),
            self.ratings()
        );
        title.draw(&Text::new(subtitle, (24, 34), FONT.into_font()))?;
        let (upper, lower) = rest.split_vertically(SPLIT.1);
        let (side, loads) = upper.split_horizontally(SPLIT.0);
        let (legend, reach) = lower.split_horizontally(SPLIT.0);
        self.side(&side)?;
        self.loads(&loads)?;
        self.legend(&legend)?;
        self.over_reach(&reach)
    }
}
