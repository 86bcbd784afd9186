//! The figure of a machine's margins to its limits along a path, over time; drawn by `path check`
//! and in the report.

use std::path::{Path, PathBuf};

use anyhow::Result;
use charts::{Curve, Figure, Panel, colors};
use experiments::machines::path_margins::PathMargins;
use motion_check::Quantity;

/// A curve is drawn with at most this number of points.
const POINTS: usize = 2000;

/// Panels of the figure: title and the quantities in it.
const PANELS: [(&str, std::ops::Range<usize>); 6] = [
    ("joints", 0..6),
    ("strokes", 6..9),
    ("rod speeds", 9..12),
    ("forces", 12..15),
    ("wrist torques", 15..18),
    ("motors", 18..27),
];

/// Draws the margins as PNG and SVG into `folder`; returns the files' names.
pub fn draw(margins: &PathMargins, folder: &Path) -> Result<[PathBuf; 2]> {
    let stride = margins.times.len().div_ceil(POINTS).max(1);
    let panel = |(title, quantities): (&str, std::ops::Range<usize>)| {
        let names: Vec<_> = quantities
            .clone()
            .map(|k| Quantity::all()[k].to_string())
            .collect();
        let names: Vec<_> = names.iter().map(String::as_str).collect();
        let colored = quantities.zip(&names).zip(colors(&names));
        let curves = colored.map(|((k, name), color)| {
            let points = margins.times.iter().zip(&margins.parts).step_by(stride);
            let points = points.map(|(t, parts)| (*t, 100.0 * parts[k])).collect();
            Curve::new(name, color, points)
        });
        Panel::over_time(&format!("{title}: left of the range, %"), curves.collect())
    };
    let stem = Path::new(&margins.name).file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy().replace(':', "_");
    let figure = Figure {
        name: format!("margins_{stem}"),
        title: format!("Margins along the path {}", margins.name),
        panels: PANELS.into_iter().map(panel).collect(),
    };
    figure.save(folder)
}
