//! Dry friction of the wrist joints, estimated while they move, for `controller`: laws without an
//! integral of their own at the joints feed it forward.
//!
//! Besides the torque of its law a joint gets `b̂ + τ̂ σ`, with the sign of the required rate
//! smoothed, `σ = tanh(ζ̇_r/ε)`. A torque that lacks steadily, as for an unknown load, says nothing
//! of friction; one that changes sign with the motion does. So what teaches τ̂ is the sign without
//! its mean, `φ = σ − σ̄` with `σ̄' = (σ − σ̄)/T`, and the offset b̂ takes the rest:
//! ```text
//! τ̂' = ω_f² M s φ      b̂' = ω_b² M s − τ̂' σ̄      ω_b = ω_f/2,  T = 3/ω_f
//! ```
//! with the inertia M about the joint and the error s of its rate. The second term of b̂' keeps the
//! mean torque `b̂ + τ̂ σ̄` while τ̂ learns. Friction of another size in each direction is the same on
//! both sides and an offset. Stability: `docs/machine/wrist-friction.md`.

use hdrm::DOF;
use serde::{Deserialize, Serialize};

/// ε, the rate from which on friction has its full size, rad/s.
const EPSILON: f64 = 0.01;
/// Largest friction over the largest torque of a joint.
const LARGEST: f64 = 0.1;

/// What is known of the three joints.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct WristFriction([Known; 3]);

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Known {
    /// τ̂, N·m.
    friction: f64,
    /// b̂, N·m.
    offset: f64,
    /// σ̄.
    mean_sign: f64,
}

/// A joint that learns.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TurningJoint {
    /// Required rate ζ̇_r, rad/s, and what of it is lacking, s.
    pub(crate) required: f64,
    pub(crate) lacking: f64,
    /// Inertia M about it, kg·m².
    pub(crate) inertia: f64,
    /// Its largest torque, N·m.
    pub(crate) tau_max: f64,
}

/// σ at the required `rate`, rad/s.
fn sign(rate: f64) -> f64 {
    libm::tanh(rate / EPSILON)
}

impl WristFriction {
    /// Torques, N·m, at the required rates of all joints, rad/s; of the friction a `share` counts.
    pub(crate) fn torques(&self, required: &[f64; DOF], share: f64) -> [f64; 3] {
        let torque = |j: usize| {
            let known = &self.0[j];
            known.offset + share * known.friction * sign(required[3 + j])
        };
        std::array::from_fn(torque)
    }

    /// Learns for `h` s at the rate `omega`, 1/s, from the `joints` as they are held; of a reference
    /// that does not move, the offsets only.
    pub(crate) fn learn(&mut self, omega: f64, moves: bool, joints: &[TurningJoint; 3], h: f64) {
        for (known, joint) in self.0.iter_mut().zip(joints) {
            let (sign, mean) = (sign(joint.required), known.mean_sign);
            let push = h * omega * omega * joint.inertia * joint.lacking;
            if moves {
                let before = known.friction;
                let largest = LARGEST * joint.tau_max;
                known.friction = (before + push * (sign - mean)).clamp(0.0, largest);
                known.offset -= (known.friction - before) * mean;
            }
            known.offset += 0.25 * push;
            known.mean_sign -= (sign - mean) * libm::expm1(-h * omega / 3.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 1e-3;
    const INERTIA: f64 = 60.0;
    const KAPPA: f64 = 20.0;

    /// A joint of 2500 N·m.
    fn joint(required: f64, lacking: f64) -> TurningJoint {
        TurningJoint {
            required,
            lacking,
            inertia: INERTIA,
            tau_max: 2500.0,
        }
    }

    /// Rate of a joint that swings, rad/s, and its angle, rad.
    fn swing(t: f64) -> [f64; 2] {
        [0.3 * libm::sin(1.5 * t), -0.2 * libm::cos(1.5 * t)]
    }

    /// A swinging joint with the feedback `κ M s`, for 30 s at the rate `omega`: torques that its law does
    /// not know are `unknown(ζ̇, angle)`, N·m. Returns what is known of it then, and the error's rms over
    /// the last 10 s, rad/s.
    fn after_a_while(omega: f64, unknown: impl Fn(f64, f64) -> f64) -> (Known, f64) {
        let (mut friction, mut s, mut sum) = (WristFriction::default(), 0.0, 0.0);
        for k in 0..30_000 {
            let [rate, angle] = swing(H * f64::from(k));
            let joint = joint(rate, s);
            let [own, ..] = friction.torques(&[0.0, 0.0, 0.0, rate, 0.0, 0.0], 1.0);
            let still = TurningJoint::default();
            friction.learn(omega, true, &[joint, still, still], H);
            s += H * ((unknown(rate - s, angle) - own) / INERTIA - KAPPA * s);
            if k >= 20_000 {
                sum += s * s / 10_000.0;
            }
        }
        (friction.0[0], f64::sqrt(sum))
    }

    /// Friction of 80 N·m beside a load of −100 N·m: both are found within a tenth, and the error falls
    /// to less than a fifth of what it is with the load known.
    #[test]
    fn friction_is_told_from_a_load() {
        let friction = |rate: f64| 80.0 * libm::tanh(rate / 1e-3);
        let (known, error) = after_a_while(6.0, |rate, _| friction(rate) - 100.0);
        assert!((known.friction - 80.0).abs() < 8.0, "{known:?}");
        assert!((known.offset + 100.0).abs() < 8.0, "{known:?}");
        let (_, without) = after_a_while(0.0, |rate, _| friction(rate));
        assert!(error < without / 5.0, "{error} {without}");
    }

    /// Of a load whose moment changes with the angle by ±40 N·m nothing becomes friction but a tenth.
    #[test]
    fn a_load_is_no_friction() {
        let (known, _) = after_a_while(6.0, |_, angle| 200.0 * angle - 100.0);
        assert!(known.friction < 4.0, "{known:?}");
    }

    /// While the reference stands, a joint that sticks teaches the offset, and friction stays.
    #[test]
    fn what_sticks_at_rest_is_a_load() {
        let mut found = WristFriction::default();
        let sticks = joint(0.02, 0.02);
        for _ in 0..1000 {
            found.learn(6.0, false, &[sticks; 3], H);
        }
        let expected = 0.25 * 36.0 * INERTIA * 0.02;
        for known in found.0 {
            assert_eq!(known.friction, 0.0);
            assert!((known.offset - expected).abs() < 1e-9, "{known:?}");
        }
    }

    /// No sensor's error makes more of it than a tenth of the joint's largest torque.
    #[test]
    fn it_is_bounded() {
        let mut found = WristFriction::default();
        let runs_away = TurningJoint {
            tau_max: 800.0,
            ..joint(1.0, 100.0)
        };
        for _ in 0..1000 {
            found.learn(6.0, true, &[runs_away; 3], H);
        }
        assert_eq!(found.0[2].friction, 80.0);
    }
}
