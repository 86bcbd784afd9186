//! The measurements of a run as named numbers, for the Python package and for `hdrm-fmu evaluate`,
//! which evaluates runs of other importers.

use std::collections::BTreeMap;

use cosim::exchange::bond::Residual;
use serde_json::json;

use super::energy::Balance;
use super::run::TipError;
use super::tracking::{PositionError, Sag, Tracking};

/// Numbers by name, in SI units.
pub type Metrics = BTreeMap<String, f64>;

/// Names of all metrics of a system with these actuators (`all` is their sum), each with the option
/// that a run needs to have it: `tracking`, `energy`, or none (empty).
pub fn names(actuators: &[String]) -> BTreeMap<String, &'static str> {
    let mut always = tip_metrics(&TipError::new(0.0));
    let [mut tracking, mut energy] = [(); 2].map(|()| Metrics::new());
    add_residuals(&mut always, &[]);
    let all = Tracking {
        sag: Some(Sag::default()),
        ..Tracking::default()
    };
    add_tracking(&mut tracking, &all);
    for actuator in actuators {
        let balance = Balance {
            actuator: actuator.clone(),
            ..Balance::default()
        };
        add_energy(&mut energy, &balance);
    }
    let groups = [(always, ""), (tracking, "tracking"), (energy, "energy")];
    let named =
        |(metrics, option): (Metrics, _)| metrics.into_keys().map(move |name| (name, option));
    groups.into_iter().flat_map(named).collect()
}

/// Metrics of the tip error.
pub fn tip_metrics(tip: &TipError) -> Metrics {
    let named = [
        ("tip_rmse", tip.motion.rms()),
        ("tip_max", tip.motion.max),
        ("tip_rmse_whole", tip.whole.rms()),
        ("tip_max_whole", tip.whole.max),
        ("motion_start", tip.motion_start),
    ];
    named.map(|(name, value)| (name.to_string(), value)).into()
}

/// Add the power residuals of a run: largest peak, and the energy that the coupling created
/// (negative) or lost at all bonds.
pub fn add_residuals(metrics: &mut Metrics, residuals: &[Residual]) {
    let peak = residuals.iter().map(|r| r.peak).fold(0.0, f64::max);
    metrics.insert("residual_peak".into(), peak);
    let energy = residuals.iter().map(|r| r.energy).sum();
    metrics.insert("residual_energy".into(), energy);
}

/// Add the tracking errors.
pub fn add_tracking(metrics: &mut Metrics, tracking: &Tracking) {
    let mut position = |place: &str, error: &PositionError| {
        let named = [
            ("rmse", error.rmse),
            ("max", error.max),
            ("mean", error.mean),
            ("varying", error.varying),
        ];
        metrics.extend(named.map(|(name, value)| (format!("{place}_{name}"), value)));
    };
    position("known", &tracking.known);
    position("joints", &tracking.joints);
    position("plant", &tracking.plant);
    if let Some(sag) = &tracking.sag {
        position("rigid", &sag.rigid);
        metrics.insert("sag_rms".into(), sag.rms);
        metrics.insert("sag_max".into(), sag.max);
    }
    let [rms, max] = tracking.orientation;
    metrics.insert("orientation_rms".into(), rms);
    metrics.insert("orientation_max".into(), max);
    metrics.insert("speed_max".into(), tracking.speed);
    metrics.insert("rho".into(), tracking.rho());
}

/// Add the energies of an actuator.
pub fn add_energy(metrics: &mut Metrics, balance: &Balance) {
    let prefix = format!("energy_{}", balance.actuator);
    let efficiency = balance.efficiency().unwrap_or(f64::NAN);
    metrics.insert(format!("{prefix}_efficiency"), efficiency);
    for (name, value) in json!(balance).as_object().into_iter().flatten() {
        if let Some(value) = value.as_f64() {
            metrics.insert(format!("{prefix}_{name}"), value);
        }
    }
}
