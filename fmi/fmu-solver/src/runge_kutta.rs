//! The classical Runge–Kutta method of order 4, for `Method::Fixed`, without an error estimate.

use super::algorithm::{Algorithm, add, vectors};
use super::dense_output::DenseOutput;
use super::system::System;

/// The rates of the four stages.
pub(crate) struct RungeKutta([Vec<f64>; 4]);

impl RungeKutta {
    pub(crate) fn new(n: usize) -> Self {
        Self(vectors(n))
    }
}

impl Algorithm for RungeKutta {
    fn begin<S: System>(
        &mut self,
        system: &mut S,
        (_t, s, _dt): (f64, f64, f64),
        x: &[f64],
        _nominal: &[f64],
    ) -> Result<&[f64], S::Error> {
        system.derivative(s, x, &mut self.0[0])?;
        Ok(&self.0[0])
    }

    fn step<S: System>(
        &mut self,
        system: &mut S,
        (s, dt): (f64, f64),
        x: &[f64],
        end: &mut [f64],
        _error: &mut [f64],
    ) -> Result<bool, S::Error> {
        for (k, share) in [0.5, 0.5, 1.0].into_iter().enumerate() {
            end.copy_from_slice(x);
            add(end, [share * dt], &self.0[k..]);
            system.derivative(s + share * dt, end, &mut self.0[k + 1])?;
        }
        end.copy_from_slice(x);
        add(end, [dt / 6.0, dt / 3.0, dt / 3.0, dt / 6.0], &self.0);
        Ok(true)
    }

    /// The cubic Hermite interpolation, of order 3.
    fn dense_output<S: System>(
        &mut self,
        system: &mut S,
        (s, dt): (f64, f64),
        [x, end]: [&[f64]; 2],
        DenseOutput([a, b, _]): &mut DenseOutput,
    ) -> Result<(), S::Error> {
        let [start_rate, end_rate, ..] = &mut self.0;
        system.derivative(s + dt, end, end_rate)?;
        for i in 0..x.len() {
            let change = end[i] - x[i];
            a[i] = dt * start_rate[i] - change;
            b[i] = change - dt * end_rate[i] - a[i];
        }
        Ok(())
    }
}
