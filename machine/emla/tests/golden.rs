//! What the golden files of the actuator's trajectories consist of.
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A recorded state, and the voltages that lead to it from the one before.
#[derive(Deserialize)]
pub struct Row<S> {
    /// v_d and v_q in V, each pair held over a communication step.
    pub volts: Vec<[f64; 2]>,
    pub state: S,
}

/// `offset + Σ amplitude·sin(2π·frequency·t + phase)`.
#[derive(Default, Deserialize)]
pub struct Wave {
    offset: f64,
    terms: Vec<[f64; 3]>,
}

impl Wave {
    /// The derivative of an order, 0 for the value.
    pub fn at(&self, t: f64, order: i32) -> f64 {
        let offset = if order == 0 { self.offset } else { 0.0 };
        let term = |&[amplitude, frequency, phase]: &[f64; 3]| {
            let w = TAU * frequency;
            amplitude * w.powi(order) * (w * t + phase + f64::from(order) * FRAC_PI_2).sin()
        };
        offset + self.terms.iter().map(term).sum::<f64>()
    }
}
