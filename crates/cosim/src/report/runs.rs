//! The runs of a report, thinned out for the page.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use serde::Serialize;

use super::Request;
use super::samples::Samples;
use super::scene::Scene;
use crate::bond::Residual;
use crate::description::Kind;
use crate::noise::Noise;
use crate::recording::Recording;
use crate::run::Experiment;
use crate::signals::matches_pattern;
use crate::system::System;

/// Sampling of the page, s: tip error, other signals, frames of the animation.
const TIP_EVERY: f64 = 0.004;
const SIGNALS_EVERY: f64 = 0.02;
const FRAMES_EVERY: f64 = 0.04;

/// Outputs that the page shows, as far as the system has them.
const SHOWN: [&str; 32] = [
    "controller.tip_error*",
    "controller.desired.position[*]",
    "controller.f_required[*]",
    "controller.x_dot_required[*]",
    "controller.i_q_required[*]",
    "controller.v_d[*]",
    "controller.v_q[*]",
    "controller.tau_wrist[*]",
    "controller.mass_hat.*",
    "controller.lyapunov.*",
    "hdrm.zeta[*]",
    "hdrm.zeta_dot[*]",
    "hdrm.x[*]",
    "hdrm.x_dot[*]",
    "hdrm.tip.position[*]",
    "hdrm.energy.*",
    "emla_*.F",
    "emla_*.i_d",
    "emla_*.i_q",
    "emla_*.w_m",
    "emla_*.tau_e",
    "emla_*.P_in",
    "emla_*.P_out",
    "emla_*.loss.copper",
    "emla_*.loss.core",
    "emla_*.loss.inverter",
    "emla_*.loss.mechanical",
    "emla_*.efficiency",
    "emla_*.efficiency_valid",
    "emla_*.energy.in",
    "emla_*.energy.out",
    "emla_*.energy.loss",
];

/// Conditions of one run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Case {
    pub trajectory: &'static str,
    pub mode: &'static str,
    /// Factor on all inertias of the manipulator.
    pub scale: f64,
}

/// A signal, from the start of the run on.
#[derive(Serialize)]
pub struct Signal {
    /// Unit in the model description.
    pub unit: String,
    /// Time between samples, s.
    pub every: f64,
    pub samples: Samples,
}

/// One run.
#[derive(Serialize)]
pub struct Run {
    #[serde(flatten)]
    pub case: Case,
    /// Start time, s.
    pub start: f64,
    /// Simulated time, s.
    pub simulated: f64,
    /// From here on the reference moves, s.
    pub motion_start: f64,
    /// Tip error over the motion at every communication point, m.
    pub rmse: f64,
    pub max: f64,
    pub real_time_factor: f64,
    bonds: Vec<Bond>,
    warnings: Vec<String>,
    pub signals: BTreeMap<String, Signal>,
    /// Time between frames, s.
    frames_every: f64,
    /// Poses of the bodies in world axes, frame after frame, body after body: x, y, z, m; quaternion x, y, z, w.
    frames: Samples,
    /// Largest distance of the drawn tip from the tip position that the FMU gives, m.
    drawing_error: f64,
}

/// Power residual of a bond.
#[derive(Serialize)]
struct Bond {
    bond: String,
    peak: f64,
    energy: f64,
    turnover: f64,
}

impl From<&Residual> for Bond {
    fn from(r: &Residual) -> Self {
        Self {
            bond: r.bond.clone(),
            peak: r.peak,
            energy: r.energy,
            turnover: r.turnover,
        }
    }
}

impl Run {
    pub fn of(request: &Request<'_>, case: Case, scene: &Scene) -> Result<Self> {
        Self::recorded(request, case, scene).with_context(|| {
            let Case {
                trajectory,
                mode,
                scale,
            } = case;
            format!("{trajectory}, {mode}, inertia x {scale}")
        })
    }

    fn recorded(request: &Request<'_>, case: Case, scene: &Scene) -> Result<Self> {
        let system = request.system;
        let mut settings = request.settings.to_vec();
        for (variable, value) in [
            ("trajectory", case.trajectory),
            ("mode", case.mode),
            ("inertia_scale", &case.scale.to_string()),
        ] {
            settings.push(system.setting(variable, value)?);
        }
        // The controller's accompanying functions need the plant's true inertias; its law does not see them.
        if let Ok(truth) = system.setting("lyapunov.inertia_scale", &case.scale.to_string()) {
            settings.push(truth);
        }
        let experiment = Experiment {
            grid: request.grid,
            stop: request.stop,
            settings,
            noise: Noise::default(),
        };
        let shown = shown(system);
        let names: Vec<String> = shown.iter().map(|(name, _)| name.clone()).collect();
        let recording = Recording::of(system, &experiment, &names, |_, _| ())?;
        let outcome = &recording.outcome;
        let tip = outcome
            .tip
            .context("the system has no output `tip_error_norm`")?;
        let step = request.grid.step;
        let mut signals = BTreeMap::new();
        for (name, unit) in shown {
            let is_tip = name.starts_with("controller.tip_error");
            let stride = stride(if is_tip { TIP_EVERY } else { SIGNALS_EVERY }, step);
            let values = recording.column(&name)?.iter().step_by(stride).copied();
            let signal = Signal {
                unit,
                every: step * stride as f64,
                samples: Samples::new(values),
            };
            signals.insert(name, signal);
        }
        let stride = stride(FRAMES_EVERY, step);
        let (frames, drawing_error) = scene.frames(&recording, stride)?;
        Ok(Self {
            case,
            start: request.grid.start,
            simulated: outcome.simulated,
            motion_start: tip.motion_start,
            rmse: tip.motion.rms(),
            max: tip.motion.max,
            real_time_factor: outcome.real_time_factor(),
            bonds: outcome.residuals.iter().map(Bond::from).collect(),
            warnings: outcome
                .warnings
                .iter()
                .map(|w| format!("{}: {}", w.instance, w.text))
                .collect(),
            signals,
            frames_every: step * stride as f64,
            frames,
            drawing_error,
        })
    }

    /// One line for people.
    pub fn line(&self) -> String {
        let Case {
            trajectory,
            mode,
            scale,
        } = self.case;
        format!(
            "{trajectory:<11}{mode:<9} inertia x {scale:<4} tip RMSE {:8.4} mm, max {:8.4} mm",
            1e3 * self.rmse,
            1e3 * self.max
        )
    }

    /// Times, s, and values of a signal, where the system has it.
    pub fn series(&self, name: &str) -> Option<Vec<(f64, f64)>> {
        let signal = self.signals.get(name)?;
        let at = |k: usize| self.start + k as f64 * signal.every;
        let points = signal.samples.values().enumerate().map(|(k, v)| (at(k), v));
        Some(points.collect())
    }
}

/// Communication steps between samples.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number"
)]
fn stride(every: f64, step: f64) -> usize {
    ((every / step).round() as usize).max(1)
}

/// Names and units of the outputs that the page shows.
fn shown(system: &System) -> Vec<(String, String)> {
    let mut shown = Vec::new();
    for (component, fmu) in system.structure.components.iter().zip(&system.fmus) {
        for v in &fmu.description.variables {
            let name = format!("{}.{}", component.name, v.name);
            let wanted = SHOWN.iter().any(|pattern| matches_pattern(pattern, &name));
            if wanted && v.causality == "output" && v.kind != Kind::String {
                shown.push((name, v.unit.clone().unwrap_or_else(|| "1".into())));
            }
        }
    }
    shown
}
