//! On the sheet of `machine draw`: the axes that the side view and the workspace share.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::sheet::{FONT, SMALL};
use charts::{Area, DrawResult};

pub(super) type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Axes of equal scale around all `places`.
pub(super) fn frame<'a, B: DrawingBackend>(
    area: &Area<'a, B>,
    caption: &str,
    places: impl Iterator<Item = [f64; 2]> + Clone,
) -> std::result::Result<Chart<'a, B>, DrawingAreaErrorKind<B::ErrorType>> {
    let range = |k: usize| {
        let values = places.clone().map(|p| p[k]);
        let low = values.clone().fold(0.0, f64::min);
        (low, values.fold(low, f64::max))
    };
    let (width, height) = area.dim_in_pixel();
    let [inner_x, inner_y] = [f64::from(width) - 90.0, f64::from(height) - 100.0];
    let [(x0, x1), (y0, y1)] = [range(0), range(1)];
    let metres = (1.1 * (x1 - x0) / inner_x).max(1.1 * (y1 - y0) / inner_y);
    let around = |(low, high): (f64, f64), pixels: f64| {
        let middle = 0.5 * (low + high);
        let half = 0.5 * metres * pixels;
        middle - half..middle + half
    };
    let mut chart = ChartBuilder::on(area)
        .caption(caption, FONT)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(60)
        .build_cartesian_2d(around((x0, x1), inner_x), around((y0, y1), inner_y))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.1))
        .x_desc("distance from the slew axis, m")
        .y_desc("height over the base, m")
        .label_style(SMALL)
        .axis_desc_style(FONT)
        .draw()?;
    Ok(chart)
}

pub(super) fn series_names<'a, B: DrawingBackend + 'a>(
    chart: &mut Chart<'a, B>,
    at: SeriesLabelPosition,
) -> DrawResult<B> {
    let mut labels = chart.configure_series_labels();
    labels.position(at).label_font(SMALL);
    labels.background_style(WHITE.mix(0.85));
    labels.border_style(BLACK.mix(0.3)).draw()
}
