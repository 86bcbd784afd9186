//! Pictures of the rig: efficiency of physics, hybrid and rig in quadrants I and IV, and responses over time.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use emla::Surrogate;
use plotters::prelude::*;
use rayon::prelude::*;
use rig::{Drive, Input};

use crate::plots::{Area, EfficiencyMaps, FONT, MAP_CELLS, Map, Picture, TITLE, save};
use crate::prediction::{Model, Motion};
use crate::profile::{LOAD_MAX, SPEED};
use crate::rig_run;
use crate::windows::Window;

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
        )?,
        save(
            &Responses {
                panels: responses(surrogate, work),
            },
            folder,
            "rig_responses",
        )?,
    ];
    Ok(files.concat())
}

/// Efficiency by physics and hybrid, and that of the rig, over loads up to [`LOAD_MAX`] (rows) and speeds up to [`SPEED`] both ways: quadrants
/// I and IV.
///
/// # Errors
/// A steady point that the rig cannot hold.
pub fn maps(models: &[Model; 3], cells: [usize; 2]) -> Result<[Map; 3]> {
    Ok([
        map("Efficiency: physics", cells, &|F, v| {
            Ok(predicted(&models[0], F, v))
        })?,
        map("Efficiency: hybrid, alpha = 0.9", cells, &|F, v| {
            Ok(predicted(&models[1], F, v))
        })?,
        map("Efficiency: rig", cells, &true_efficiency)?,
    ])
}

fn predicted(model: &Model, F: f64, x_dot: f64) -> f64 {
    let p = machine::Machine::reference().emla.lift;
    let reference = rig::Extras::AS_BUILT.temperature.reference;
    let motion = Motion {
        F,
        w_m: x_dot / emla::maps::travel_per_radian(&p),
        T: [reference; 2],
        ..Motion::default()
    };
    model.demand(&motion).efficiency
}

/// Mean over positions within one electrical period, which even out cogging and ripple.
fn true_efficiency(F: f64, x_dot: f64) -> Result<f64> {
    const PLACES: u32 = 8;
    let rig = rig_run::rig(Drive::Motion)?;
    let (p, T) = (rig.params(), rig.extras().temperature.reference);
    let period = emla::maps::travel_per_radian(p) * std::f64::consts::TAU / f64::from(p.p);
    let mut sum = 0.0;
    for k in 0..PLACES {
        let u = Input {
            v_dc: p.inverter.map_or(650.0, |inverter| inverter.v_dc),
            T_ambient: T,
            x: 0.35 + period * f64::from(k) / f64::from(PLACES),
            x_dot,
            F_hold: F,
            ..Input::default()
        };
        let s = rig.start(&u, [T; 2]).context("a steady point")?;
        sum += rig.output(&s, &u).efficiency;
    }
    Ok(sum / f64::from(PLACES))
}

/// Cells over load and speed in both directions.
fn map(
    title: &str,
    cells: [usize; 2],
    value: &(dyn Fn(f64, f64) -> Result<f64> + Sync),
) -> Result<Map> {
    let middle = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let row = |i: usize| {
        let F = LOAD_MAX * middle(i, cells[0]);
        (0..cells[1])
            .map(|j| value(F, SPEED[1] * (2.0 * middle(j, cells[1]) - 1.0)))
            .collect()
    };
    let rows: Result<_> = (0..cells[0]).into_par_iter().map(row).collect();
    Ok(Map {
        title: title.into(),
        cells: rows?,
    })
}

/// Force, kN, and rod speed, mm/s, over time, s: desired and rig above, network and rig below.
struct Responses {
    panels: [Panel; 4],
}

/// Two courses over time.
pub struct Panel {
    /// What it shows.
    pub title: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    /// Names, and points of time, s, and value.
    pub lines: [(&'static str, Vec<(f64, f64)>); 2],
}

/// Force and rod speed along a held-out profile: the rig against what was asked for, the network against the rig.
#[must_use]
pub fn responses(surrogate: &Surrogate, work: &[Window]) -> [Panel; 4] {
    let of =
        |value: &dyn Fn(&Window) -> f64| work.iter().map(|w| (w.t, value(w))).collect::<Vec<_>>();
    let network = |w: &Window| surrogate.evaluate(w.row.tau_e, w.row.w_m);
    let [force, speed] = [of(&|w| 1e-3 * w.row.f_ext), of(&|w| 1e3 * w.row.x_dot)];
    [
        Panel {
            title: "Force: desired and rig",
            unit: "kN",
            lines: [
                ("rig", force.clone()),
                ("desired", of(&|w| 1e-3 * w.desired[1])),
            ],
        },
        Panel {
            title: "Rod speed: desired and rig",
            unit: "mm/s",
            lines: [
                ("rig", speed.clone()),
                ("desired", of(&|w| 1e3 * w.desired[0])),
            ],
        },
        Panel {
            title: "Force: network and rig",
            unit: "kN",
            lines: [("rig", force), ("network", of(&|w| 1e-3 * network(w).F))],
        },
        Panel {
            title: "Rod speed: network and rig",
            unit: "mm/s",
            lines: [("rig", speed), ("network", of(&|w| 1e3 * network(w).x_dot))],
        },
    ]
}

impl Picture for Responses {
    fn draw<B: DrawingBackend>(
        &self,
        area: &Area<'_, B>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
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
                // Windows in which the rod stands or turns are left out: a line does not bridge them.
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
