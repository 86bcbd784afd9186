//! The classical Runge–Kutta method of order 4, in equal internal steps.

use super::course::Course;
use super::system::System;

/// Room for the rates of one step.
pub(crate) struct RungeKutta {
    rates: [Vec<f64>; 4],
    stage: Vec<f64>,
}

/// `to` = `x` + `factor` · `rate`.
fn plus(to: &mut [f64], x: &[f64], factor: f64, rate: &[f64]) {
    for ((to, x), rate) in to.iter_mut().zip(x).zip(rate) {
        *to = x + factor * rate;
    }
}

impl RungeKutta {
    pub(crate) fn new(n: usize) -> Self {
        let zero = || vec![0.0; n];
        Self {
            rates: [zero(), zero(), zero(), zero()],
            stage: zero(),
        }
    }

    /// One step of `dt` from `s`: from the states `x` to `end`.
    pub(crate) fn step<S: System>(
        &mut self,
        system: &mut S,
        s: f64,
        dt: f64,
        x: &[f64],
        end: &mut [f64],
    ) -> Result<(), S::Error> {
        let half = s + 0.5 * dt;
        let [a, b, c, d] = &mut self.rates;
        let stage = &mut self.stage;
        system.derivative(s, x, a)?;
        plus(stage, x, 0.5 * dt, a);
        system.derivative(half, stage, b)?;
        plus(stage, x, 0.5 * dt, b);
        system.derivative(half, stage, c)?;
        plus(stage, x, dt, c);
        system.derivative(s + dt, stage, d)?;
        for (i, end) in end.iter_mut().enumerate() {
            *end = x[i] + dt / 6.0 * a[i] + dt / 3.0 * b[i] + dt / 3.0 * c[i] + dt / 6.0 * d[i];
        }
        Ok(())
    }

    /// The states in the last step, by the cubic with the rates of change of both ends: order 3.
    pub(crate) fn course<S: System>(
        &mut self,
        system: &mut S,
        s: f64,
        dt: f64,
        x: &[f64],
        end: &[f64],
        course: &mut Course,
    ) -> Result<(), S::Error> {
        let [start_rate, end_rate, ..] = &mut self.rates;
        system.derivative(s + dt, end, end_rate)?;
        for i in 0..x.len() {
            let change = end[i] - x[i];
            course.a[i] = dt * start_rate[i] - change;
            course.b[i] = change - dt * end_rate[i] - course.a[i];
        }
        Ok(())
    }
}
