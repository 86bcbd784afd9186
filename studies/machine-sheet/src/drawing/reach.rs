//! On the sheet of `machine draw`: the view of the greatest payload over reach.

use plotters::prelude::*;

use super::frame::series_names;
use super::sheet::{FONT, SMALL, Sheet};
use crate::load_chart::LoadPoint;
use charts::{Area, DrawResult, wheel};

/// Number of intervals that the reach is divided into.
const CLASSES: usize = 60;

impl Sheet {
    /// Draws the greatest payload at any height, coloured by what limits it, the one that holds at
    /// every height, and the greatest that may be held continuously.
    pub(super) fn over_reach<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        let classes = self.classes();
        let last = classes.iter().map(|c| c.best.reach).fold(0.0, f64::max);
        let greatest = classes
            .iter()
            .filter_map(|c| c.best.payload)
            .fold(1.0, f64::max);
        let mut chart = ChartBuilder::on(area)
            .caption("Greatest payload over reach", FONT)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..1.05 * last, 0.0..1.1 * greatest)?;
        chart
            .configure_mesh()
            .max_light_lines(2)
            .light_line_style(BLACK.mix(0.05))
            .bold_line_style(BLACK.mix(0.12))
            .x_desc("distance of the tip from the slew axis, m")
            .y_desc("payload, kg")
            .label_style(SMALL)
            .axis_desc_style(FONT)
            .y_label_formatter(&|payload| format!("{payload:.0}"))
            .draw()?;
        type Payload = fn(&Class) -> f64;
        let lines: [(Payload, _, _); 2] = [
            (
                |c| c.least,
                RGBColor(110, 110, 110),
                "at every height that is reached",
            ),
            (
                |c| c.lasting,
                RGBColor(110, 70, 170),
                "at the best height, for ever (lasting motor torques)",
            ),
        ];
        for (value, color, label) in lines {
            let points = classes.iter().map(|c| (c.best.reach, value(c)));
            let style = color.stroke_width(2);
            chart
                .draw_series(LineSeries::new(points, style))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
        let mut limits: Vec<_> = Vec::new();
        for class in &classes {
            if !limits.contains(&class.best.limit) {
                limits.push(class.best.limit);
            }
        }
        for (k, limit) in limits.iter().enumerate() {
            let color = wheel(k, limits.len());
            let of_limit = classes.iter().filter(|c| c.best.limit == *limit);
            let dots = of_limit.map(|c| {
                let place = (c.best.reach, c.best.payload.unwrap_or(0.0));
                Circle::new(place, 4, color.filled())
            });
            chart
                .draw_series(dots)?
                .label(format!("at the best height, limited by {limit}"))
                .legend(move |(x, y)| Circle::new((x + 9, y), 4, color.filled()));
        }
        series_names(&mut chart, SeriesLabelPosition::LowerLeft)
    }

    fn classes(&self) -> Vec<Class> {
        let last = self.chart.points().map(|p| p.reach).fold(0.0, f64::max);
        let mut classes: Vec<Option<Class>> = vec![None; CLASSES + 1];
        for place in self.chart.points() {
            let payload = place.payload.unwrap_or(0.0);
            let k = (CLASSES as f64 * place.reach / last) as usize;
            let class = classes[k].get_or_insert(Class {
                best: *place,
                least: payload,
                lasting: 0.0,
            });
            class.least = class.least.min(payload);
            class.lasting = class.lasting.max(place.lasting.unwrap_or(0.0));
            if payload > class.best.payload.unwrap_or(0.0) {
                class.best = *place;
            }
        }
        classes.into_iter().flatten().collect()
    }
}

/// The points in one interval of reach.
#[derive(Clone, Copy)]
struct Class {
    /// Where the payload is greatest.
    best: LoadPoint,
    /// Payload that holds at every height, kg.
    least: f64,
    /// Greatest payload that may be held continuously, kg.
    lasting: f64,
}
