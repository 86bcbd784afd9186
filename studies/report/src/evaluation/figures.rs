//! The report's figures as PNG and SVG, for papers; `report --figures` writes them.

use std::path::{Path, PathBuf};

use anyhow::Result;
use plotters::style::RGBColor;

use super::request::UNCERTAIN;
use super::runs::Run;
use super::samples::Samples;
use super::testbed::Axis;
use super::{Report, stability};
use charts::{Curve, Figure, Panel, Path3};
use experiments::analyses::inertia::{MODES, paper, scale_of};
use experiments::analyses::testbed;
use experiments::runs::grid::TRAJECTORIES;

/// Colours of the controllers, as in the page: adaptive, modular, PD.
const CONTROLLERS: [RGBColor; 3] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(204, 51, 85),
];
const DESIRED: RGBColor = RGBColor(60, 60, 60);
/// Colours of slew, lift and tilt.
const ACTUATORS: [(&str, RGBColor); 3] = [
    ("slew", RGBColor(123, 97, 191)),
    ("lift", RGBColor(0, 150, 110)),
    ("tilt", RGBColor(213, 94, 0)),
];
/// Names of the controllers, in the order of [`MODES`].
const NAMES: [&str; 3] = ["adaptive", "modular", "PD"];
const AXES: [&str; 3] = ["x", "y", "z"];

/// Writes all figures into `folder`; returns the files' names.
pub fn write(report: &Report, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut figures = vec![robustness(report)];
    let mut files = Vec::new();
    for trajectory in TRAJECTORIES {
        let nominal = MODES.map(|mode| report.run(trajectory, mode, 1.0));
        files.extend(tip_path(trajectory, &nominal).save(folder)?);
        figures.push(tip_error(trajectory, &nominal));
        figures.extend(nominal[0].map(actuators));
        figures.extend(report.run(trajectory, MODES[0], UNCERTAIN).map(adaptation));
        figures.push(stability(report, trajectory));
    }
    let axes = report.testbed.iter().flat_map(|t| &t.axes);
    figures.extend(axes.map(testbed));
    for figure in figures {
        files.extend(figure.save(folder)?);
    }
    Ok(files)
}

impl Report {
    fn run(&self, trajectory: &str, mode: &str, scale: f64) -> Option<&Run> {
        let same = |run: &&Run| {
            let case = run.case;
            case.trajectory == trajectory && case.mode == mode && case.scale == scale
        };
        self.runs.iter().find(same)
    }
}

/// The curve of a run's signal times `factor`, if the system has the signal.
fn curve(run: &Run, signal: &str, label: &str, color: RGBColor, factor: f64) -> Option<Curve> {
    let points = run.series(signal)?.into_iter();
    let points = points.map(|(t, v)| (t, factor * v));
    Some(Curve::new(label, color, points.collect()))
}

/// The tip's path as in the paper's figures: desired, and with the three controllers.
fn tip_path(trajectory: &str, runs: &[Option<&Run>; 3]) -> Path3 {
    let path = |run: &Run, name: &str| -> Option<Vec<[f64; 3]>> {
        let [x, y, z] = [1, 2, 3].map(|i| run.series(&format!("{name}[{i}]")));
        let points = x?.into_iter().zip(y?).zip(z?);
        Some(points.map(|((x, y), z)| [x.1, y.1, z.1]).collect())
    };
    let mut curves = Vec::new();
    for ((run, mode), color) in runs.iter().zip(NAMES).zip(CONTROLLERS).rev() {
        let points = run.and_then(|run| path(run, "hdrm.tip.position"));
        curves.extend(points.map(|points| (mode.to_string(), color, points)));
    }
    let desired = runs
        .iter()
        .flatten()
        .find_map(|run| path(run, "controller.desired.position"));
    curves.extend(desired.map(|points| ("desired".into(), DESIRED, points)));
    Path3 {
        name: format!("tip_path_{trajectory}"),
        title: format!("Tip path, {trajectory} trajectory"),
        curves,
    }
}

/// The tip error as in the paper's figures: components and norm.
fn tip_error(trajectory: &str, runs: &[Option<&Run>; 3]) -> Figure {
    let curves = |name: &str| {
        let mut curves = Vec::new();
        for ((run, mode), color) in runs.iter().zip(NAMES).zip(CONTROLLERS).rev() {
            curves.extend(run.and_then(|run| curve(run, name, mode, color, 1e3)));
        }
        curves
    };
    let mut panels: Vec<Panel> = (0..3)
        .map(|i| {
            let curves = curves(&format!("controller.tip_error[{}]", i + 1));
            Panel::over_time(&format!("error in {}, mm", AXES[i]), curves)
        })
        .collect();
    let norm = curves("controller.tip_error_norm");
    panels.push(Panel::over_time("norm of the error, mm", norm).logarithmic(1e-4));
    Figure {
        name: format!("tip_error_{trajectory}"),
        title: format!("Tip error, {trajectory} trajectory, nominal inertias"),
        panels,
    }
}

/// The paper's table as a figure: tip RMSE over the error of all inertias.
fn robustness(report: &Report) -> Figure {
    let panel = |trajectory: &str| {
        let cells_of_mode = |mode: &'static str| {
            let cells = report.cells.iter();
            let cells = cells.filter(move |c| c.trajectory == trajectory && c.law == mode);
            cells.map(|cell| (100.0 * (scale_of(cell) - 1.0), cell))
        };
        let mut curves = Vec::new();
        for (k, name) in NAMES.iter().enumerate() {
            let rmse = cells_of_mode(MODES[k]).filter_map(|(percent, cell)| {
                Some((percent, 1e3 * cell.result.as_ref().ok()?.motion.rms()))
            });
            curves.push(Curve::new(name, CONTROLLERS[k], rmse.collect()));
        }
        if report.conditions["own_machine"].is_null() {
            let paper = cells_of_mode(MODES[0]).filter_map(|(percent, cell)| {
                Some((percent, 1e3 * paper(trajectory, scale_of(cell))?))
            });
            curves.push(Curve::new("paper, adaptive", DESIRED, paper.collect()));
        }
        Panel {
            x_label: "error of all inertias, %".into(),
            y_label: format!("{trajectory}: tip RMSE, mm"),
            floor: Some(1e-4),
            curves,
        }
    };
    Figure {
        name: "robustness".into(),
        title: "Tip RMSE with wrong inertias".into(),
        panels: TRAJECTORIES.map(panel).into(),
    }
}

/// Force, velocity, current and voltage of the three actuators.
fn actuators(run: &Run) -> Figure {
    let panel = |label: &str, signal: &dyn Fn(usize) -> String, factor: f64| {
        let mut curves = Vec::new();
        for (i, (name, color)) in ACTUATORS.into_iter().enumerate() {
            curves.extend(curve(run, &signal(i + 1), name, color, factor));
        }
        Panel::over_time(label, curves)
    };
    let trajectory = run.case.trajectory;
    Figure {
        name: format!("actuators_{trajectory}"),
        title: format!("Actuators, {trajectory} trajectory, adaptive controller"),
        panels: vec![
            panel("force, kN", &|i| format!("emla_{i}.F"), 1e-3),
            panel("rod velocity, mm/s", &|i| format!("hdrm.x_dot[{i}]"), 1e3),
            panel("current i_q, A", &|i| format!("emla_{i}.i_q"), 1.0),
            panel("voltage v_q, V", &|i| format!("controller.v_q[{i}]"), 1.0),
        ],
    }
}

/// The testbed as in the paper's figures: desired and measured position, velocity and force.
fn testbed(axis: &Axis) -> Figure {
    let panel = |label: &str, pair: &[Samples; 2], factor: f64| {
        let curve = |k: usize, name: &str, color| {
            Curve::new(name, color, axis.times.points(&pair[k], factor))
        };
        let curves = vec![
            curve(1, "measured", ACTUATORS[2].1),
            curve(0, "desired", DESIRED),
        ];
        Panel::over_time(label, curves)
    };
    let testbed::Axis {
        trajectory,
        axis: name,
        ..
    } = axis.numbers;
    Figure {
        name: format!("testbed_{name}_{trajectory}"),
        title: format!("Testbed (simulated), {name} actuator, {trajectory} trajectory"),
        panels: vec![
            panel("force, kN", &axis.curves["force"], 1e-3),
            panel("velocity, mm/s", &axis.curves["velocity"], 1e3),
            panel("position, mm", &axis.curves["position"], 1e3),
        ],
    }
}

/// Mass estimates and accompanying functions with wrong inertias.
fn adaptation(run: &Run) -> Figure {
    let panel = |y_label: &str, prefix: &str| {
        let names = run.signals.keys().filter(|name| name.starts_with(prefix));
        let names: Vec<_> = names.collect();
        let curves = names.iter().enumerate().filter_map(|(k, name)| {
            let color = charts::wheel(k, names.len());
            curve(run, name, name.strip_prefix(prefix)?, color, 1.0)
        });
        Panel::over_time(y_label, curves.collect())
    };
    let nu = panel("accompanying functions nu", "controller.lyapunov.nu_");
    let trajectory = run.case.trajectory;
    Figure {
        name: format!("adaptation_{trajectory}"),
        title: format!("Adaptation, {trajectory} trajectory, all inertias x {UNCERTAIN}"),
        panels: vec![
            panel("estimated masses, kg", "controller.mass_hat."),
            nu.logarithmic(1e-6),
        ],
    }
}

/// By how much the derivative of the accompanying functions exceeds its bound: both voltage laws,
/// both communication steps.
fn stability(report: &Report, trajectory: &str) -> Figure {
    let panel = |law: &str| {
        let runs = report.stability.runs.iter();
        let runs =
            runs.filter(|run| run.numbers.trajectory == trajectory && run.numbers.law == law);
        let curve = |(k, run): (usize, &stability::Run)| {
            let label = format!("{} ms", 1e3 * run.numbers.step);
            let points = run.times.points(&run.curves["excess_max"], 1.0);
            Curve::new(&label, CONTROLLERS[k % 3], points)
        };
        let curves = runs.enumerate().map(curve).collect();
        Panel::over_time(&format!("{law} law: largest excess in 20 ms, W"), curves)
    };
    Figure {
        name: format!("stability_{trajectory}"),
        title: format!(
            "Excess of the accompanying function's derivative over its bound, {trajectory} trajectory, all inertias x {UNCERTAIN}"
        ),
        panels: ["paper", "shipped"].map(panel).into(),
    }
}
