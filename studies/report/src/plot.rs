//! The picture that the command `plot` draws of a recorded run: the signals of a CSV file over
//! time, with one panel for each unit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use cosim::run::signals::matches_pattern;
use plotters::style::RGBColor;

use charts::{Curve, Figure, Panel, colors};
use surrogate::measurement::signal_file::SignalFile;

/// A curve is drawn with at most this number of points.
const POINTS: usize = 4000;

/// Draws the signals of `csv` that match one of `patterns`, or all if there are no patterns, as PNG
/// and SVG into `folder`; returns the files' names.
pub fn draw(csv: &Path, patterns: &[String], folder: &Path) -> Result<[PathBuf; 2]> {
    let file = SignalFile::read(csv)?;
    let is_chosen = |name: &str| patterns.iter().any(|p| matches_pattern(p, name));
    let mut panels: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (k, name) in file.names.iter().enumerate().skip(1) {
        if patterns.is_empty() || is_chosen(name) {
            panels.entry(&file.units[k]).or_default().push(k);
        }
    }
    ensure!(
        !panels.is_empty(),
        "`{}` has no signal that matches {}; it has {}",
        csv.display(),
        patterns.join(", "),
        file.names[1..].join(", ")
    );
    let stem = csv.file_stem().unwrap_or_default().to_string_lossy();
    let figure = Figure {
        name: stem.clone().into_owned(),
        title: stem.into_owned(),
        panels: panels
            .iter()
            .map(|(unit, columns)| panel(&file, unit, columns))
            .collect(),
    };
    figure.save(folder)
}

fn panel(file: &SignalFile, unit: &str, columns: &[usize]) -> Panel {
    let stride = file.times().len().div_ceil(POINTS).max(1);
    let names: Vec<_> = columns.iter().map(|k| file.names[*k].as_str()).collect();
    let curve = |(k, color): (&usize, RGBColor)| {
        let points = file.times().iter().zip(&file.columns[*k]);
        let points = points.step_by(stride).map(|(t, v)| (*t, *v)).collect();
        Curve::new(&file.names[*k], color, points)
    };
    let curves = columns.iter().zip(colors(&names)).map(curve);
    Panel::over_time(unit, curves.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "time,a.x,a.F,b.x\n0,1,2,3\n0.5,4,5,6\n";

    #[test]
    fn chosen_signals_are_drawn_beside_the_file() {
        let folder = std::env::temp_dir().join(format!("studies-plot-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let csv = folder.join("run.csv");
        std::fs::write(&csv, TEXT).unwrap();
        let files = draw(&csv, &["a.*".into()], &folder).unwrap();
        let svg = std::fs::read_to_string(&files[1]).unwrap();
        assert!(svg.contains("a.F") && !svg.contains("b.x"));
        assert!(std::fs::metadata(&files[0]).unwrap().len() > 1000);
        let error = draw(&csv, &["c.*".into()], &folder)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("c.*") && error.contains("a.x, a.F, b.x"),
            "{error}"
        );
        std::fs::remove_dir_all(folder).unwrap();
    }
}
