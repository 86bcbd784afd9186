//! Maps of the efficiency over load and rod speed in all four quadrants, of physics, hybrid and
//! rig, for the report and the pictures of `surrogate compare`.

use anyhow::{Context as _, Result};
use rayon::prelude::*;
use rig::{Drive, Input};

use crate::measurement::profile::{LOAD_MAX, SPEED};
use crate::measurement::rig_run;
use crate::measurement::windows::{Motion, data_sheet};
use crate::prediction::model::Model;

/// Efficiency over loads from −[`LOAD_MAX`] to [`LOAD_MAX`] and rod speeds from −[`SPEED`] to
/// [`SPEED`].
pub struct EfficiencyMap {
    /// Title of the map.
    pub title: &'static str,
    /// `cells[load][speed]`, 0 … 1.
    pub cells: Vec<Vec<f64>>,
}

/// The maps of physics, hybrid and rig; `models` are in the order of
/// [`crate::prediction::model::MODELS`]. Fails at a steady point that the rig cannot hold.
pub fn maps(models: &[Model; 3], cells: [usize; 2]) -> Result<[EfficiencyMap; 3]> {
    let by = |model| move |F, v| Ok(predicted_efficiency(model, F, v));
    Ok([
        map("Efficiency: physics", cells, &by(&models[0]))?,
        map("Efficiency: hybrid, alpha = 0.9", cells, &by(&models[1]))?,
        map("Efficiency: rig", cells, &true_efficiency)?,
    ])
}

fn predicted_efficiency(model: &Model, F: f64, x_dot: f64) -> f64 {
    let p = model.params();
    let motion = Motion {
        F,
        w_m: x_dot / emla::maps::travel_per_radian(p),
        T: [data_sheet(p).reference; 2],
        ..Motion::default()
    };
    model.demand(&motion).efficiency
}

/// The rig's efficiency, a mean over positions within one electrical period, which evens out
/// cogging and ripple.
fn true_efficiency(F: f64, x_dot: f64) -> Result<f64> {
    const PLACES: u32 = 8;
    let rig = rig_run::rig(Drive::Motion);
    let (p, T) = (rig.params(), rig.extras().temperature.reference);
    let period = emla::maps::travel_per_radian(p) * std::f64::consts::TAU / f64::from(p.p);
    let mut sum = 0.0;
    for k in 0..PLACES {
        let u = Input {
            v_dc: Some(p.link_voltage()),
            T_ambient: T,
            x: 0.35 + period * f64::from(k) / f64::from(PLACES),
            x_dot,
            F_hold: F,
            ..Input::default()
        };
        let s = rig.start(&u, [T; 2]).context("a steady point")?;
        let y = rig.output(&s, &u);
        sum += rig::efficiency(F * x_dot, y.P_loss, y.tau_e * y.w_m);
    }
    Ok(sum / f64::from(PLACES))
}

fn map(
    title: &'static str,
    cells: [usize; 2],
    value: &(dyn Fn(f64, f64) -> Result<f64> + Sync),
) -> Result<EfficiencyMap> {
    let middle = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let row = |i: usize| {
        let F = LOAD_MAX * (2.0 * middle(i, cells[0]) - 1.0);
        (0..cells[1])
            .map(|j| value(F, SPEED[1] * (2.0 * middle(j, cells[1]) - 1.0)))
            .collect()
    };
    let cells = (0..cells[0]).into_par_iter().map(row);
    let cells = cells.collect::<Result<_>>()?;
    Ok(EfficiencyMap { title, cells })
}
