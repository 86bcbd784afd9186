//! The runs of a report, thinned out for the page.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use cosim::bond::Residual;
use cosim::signals::matching;
use cosim::wiring::Port;
use serde::Serialize;

use super::request::Request;
use super::samples::Samples;
use super::scene::Scene;
use studies::measures::run::RecordedRun;
use studies::start_values::vary;

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
    /// Tip error over the whole run, with the time in which the machine settles, m.
    whole_rmse: f64,
    whole_max: f64,
    pub real_time_factor: f64,
    bonds: Vec<Bond>,
    warnings: Vec<String>,
    pub signals: BTreeMap<String, Signal>,
    /// Time between frames, s.
    frames_every: f64,
    /// Poses of the bodies in world axes, frame after frame, body after body: x, y, z, m;
    /// quaternion x, y, z, w.
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
        let experiment = vary(
            system,
            request.base,
            &[
                ("trajectory", &case.trajectory),
                ("mode", &case.mode),
                ("inertia_scale", &case.scale),
                // The controller's accompanying functions need the plant's true inertias; its law
                // does not see them.
                ("lyapunov.inertia_scale", &case.scale),
            ],
        )?;
        let shown = |pattern: &str| matching(system, &[pattern.into()]).unwrap_or_default();
        let ports: Vec<Port> = SHOWN.into_iter().flat_map(shown).collect();
        let recorded = RecordedRun::of(system, &experiment, &ports)?;
        let (recording, outcome) = (&recorded.recording, &recorded.outcome);
        let step = experiment.stepping.step;
        let mut signals = BTreeMap::new();
        for port in ports {
            let name = system.name(port);
            let is_tip = name.starts_with("controller.tip_error");
            let stride = stride(if is_tip { TIP_EVERY } else { SIGNALS_EVERY }, step);
            let values = recording.column(port)?.iter().step_by(stride).copied();
            let unit = system.variable(port).unit.as_deref();
            let signal = Signal {
                unit: unit.unwrap_or("1").into(),
                every: step * stride as f64,
                samples: Samples::new(values),
            };
            signals.insert(name, signal);
        }
        let stride = stride(FRAMES_EVERY, step);
        let (frames, drawing_error) = scene.frames(system, recording, stride)?;
        Ok(Self {
            case,
            start: experiment.stepping.start,
            simulated: outcome.run.simulated,
            motion_start: outcome.tip.motion_start,
            rmse: outcome.tip.motion.rms(),
            max: outcome.tip.motion.max,
            whole_rmse: outcome.tip.whole.rms(),
            whole_max: outcome.tip.whole.max,
            real_time_factor: outcome.run.real_time_factor(),
            bonds: outcome.run.residuals.iter().map(Bond::from).collect(),
            warnings: outcome
                .run
                .verdict
                .findings()
                .iter()
                .map(|finding| finding.text.clone())
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
pub fn stride(every: f64, step: f64) -> usize {
    ((every / step).round() as usize).max(1)
}
