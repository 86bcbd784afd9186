//! Torque over speed under both envelopes.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use anyhow::Result;

use charts::{Curve, Figure, Panel, wheel};
use experiments::analyses::sizing::{Axis, Sizing};

/// The motion's points and both envelopes over motor speed in 1000 rev/min.
fn panel(axis: &Axis) -> Panel {
    let ratings = &axis.ratings;
    let shown = 60.0 / TAU / 1000.0;
    let fastest = (ratings.motor_speed_rpm / 1000.0 / shown).max(axis.speed.peak);
    // Once around: to the fastest speed with positive torque, back with negative.
    let around = |of: &dyn Fn(f64) -> f64| {
        let there = (-100..=100).map(|k| (k, 1.0));
        let back = (-100..=100).rev().map(|k| (k, -1.0));
        let first = std::iter::once((-100, 1.0));
        let points = there.chain(back).chain(first);
        let point = |(k, sign): (i32, f64)| {
            let w = f64::from(k) * fastest / 100.0;
            (shown * w, sign * of(w))
        };
        points.map(point).collect::<Vec<_>>()
    };
    let peak = |w| axis.motor.peak(w);
    let lasting = |w| axis.motor.continuous(w, ratings);
    let points = axis.points.iter().map(|(w, tau)| (shown * w, *tau));
    Panel {
        x_label: "motor speed, 1000 rev/min".into(),
        y_label: format!("motor torque of {}, N.m", axis.actuator),
        floor: None,
        curves: vec![
            Curve::new("peak", wheel(0, 3), around(&peak)),
            Curve::new("continuous", wheel(1, 3), around(&lasting)),
            Curve::new("motion", wheel(2, 3), points.collect()),
        ],
    }
}

/// Torque over speed of each axis as PNG and SVG in `folder`; the files' names.
pub fn draw(sizing: &Sizing, case: &str, folder: &Path) -> Result<[PathBuf; 2]> {
    let panels = sizing.axes.iter().map(panel);
    let figure = Figure {
        name: format!("sizing_{}", case.replace(' ', "_")),
        title: format!("Torque and speed, {case} trajectory"),
        panels: panels.collect(),
    };
    figure.save(folder)
}
