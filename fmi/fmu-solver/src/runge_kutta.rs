//! The classical Runge–Kutta method of order 4, for `Method::Fixed`, without an error estimate.

use super::algorithm::{Algorithm, Step, add, vectors};
use super::system::System;

/// The rates of the four stages.
pub(crate) struct RungeKutta([Vec<f64>; 4]);

impl RungeKutta {
    pub(crate) fn new(n: usize) -> Self {
        Self(vectors(n))
    }
}

impl Algorithm for RungeKutta {
    fn begin<S: System>(&mut self, system: &mut S, step: &Step) -> Result<&[f64], S::Error> {
        system.derivative(step.s, &step.x, &mut self.0[0])?;
        Ok(&self.0[0])
    }

    fn step<S: System>(&mut self, system: &mut S, step: &mut Step) -> Result<bool, S::Error> {
        let Step { s, dt, x, end, .. } = step;
        let (s, dt) = (*s, *dt);
        for (k, share) in [0.5, 0.5, 1.0].into_iter().enumerate() {
            end.copy_from_slice(x);
            add(end, [share * dt], &self.0[k..]);
            system.derivative(s + share * dt, end, &mut self.0[k + 1])?;
        }
        end.copy_from_slice(x);
        add(end, [dt / 6.0, dt / 3.0, dt / 3.0, dt / 6.0], &self.0);
        Ok(true)
    }

    /// The parabola through both ends with the rate at the start.
    fn rough_output<S: System>(&mut self, _: &mut S, step: &mut Step) -> Result<(), S::Error> {
        let [a, b, _] = &mut step.dense;
        b.fill(0.0);
        for (i, x) in step.x.iter().enumerate() {
            a[i] = step.dt * self.0[0][i] - (step.end[i] - x);
        }
        Ok(())
    }

    /// The cubic Hermite interpolation, of order 3.
    fn dense_output<S: System>(&mut self, system: &mut S, step: &mut Step) -> Result<(), S::Error> {
        let [start_rate, end_rate, ..] = &mut self.0;
        let ([a, b, _], dt, end) = (&mut step.dense, step.dt, &step.end);
        system.derivative(step.s + dt, end, end_rate)?;
        for (i, x) in step.x.iter().enumerate() {
            let change = end[i] - x;
            a[i] = dt * start_rate[i] - change;
            b[i] = change - dt * end_rate[i] - a[i];
        }
        Ok(())
    }
}
