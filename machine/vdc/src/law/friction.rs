//! Estimates the dry friction of the wrist's drives by direction, for `controller`, and compensates
//! what reversals have shown.
//!
//! ```text
//! w₊ = max(u, 0), w₋ = max(−u, 0), u = tanh(ζ̇_r/ε)
//! d̂± ' = ω w± (κ (M s) + τ̂ − d̂±),   τ̂ = u max(0, (d̂₊ − d̂₋)/2 − dead zone)
//! ```
//! `κ (M s)` is what the law asks for to follow, so that with `τ̂` it is the torque that the model
//! lacks. What is the same in both directions is no friction: it is left to the other estimates.

use serde::{Deserialize, Serialize};

const JOINTS: usize = 3;
/// Rate ε, rad/s, below which a joint counts as turning in both directions.
const CREEP: f64 = 0.01;
/// Time, s, for which a joint must have turned in each direction.
const SEEN: f64 = 0.2;
/// Dead zone over the largest torque: models without friction are wrong by that much.
const DEAD_ZONE: f64 = 0.01;

// DEBUG
pub(crate) fn knob(i: usize, d: f64) -> f64 {
    static K: std::sync::OnceLock<Vec<f64>> = std::sync::OnceLock::new();
    *K.get_or_init(|| std::env::var("FR").unwrap_or_default().split(',').filter_map(|x| x.parse().ok()).collect()).get(i).unwrap_or(&d)
}

/// What is known of one drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Directions {
    /// Torque that the model lacks while the joint turns forwards and backwards, N·m.
    lacking: [f64; 2],
    /// Time for which it has turned so, s.
    seen: [f64; 2],
}

/// Friction of the three drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct WristFriction([Directions; JOINTS]);

/// The wrist joints in an evaluation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WristMotion {
    /// Required rates, rad/s.
    pub(crate) required: [f64; JOINTS],
    /// Feedback torques `κ (M s)`, N·m.
    pub(crate) feedback: [f64; JOINTS],
    /// Largest torques, N·m.
    pub(crate) largest: [f64; JOINTS],
}

impl WristFriction {
    /// Torques that compensate, N·m.
    pub(crate) fn torques(&self, wrist: &WristMotion) -> [f64; JOINTS] {
        std::array::from_fn(|j| {
            let Directions { lacking, .. } = self.0[j];
            let [offset, friction] = lacking;
            let zone = knob(4, 0.0) * wrist.largest[j];
            let f = friction.signum() * (friction.abs() - zone).max(0.0);
            let f = if knob(6, 0.0) > 0.0 { f.max(0.0) } else { f };
            offset + libm::tanh(wrist.required[j] / knob(0, CREEP)) * f
        })
    }

    /// Learns over `h` s at the rate `omega`, 1/s.
    pub(crate) fn learn(&mut self, wrist: &WristMotion, omega: f64, h: f64) {
        let torques = self.torques(wrist);
        for (j, joint) in self.0.iter_mut().enumerate() {
            if j == 1 && knob(5, 0.0) > 0.0 { eprintln!("{:.1} {:.1} {:.4} fb {:.1} tq {:.1}", joint.lacking[0], joint.lacking[1], wrist.required[j], wrist.feedback[j], torques[j]); }
            let u = libm::tanh(wrist.required[j] / knob(0, CREEP));
            let w = if knob(3, 0.0) > 0.0 { u.abs() } else { 1.0 };
            joint.lacking[0] += omega * knob(1, 1.0) * h * w * wrist.feedback[j];
            joint.lacking[1] += omega * knob(2, 1.0) * h * u * wrist.feedback[j];
        }
    }
}
