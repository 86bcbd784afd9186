//! Pictures as PNG and SVG: efficiency maps, predicted against true, residuals, learning curve.

use std::path::{Path, PathBuf};

use anyhow::Result;
use charts::{Area, Curve, DrawResult, Figure, Panel, Picture};
use emla::{Split, Surrogate};
use plotters::prelude::*;

use surrogate::measurement::profile::LOAD_MAX;
use surrogate::prediction::efficiency_map::EfficiencyMap;

pub(crate) const SIZE: (u32, u32) = (1200, 520);
pub(crate) const FONT: (&str, i32) = ("sans-serif", 16);
pub(crate) const TITLE: (&str, i32) = ("sans-serif", 18);
/// Bars of a histogram.
const BARS: usize = 61;
/// Cells of the efficiency map along load and speed.
pub const MAP_CELLS: [usize; 2] = [70, 70];

/// Predicted and true values of force, kN, and rod speed, mm/s.
struct Agreement {
    pairs: [Vec<[f64; 2]>; 2],
}

const QUANTITIES: [&str; 2] = ["force, kN", "rod speed, mm/s"];

impl Picture for Agreement {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.fill(&WHITE)?;
        for (k, part) in area.split_evenly((1, 2)).iter().enumerate() {
            let pairs = &self.pairs[k];
            let (low, high) = extent(pairs.iter().flatten());
            let mut chart = ChartBuilder::on(part)
                .caption(format!("Test set: {}", QUANTITIES[k]), TITLE)
                .margin(12)
                .x_label_area_size(44)
                .y_label_area_size(64)
                .build_cartesian_2d(low..high, low..high)?;
            chart
                .configure_mesh()
                .label_style(FONT)
                .x_desc("data")
                .y_desc("network")
                .draw()?;
            chart.draw_series(LineSeries::new([(low, low), (high, high)], &RED))?;
            let dot = |p: &[f64; 2]| Circle::new((p[1], p[0]), 2, BLUE.mix(0.6).filled());
            chart.draw_series(pairs.iter().map(dot))?;
        }
        Ok(())
    }
}

/// Histograms of the errors of force, N, and rod speed, mm/s.
fn residuals(errors: &[Vec<f64>; 2]) -> Figure {
    let panel = |(name, errors): (&str, &Vec<f64>)| {
        let reach = errors.iter().fold(0.0_f64, |m, e| m.max(e.abs())) * 1.05;
        let width = 2.0 * reach / BARS as f64;
        let mut counts = vec![0_u32; BARS];
        for e in errors {
            counts[(((e + reach) / width) as usize).min(BARS - 1)] += 1;
        }
        let bar = |(k, n): (usize, &u32)| {
            let [left, right] = [k, k + 1].map(|k| -reach + k as f64 * width);
            [(left, f64::from(*n)), (right, f64::from(*n))]
        };
        let outline = counts.iter().enumerate().flat_map(bar).collect();
        Panel {
            x_label: name.into(),
            y_label: "points".into(),
            floor: None,
            curves: vec![Curve::new("", BLUE, outline)],
        }
    };
    let names = ["force error, N", "rod speed error, mm/s"];
    Figure {
        name: "residuals".into(),
        title: "Test set: network less data".into(),
        panels: names.into_iter().zip(errors).map(panel).collect(),
    }
}

/// Mean squared errors by epoch.
fn learning_curve(curve: &[Split<f64>]) -> Figure {
    let line = |name: &str, color, part: fn(&Split<f64>) -> f64| {
        let points = curve.iter().enumerate().map(|(k, s)| (k as f64, part(s)));
        Curve::new(name, color, points.collect())
    };
    let all = curve
        .iter()
        .flat_map(|s| [s.training, s.validation, s.test]);
    let panel = Panel {
        x_label: "epoch".into(),
        y_label: "mean squared error, scaled".into(),
        floor: Some(0.5 * all.fold(f64::INFINITY, f64::min)),
        curves: vec![
            line("training", BLUE, |s| s.training),
            line("validation", GREEN, |s| s.validation),
            line("test", RED, |s| s.test),
        ],
    };
    Figure {
        name: "learning_curve".into(),
        title: "Learning curve".into(),
        panels: vec![panel],
    }
}

/// Maps side by side, over rod speeds in m/s from the first to the second.
pub(crate) struct EfficiencyMaps<'a> {
    pub(crate) maps: &'a [EfficiencyMap],
    pub(crate) speeds: [f64; 2],
}

impl Picture for EfficiencyMaps<'_> {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.fill(&WHITE)?;
        let (maps, legend) = area.split_horizontally(SIZE.0 - 90);
        let parts = maps.split_evenly((1, self.maps.len()));
        for (map, part) in self.maps.iter().zip(parts) {
            let (load_max, [slow, fast]) = (LOAD_MAX / 1e3, self.speeds.map(|v| 1e3 * v));
            let mut chart = ChartBuilder::on(&part)
                .caption(&map.title, TITLE)
                .margin(10)
                .x_label_area_size(44)
                .y_label_area_size(52)
                .build_cartesian_2d(slow..fast, -load_max..load_max)?;
            let [loads, speeds] = MAP_CELLS.map(|cells| cells as f64);
            let (d_load, d_speed) = (2.0 * load_max / loads, (fast - slow) / speeds);
            for (i, row) in map.cells.iter().enumerate() {
                chart.draw_series(row.iter().enumerate().map(|(j, &eta)| {
                    let (x, y) = (slow + j as f64 * d_speed, i as f64 * d_load - load_max);
                    Rectangle::new([(x, y), (x + d_speed, y + d_load)], heat(eta).filled())
                }))?;
            }
            chart
                .configure_mesh()
                .disable_mesh()
                .label_style(FONT)
                .x_desc("rod speed, mm/s")
                .y_desc("load, kN")
                .draw()?;
        }
        let mut chart = ChartBuilder::on(&legend)
            .margin(10)
            .margin_top(34)
            .margin_bottom(54)
            .y_label_area_size(44)
            .build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
        chart.draw_series((0..100).map(|k| {
            let eta = f64::from(k) / 100.0;
            Rectangle::new([(0.0, eta), (1.0, eta + 0.01)], heat(eta).filled())
        }))?;
        chart
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .label_style(FONT)
            .draw()?;
        Ok(())
    }
}

/// Blue through green to red; most of the colours go to 0.5 … 0.9, where the map lives.
fn heat(eta: f64) -> HSLColor {
    let share = eta.clamp(0.0, 1.0).powi(2);
    HSLColor(0.66 * (1.0 - share), 0.85, 0.5)
}

fn extent<'a>(values: impl Iterator<Item = &'a f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
        (low.min(x), high.max(x))
    })
}

/// The quality pictures of a network on `inputs` (tau_e, w_m) and `targets` (F_ext, x_dot), SI.
pub fn quality(
    surrogate: &Surrogate,
    inputs: &[[f64; 2]],
    targets: &[[f64; 2]],
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let mut pairs = [Vec::new(), Vec::new()];
    for (&[tau, w], [F, x_dot]) in inputs.iter().zip(targets) {
        let y = surrogate.evaluate(tau, w);
        pairs[0].push([y.F / 1e3, F / 1e3]);
        pairs[1].push([y.x_dot * 1e3, x_dot * 1e3]);
    }
    let errors = [
        pairs[0].iter().map(|p| 1e3 * (p[0] - p[1])).collect(),
        pairs[1].iter().map(|p| p[0] - p[1]).collect(),
    ];
    let files = [
        charts::save(&Agreement { pairs }, folder, "predicted_against_true", SIZE)?,
        residuals(&errors).save(folder)?,
        learning_curve(&surrogate.training().curve).save(folder)?,
    ];
    Ok(files.concat())
}
