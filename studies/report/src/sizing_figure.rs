//! The figure that `sizing --figures` draws: motor torque over speed of a motion, under the motor's
//! peak and continuous envelopes; `commands::drawings` calls it.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use anyhow::Result;

use charts::{Curve, Figure, Panel, wheel};
use experiments::analyses::sizing::{Axis, Sizing};

/// The motion's points and both envelopes over motor speed in 1000 rev/min.
fn panel(axis: &Axis) -> Panel {
    let ratings = &axis.ratings;
    let krpm = 60.0 / TAU / 1000.0; // per rad/s
    let fastest = (ratings.motor_speed_rpm / 1000.0 / krpm).max(axis.speed.peak);
    // Up to the fastest speed with positive torque, back with negative, and closed.
    let outline = |torque: &dyn Fn(f64) -> f64| {
        let upper = (-100..=100).map(|k| (k, 1.0));
        let lower = (-100..=100).rev().map(|k| (k, -1.0));
        let point = |(k, sign): (i32, f64)| {
            let w = f64::from(k) * fastest / 100.0;
            (krpm * w, sign * torque(w))
        };
        let closed = upper.chain(lower).chain([(-100, 1.0)]);
        closed.map(point).collect::<Vec<_>>()
    };
    let peak = |w| axis.motor.peak(w);
    let continuous = |w| axis.motor.continuous(w, ratings);
    let points = axis.points.iter().map(|(w, tau)| (krpm * w, *tau));
    Panel {
        x_label: "motor speed, 1000 rev/min".into(),
        y_label: format!("motor torque of {}, N.m", axis.actuator),
        floor: None,
        curves: vec![
            Curve::new("peak", wheel(0, 3), outline(&peak)),
            Curve::new("continuous", wheel(1, 3), outline(&continuous)),
            Curve::new("motion", wheel(2, 3), points.collect()),
        ],
    }
}

/// Draws torque over speed of each axis as PNG and SVG into `folder`; returns the files' names.
pub fn draw(sizing: &Sizing, case: &str, folder: &Path) -> Result<[PathBuf; 2]> {
    let panels = sizing.axes.iter().map(panel);
    let figure = Figure {
        name: format!("sizing_{}", case.replace(' ', "_")),
        title: format!("Torque and speed, {case} trajectory"),
        panels: panels.collect(),
    };
    figure.save(folder)
}
