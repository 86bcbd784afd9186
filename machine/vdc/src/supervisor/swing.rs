//! How strongly a signal swings in the band of the boom's elastic modes, for the supervisor.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Band in which oscillations are detected, Hz: the boom's mode is between 3 and 9 Hz.
pub(super) const BAND: [f64; 2] = [2.0, 20.0];
/// Time constant of the mean squares, s: two periods of the slowest mode.
pub(super) const MEAN: f64 = 0.3;

/// Mean square of a band-passed signal.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Swing {
    /// States of two high-passes and one low-pass; None before the first value.
    passes: Option<[f64; 3]>,
    pub(super) square: f64,
}

impl Swing {
    /// Adds the value `x`, which is held for `h` s.
    pub(super) fn add(&mut self, x: f64, h: f64) {
        let share = |rate: f64| -libm::expm1(-h * rate);
        let [low, high] = BAND.map(|f| share(TAU * f));
        let [a, b, c] = self.passes.get_or_insert([x, 0.0, 0.0]);
        *a += low * (x - *a);
        let rest = x - *a;
        *b += low * (rest - *b);
        *c += high * (rest - *b - *c);
        self.square += share(1.0 / MEAN) * (*c * *c - self.square);
    }
}
