//! On the sheet of `machine draw`: the side view, with the machine's points and dimensions.

use plotters::prelude::*;

use super::frame::frame;
use super::labels::Labels;
use super::sheet::{HEAD, SMALL, Sheet};
use charts::{Area, DrawResult};

/// Ends and names of the lengths that the side view states.
const DIMENSIONS: [(&str, &str, &str); 15] = [
    ("T1", "O", "T1–O"),
    ("O", "P", "L1_2"),
    ("O", "F", "L2_2"),
    ("F", "P", "x_2 + x0_2"),
    ("O", "B", "O–B"),
    ("B", "A", "B–A"),
    ("B", "E", "B–E"),
    ("B", "C", "B–C"),
    ("A", "D", "d4"),
    ("C", "D", "d5"),
    ("E", "D", "x_3 + x0_3"),
    ("B", "A4", "B–A4"),
    ("A4", "C4", "A4–C4"),
    ("C4", "D4", "C4–D4"),
    ("D4", "T4", "D4–T4"),
];

impl Sheet {
    pub(super) fn side<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        let places = self.view.points.iter().map(|point| point.place);
        let mut chart = frame(area, "Side view at the start pose", places.clone())?;
        let at = |name: &str| self.view.at(name);
        let (boom, link, rod) = (
            RGBColor(200, 140, 20),
            RGBColor(120, 120, 130),
            RGBColor(60, 110, 170),
        );
        let lines: [(&[&str], RGBColor, u32); 6] = [
            (&["T1", "O"], RGBColor(90, 90, 90), 9),
            (&["O", "B"], boom, 7),
            (&["O", "P"], boom, 4),
            (&["B", "A4"], boom, 7),
            (&["A", "D", "C"], link, 3),
            (&["A4", "C4", "D4", "T4"], RGBColor(90, 90, 90), 4),
        ];
        for (names, color, width) in lines {
            let points = names.iter().map(|name| at(name)).map(|[x, y]| (x, y));
            chart.draw_series(LineSeries::new(points, color.stroke_width(width)))?;
        }
        for (pivot, on) in [("A", "B"), ("E", "B"), ("C", "B"), ("F", "O")] {
            let style = link.stroke_width(1);
            chart.draw_series(DashedLineSeries::new(line(at(pivot), at(on)), 4, 4, style))?;
        }
        for (foot, pin, inner) in [("F", "P", self.view.rods[0]), ("E", "D", self.view.rods[1])] {
            let (foot, pin) = (at(foot), at(pin));
            let barrel = line(foot, middle(inner, pin));
            chart.draw_series(LineSeries::new(line(inner, pin), rod.stroke_width(3)))?;
            chart.draw_series(LineSeries::new(barrel, rod.stroke_width(8)))?;
        }
        let mut labels = Labels::new(&chart, places);
        let (point_color, length_color) = (RGBColor(150, 0, 0), RGBColor(20, 60, 130));
        for point in &self.view.points {
            let (x, y) = (point.place[0], point.place[1]);
            chart.draw_series([Circle::new((x, y), 4, WHITE.filled())])?;
            chart.draw_series([Circle::new((x, y), 4, BLACK.stroke_width(1))])?;
        }
        for point in &self.view.points {
            labels.add(&chart, point.place, point.name, &point_color, HEAD.1)?;
        }
        for (from, to, name) in DIMENSIONS {
            let (from, to) = (at(from), at(to));
            let length = (from[0] - to[0]).hypot(from[1] - to[1]);
            if length > 1e-3 {
                let text = format!("{name} {:.0}", 1e3 * length);
                labels.add(&chart, middle(from, to), &text, &length_color, SMALL.1)?;
            }
        }
        Ok(())
    }
}

fn line(a: [f64; 2], b: [f64; 2]) -> [(f64, f64); 2] {
    [(a[0], a[1]), (b[0], b[1])]
}

fn middle(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}
