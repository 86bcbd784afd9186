//! The pictures as PNG and SVG. Of the command `plots`: predicted against true values, residuals,
//! learning curve. Of `compare`: efficiency maps, and responses over time.

use std::path::{Path, PathBuf};

use anyhow::Result;
use charts::{Area, Curve, DrawResult, Figure, Panel, Picture, extent};
use emla::{Split, Surrogate};
use plotters::prelude::*;

use surrogate::measurement::profile::{LOAD_MAX, SPEED};
use surrogate::measurement::windows::Window;
use surrogate::prediction::efficiency_map::{EfficiencyMap, maps};
use surrogate::prediction::model::Model;
use surrogate::prediction::responses::{self, responses};

const SIZE: (u32, u32) = (1200, 520);
const FONT: (&str, i32) = ("sans-serif", 16);
const TITLE: (&str, i32) = ("sans-serif", 18);
const BARS: usize = 61;
/// Number of cells of the efficiency map along load and along speed.
const MAP_CELLS: usize = 70;

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
            let (low, high) = extent(pairs.iter().flatten().copied());
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

/// Maps side by side, with the scale of colours.
struct EfficiencyMaps([EfficiencyMap; 3]);

impl Picture for EfficiencyMaps {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.fill(&WHITE)?;
        let (maps, legend) = area.split_horizontally(SIZE.0 - 90);
        let parts = maps.split_evenly((1, self.0.len()));
        let (load_max, speed_max) = (LOAD_MAX / 1e3, 1e3 * SPEED[1]);
        let [d_load, d_speed] = [load_max, speed_max].map(|max| 2.0 * max / MAP_CELLS as f64);
        for (map, part) in self.0.iter().zip(parts) {
            let mut chart = ChartBuilder::on(&part)
                .caption(map.title, TITLE)
                .margin(10)
                .x_label_area_size(44)
                .y_label_area_size(52)
                .build_cartesian_2d(-speed_max..speed_max, -load_max..load_max)?;
            for (i, row) in map.cells.iter().enumerate() {
                chart.draw_series(row.iter().enumerate().map(|(j, &eta)| {
                    let (x, y) = (j as f64 * d_speed - speed_max, i as f64 * d_load - load_max);
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

/// From blue through green to red; most of the colours lie between 0.5 and 0.9, the usual values.
fn heat(eta: f64) -> HSLColor {
    let share = eta.clamp(0.0, 1.0).powi(2);
    HSLColor(0.66 * (1.0 - share), 0.85, 0.5)
}

/// Force, kN, and rod speed, mm/s, over time, s: desired and rig above, network and rig below.
fn over_time(panels: [responses::Panel; 4]) -> Figure {
    let panel = |panel: responses::Panel| {
        let mut curves = Vec::new();
        for ((name, line), color) in panel.lines.into_iter().zip([BLUE, RED]) {
            // No line is drawn across windows that are left out because the rod stands or turns.
            for (k, piece) in line.chunk_by(|a, b| b.0 - a.0 < 0.03).enumerate() {
                let label = if k == 0 { name } else { "" };
                curves.push(Curve::new(label, color, piece.to_vec()));
            }
        }
        Panel::over_time(&format!("{}: {}", panel.title, panel.unit), curves)
    };
    Figure {
        name: "rig_responses".into(),
        title: "Responses of the rig and of the network".into(),
        panels: panels.into_iter().map(panel).collect(),
    }
}

/// Draws the pictures of `compare`; `work` is a held-out profile.
pub fn comparison(
    models: &[Model; 3],
    surrogate: &Surrogate,
    work: &[Window],
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let maps = EfficiencyMaps(maps(models, [MAP_CELLS; 2])?);
    let files = [
        charts::save(&maps, folder, "rig_efficiency_maps", SIZE)?,
        over_time(responses(surrogate, work)).save(folder)?,
    ];
    Ok(files.concat())
}

/// Draws the pictures of `plots`: a network on `inputs` (tau_e, w_m) and `targets` (F_ext, x_dot),
/// SI.
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
