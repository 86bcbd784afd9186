//! Pictures of the rig: efficiency of physics, hybrid and rig in quadrants I and IV, and responses
//! over time.

use std::path::{Path, PathBuf};

use anyhow::Result;
use charts::{Area, DrawResult, Picture, save};
use emla::Surrogate;
use plotters::prelude::*;
use rig_data::efficiency_map::maps;
use rig_data::prediction::Model;
use rig_data::profile::SPEED;
use rig_data::responses::{Panel, responses};
use rig_data::windows::Window;

use crate::plots::{EfficiencyMaps, FONT, MAP_CELLS, SIZE, TITLE};

/// All pictures, in a folder; `work` is a held-out profile.
///
/// # Errors
/// A picture that cannot be written.
pub fn all(
    models: &[Model; 3],
    surrogate: &Surrogate,
    work: &[Window],
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let maps = maps(models, MAP_CELLS)?;
    let speeds = [-SPEED[1], SPEED[1]];
    let files = [
        save(
            &EfficiencyMaps {
                maps: &maps,
                speeds,
            },
            folder,
            "rig_efficiency_maps",
            SIZE,
        )?,
        save(
            &Responses {
                panels: responses(surrogate, work),
            },
            folder,
            "rig_responses",
            SIZE,
        )?,
    ];
    Ok(files.concat())
}

/// Force, kN, and rod speed, mm/s, over time, s: desired and rig above, network and rig below.
struct Responses {
    panels: [Panel; 4],
}

impl Picture for Responses {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.fill(&WHITE)?;
        for (panel, part) in self.panels.iter().zip(area.split_evenly((2, 2))) {
            let points = || panel.lines.iter().flat_map(|line| &line.1);
            let end = points().fold(0.0_f64, |m, p| m.max(p.0));
            let (low, high) =
                points().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)));
            let mut chart = ChartBuilder::on(&part)
                .caption(panel.title, TITLE)
                .margin(8)
                .x_label_area_size(36)
                .y_label_area_size(52)
                .build_cartesian_2d(0.0..end, low..high)?;
            chart
                .configure_mesh()
                .label_style(FONT)
                .x_desc("time, s")
                .y_desc(panel.unit)
                .draw()?;
            for ((name, line), color) in panel.lines.iter().zip([BLUE, RED]) {
                // Windows in which the rod stands or turns are left out: a line does not bridge
                // them.
                for piece in line.chunk_by(|a, b| b.0 - a.0 < 0.03) {
                    chart.draw_series(LineSeries::new(
                        piece.iter().copied(),
                        color.stroke_width(1),
                    ))?;
                }
                chart
                    .draw_series(std::iter::empty::<PathElement<(f64, f64)>>())?
                    .label(*name)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], color));
            }
            chart
                .configure_series_labels()
                .label_font(FONT)
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK)
                .draw()?;
        }
        Ok(())
    }
}
