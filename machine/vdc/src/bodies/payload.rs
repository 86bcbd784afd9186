//! Whether the hook is empty, found while the machine rests after the start.
//!
//! Not in the paper, whose controller knows its payload. A hook without a load has a twentieth of
//! the inertia at the wrist: gains for the payload, sampled and late, make it swing, and gains for
//! the hook let the payload sway. A wrist that begins to swing shows its inertia by torque and
//! acceleration; where it is that of the wrist alone the nominal payload goes, and with it the
//! gains that follow from its inertia. A wrist at rest shows nothing, and the payload stays. Weight
//! is no measure: hanging, a payload has no moment.

use serde::{Deserialize, Serialize};

/// Time constants of the band that counts, s: the slower one takes weight and drift away, the other
/// one noise. What lies above acts too, damped alike in torque and acceleration.
const BAND: [f64; 2] = [0.15, 0.03];
/// Time over which the size of the motion is remembered, s.
const MEMORY: f64 = 0.1;
/// Moment of the payload by its acceleration that is more than noise, over the largest by its
/// weight.
const LEAST_MOMENT: f64 = 0.2;
/// Share of the nominal payload below which the hook is taken for empty; with more the gains for
/// the payload leave the wrist a phase margin, even three steps late.
const EMPTY: f64 = 0.33;
/// Share that stands for nothing: it does not matter beside the wrist's own inertia.
const NOTHING: f64 = 0.02;

/// Inertias about the second wrist joint, kg·m², and the largest moment of the payload's weight,
/// N·m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WristInertia {
    /// Of the wrist's own bodies.
    pub(crate) own: f64,
    /// Of the nominal payload.
    pub(crate) payload: f64,
    /// `g √(m I)` of the nominal payload.
    pub(crate) weight: f64,
}

/// Recursive least squares for the payload's share of the nominal one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PayloadShare {
    /// What is found.
    share: f64,
    begun: bool,
    /// Torque, N·m, and rate, rad/s, behind the faster lag, and these and the acceleration behind
    /// the slower one.
    torque: f64,
    rate: f64,
    slow: [f64; 2],
    /// Remembered square of the moment that the nominal payload's acceleration takes, N²·m²·s.
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
    /// The share that counts, 1 or next to nothing, after `h` s in which the joint turned at `rate`, rad/s, under `torque`, N·m.
    /// ```text
    /// τ_b − I_0 a_b = share·φ,   φ = I a_b,   a = (ω − ω_f)/T
    /// share' = φ (τ_b − I_0 a_b − share·φ)/(ρ + ∫ φ² dt)
    /// ```
    /// Torque and acceleration pass the same band (index b), so no rate is differentiated. A swing
    /// that is too fast for the readings' delay takes the correlation down, and the share with it.
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
