//! On the sheet of `machine draw`: the view of the workspace, coloured by the greatest payload.

use plotters::prelude::*;

use super::frame::{Chart, frame, series_names};
use super::sheet::Sheet;
use charts::{Area, DrawResult};

impl Sheet {
    pub(super) fn loads<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        let places = || self.chart.points().map(|p| [p.reach, p.height]);
        let all = places().chain([[0.0, 0.0]]).collect::<Vec<_>>();
        let caption = format!(
            "Workspace and greatest payload at rest; dynamic factor {}",
            self.chart.factor
        );
        let mut chart = frame(area, &caption, all.into_iter())?;
        for rows in self.chart.rows.windows(2) {
            for (low, high) in rows[0].windows(2).zip(rows[1].windows(2)) {
                // A cell at the edge of the workspace may lack a corner: then it is a triangle.
                let corners = [low[0], low[1], high[1], high[0]].into_iter().flatten();
                let corners: Vec<_> = corners.collect();
                if corners.len() < 3 {
                    continue;
                }
                let least = corners
                    .iter()
                    .map(|p| p.payload)
                    .collect::<Option<Vec<_>>>();
                let least = least.map(|values| values.into_iter().fold(f64::INFINITY, f64::min));
                let color = self.bands.color(least);
                let mut outline: Vec<_> = corners.iter().map(|p| (p.reach, p.height)).collect();
                chart.draw_series([Polygon::new(outline.clone(), color.filled())])?;
                outline.push(outline[0]);
                chart.draw_series([PathElement::new(outline, color.stroke_width(1))])?;
            }
        }
        for [from, to] in [["T1", "O"], ["O", "B"], ["B", "A4"], ["A4", "T4"]] {
            let line = [self.view.at(from), self.view.at(to)].map(|[x, y]| (x, y));
            chart.draw_series(LineSeries::new(line, BLACK.mix(0.5).stroke_width(2)))?;
        }
        for (k, low) in self.bands.lows.iter().enumerate() {
            let text = match self.bands.lows.get(k + 1) {
                Some(high) => format!("{low:.0} to {high:.0} kg"),
                None => format!("{low:.0} kg and more"),
            };
            legend_entry(&mut chart, &text, self.bands.color(Some(*low)))?;
        }
        if self.chart.points().any(|p| p.payload.is_none()) {
            legend_entry(&mut chart, "cannot hold itself", self.bands.color(None))?;
        }
        series_names(&mut chart, SeriesLabelPosition::UpperRight)
    }
}

fn legend_entry<B: DrawingBackend>(
    chart: &mut Chart<'_, B>,
    text: &str,
    color: RGBColor,
) -> DrawResult<B> {
    chart
        .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())?
        .label(text)
        .legend(move |(x, y)| Rectangle::new([(x, y - 6), (x + 18, y + 6)], color.filled()));
    Ok(())
}
