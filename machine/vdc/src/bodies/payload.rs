//! Detects an empty hook while the machine rests after the start ("weighing"), for `Bodies::weigh`.
//! Not in the paper, whose controller knows its payload.
//!
//! Without payload the inertia at the wrist is a twentieth: gains for the payload, sampled and
//! delayed, then make the wrist oscillate, and gains for the empty hook let a payload sway. If the
//! wrist begins to oscillate, torque and acceleration show its inertia; if that is the wrist's own,
//! the nominal payload is removed, and with it the gains based on its inertia. At rest the payload
//! is kept. Weight is no measure: a hanging payload has no moment.

use serde::{Deserialize, Serialize};

/// Time constants of the band-pass, s: the slow one removes weight and drift, the fast one noise.
/// Higher frequencies are damped equally in torque and acceleration.
const BAND: [f64; 2] = [0.15, 0.03];
/// Forgetting time of the least squares, s.
const MEMORY: f64 = 0.1;
/// Smallest inertial moment of the payload above noise, over the largest of its weight.
const LEAST_MOMENT: f64 = 0.2;
/// Share of the nominal payload below which the hook counts as empty; above it the gains for the
/// payload have a phase margin, even with a delay of three steps.
const EMPTY: f64 = 0.33;
/// Share of an empty hook: negligible compared with the wrist's own inertia.
const NOTHING: f64 = 0.02;

/// Inertias about the second wrist joint, kg·m², and largest moment of the payload, N·m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WristInertia {
    /// Inertia of the wrist's own bodies.
    pub(crate) own: f64,
    /// Inertia of the nominal payload.
    pub(crate) payload: f64,
    /// `g √(m I)` of the nominal payload.
    pub(crate) weight: f64,
}

/// Recursive least squares for the share of the nominal payload.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PayloadShare {
    /// The estimate.
    share: f64,
    begun: bool,
    /// Torque, N·m, and rate, rad/s, after the fast lag; `slow` after the slow one.
    torque: f64,
    rate: f64,
    slow: [f64; 2],
    /// Exponentially forgotten ∫ φ² dt, N²·m²·s.
    square: f64,
}

impl Default for PayloadShare {
    fn default() -> Self {
        Self {
            share: 1.0,
            begun: false,
            torque: 0.0,
            rate: 0.0,
            slow: [0.0; 2],
            square: 0.0,
        }
    }
}

impl PayloadShare {
    /// Advances by `h` s with `rate`, rad/s, and `torque`, N·m, of the joint, and returns the share
    /// to use: 1, or that of an empty hook.
    /// ```text
    /// τ_b − I_0 a_b = share·φ,   φ = I a_b,   a = (ω − ω_f)/T
    /// share' = φ (τ_b − I_0 a_b − share·φ)/(ρ + ∫ φ² dt)
    /// ```
    /// Torque and acceleration pass the same band-pass (index b), so no rate is differentiated. An
    /// oscillation too fast for the readings' delay lowers the correlation, and the share with it.
    pub(crate) fn advance(
        &mut self,
        torque: f64,
        rate: f64,
        inertia: &WristInertia,
        h: f64,
    ) -> f64 {
        let [slow, fast] = BAND;
        if !self.begun {
            (self.begun, self.torque, self.rate) = (true, torque, rate);
            self.slow = [torque, 0.0];
        }
        let acceleration = (rate - self.rate) / fast;
        let [torque_b, a_b] = [self.torque - self.slow[0], acceleration - self.slow[1]];
        let expected = inertia.payload * a_b;
        let least = LEAST_MOMENT * inertia.weight;
        self.square = libm::exp(-h / MEMORY) * self.square + h * expected * expected;
        let error = torque_b - inertia.own * a_b - self.share * expected;
        let weight = MEMORY * least * least + self.square;
        if weight > 0.0 {
            self.share = (self.share + h * expected * error / weight).clamp(NOTHING, 1.0);
        }
        let reached = |time: f64| -libm::expm1(-h / time);
        self.slow[0] += reached(slow) * (self.torque - self.slow[0]);
        self.slow[1] += reached(slow) * (acceleration - self.slow[1]);
        self.torque += reached(fast) * (torque - self.torque);
        self.rate += reached(fast) * (rate - self.rate);
        if self.share < EMPTY { NOTHING } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint under gains for the payload that is believed, integrated here with readings three
    /// steps old and with a weight that the controller does not know. A hook without a payload
    /// begins to swing, is taken for empty, and is calm then; what does not swing is not.
    #[test]
    fn a_hook_that_swings_is_found_empty() {
        let inertia = WristInertia {
            own: 6.0,
            payload: 100.0,
            weight: 1700.0,
        };
        for (share, expected) in [(0.003, NOTHING), (0.4, 1.0), (1.0, 1.0), (1.4, 1.0)] {
            let moved = inertia.own + share * inertia.payload;
            let mut found = PayloadShare::default();
            let (h, mut last) = (1e-3, 1.0);
            let (mut angle, mut rate) = (0.0, 0.01);
            let (mut late, mut end) = ([[0.0; 2]; 3], 0.0_f64);
            for k in 0..1000 {
                let I = inertia.own + last * inertia.payload;
                let [seen, turned] = late[2];
                let torque = (-I * (45.0 * seen + 450.0 * turned)).clamp(-2500.0, 2500.0);
                last = found.advance(torque, seen, &inertia, h);
                late = [[rate, angle], late[0], late[1]];
                rate += h * (torque + 30.0) / moved;
                angle += h * rate;
                if k > 900 {
                    end = end.max(rate.abs());
                }
            }
            assert_eq!(last, expected, "{share}");
            assert!(end < 0.05, "{share}: {end} rad/s at the end");
        }
    }
}
