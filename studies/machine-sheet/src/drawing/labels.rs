//! Labels of points and lengths in a sheet's side view, placed so that none covers another.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::frame::Chart;
use charts::DrawResult;

/// Half the width of the square that a point covers, pixels.
const POINT: i32 = 6;

/// The areas that are covered already; a label goes to the nearest free area next to its point.
pub(super) struct Labels {
    /// Left, top, right, bottom of each covered area, pixels.
    taken: Vec<[i32; 4]>,
    /// The same of the plotting area, in which labels stay.
    within: [i32; 4],
}

impl Labels {
    /// No labels yet; points at `places` are not covered.
    pub(super) fn new<B: DrawingBackend>(
        chart: &Chart<'_, B>,
        places: impl Iterator<Item = [f64; 2]>,
    ) -> Self {
        let area = chart.plotting_area();
        let (across, down) = area.get_pixel_range();
        let around = |[x, y]: [f64; 2]| {
            let (x, y) = area.map_coordinate(&(x, y));
            [x - POINT, y - POINT, x + POINT, y + POINT]
        };
        Self {
            taken: places.map(around).collect(),
            within: [across.start, down.start, across.end, down.end],
        }
    }

    pub(super) fn add<B: DrawingBackend>(
        &mut self,
        chart: &Chart<'_, B>,
        place: [f64; 2],
        text: &str,
        color: &RGBColor,
        size: i32,
    ) -> DrawResult<B> {
        let area = chart.plotting_area();
        let (x, y) = area.map_coordinate(&(place[0], place[1]));
        let letters = i32::try_from(text.chars().count()).unwrap_or(0);
        let (width, height) = (letters * size / 2 + 4, size);
        let boxed = |dx: i32, dy: i32| {
            let left = if dx < 0 { x + dx - width } else { x + dx };
            [left, y + dy - height / 2, left + width, y + dy + height / 2]
        };
        let near = (0..14).flat_map(|k| {
            let d = 8 + 7 * k;
            [
                (d, -d / 2),
                (d, d / 2),
                (-d, -d / 2),
                (-d, d / 2),
                (3, -d - 4),
                (3, d + 4),
            ]
        });
        let is_free = |b: &[i32; 4]| {
            let apart = |t: &[i32; 4]| b[2] < t[0] || t[2] < b[0] || b[3] < t[1] || t[3] < b[1];
            let [left, top, right, bottom] = self.within;
            let is_within = b[0] > left && b[1] > top && b[2] < right && b[3] < bottom;
            is_within && self.taken.iter().all(apart)
        };
        let found = near.map(|(dx, dy)| boxed(dx, dy)).find(is_free);
        let found = found.unwrap_or_else(|| boxed(8, 0));
        self.taken.push(found);
        let style = ("sans-serif", size).into_font().color(color);
        let style = style.pos(Pos::new(HPos::Left, VPos::Center));
        let (base_x, base_y) = area.get_base_pixel();
        let [x0, y0, x1, y1] = found;
        let at = (x0 - base_x, (y0 + y1) / 2 - base_y);
        let plain = area.strip_coord_spec();
        let behind = [(x0 - base_x, y0 - base_y), (x1 - base_x, y1 - base_y)];
        plain.draw(&Rectangle::new(behind, WHITE.mix(0.75).filled()))?;
        plain.draw(&Text::new(text.to_owned(), at, style))
    }
}
