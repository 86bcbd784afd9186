//! The explicit Runge–Kutta method of Dormand and Prince (1980), for `Method::Adaptive`: order 5,
//! with an error estimate and dense output of order 4.

use super::algorithm::{Algorithm, Step, add, vectors};
use super::system::System;

/// Coefficients as in Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, table
/// II.5.2 and (II.6.12).
#[rustfmt::skip]
const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const C: [f64; 6] = [1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
/// Coefficients of the error estimate: order 5 minus order 4.
#[rustfmt::skip]
const E: [f64; 7] = [
    71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0,
];
/// Coefficients of the dense output.
#[rustfmt::skip]
const D: [f64; 7] = [
    -12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0, -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0,
];

/// Rates of the seven stages; the last one is at the end of the step.
pub(crate) struct DormandPrince(pub(crate) [Vec<f64>; 7]);

impl DormandPrince {
    pub(crate) fn new(n: usize) -> Self {
        Self(vectors(n))
    }

    /// Estimate of the fastest rate of decay times the length `dt`, s, of the last step: from the
    /// last two stages, which are at the same time (Hairer, Wanner, *Solving Ordinary Differential
    /// Equations II*, section IV.2). The method is stable up to about 3.3.
    pub(crate) fn stiffness(&self, dt: f64) -> f64 {
        let [before, at_end] = [&self.0[5], &self.0[6]];
        let (mut rates, mut states) = (0.0, 0.0);
        for (i, (a, b)) in before.iter().zip(at_end).enumerate() {
            let rate = b - a;
            let rows = A[5].iter().enumerate();
            let terms = rows.map(|(j, a)| (a - A[4].get(j).unwrap_or(&0.0)) * self.0[j][i]);
            let state = dt * terms.sum::<f64>();
            (rates, states) = (rates + rate * rate, states + state * state);
        }
        match states > 0.0 {
            true => dt * (rates / states).sqrt(),
            false => 0.0,
        }
    }
}

impl Algorithm for DormandPrince {
    fn begin<S: System>(&mut self, system: &mut S, step: &Step) -> Result<&[f64], S::Error> {
        if step.s > 0.0 {
            self.0.swap(0, 6); // the last stage of the previous step
        } else {
            system.derivative(step.s, &step.x, &mut self.0[0])?;
        }
        Ok(&self.0[0])
    }

    fn step<S: System>(&mut self, system: &mut S, step: &mut Step) -> Result<bool, S::Error> {
        let (s, dt, end, error) = (step.s, step.dt, &mut step.end, &mut step.error);
        for (k, (row, c)) in A.iter().zip(C).enumerate() {
            end.copy_from_slice(&step.x);
            add(end, row.iter().map(|a| dt * a), &self.0);
            system.derivative(s + c * dt, end, &mut self.0[k + 1])?;
        }
        error.fill(0.0);
        add(error, E.map(|e| dt * e), &self.0);
        Ok(true)
    }

    fn dense_output<S: System>(&mut self, _: &mut S, step: &mut Step) -> Result<(), S::Error> {
        let ([a, b, c], dt) = (&mut step.dense, step.dt);
        c.fill(0.0);
        add(c, D.map(|d| -dt * d), &self.0);
        for (i, (x, end)) in step.x.iter().zip(&step.end).enumerate() {
            let change = end - x;
            a[i] = dt * self.0[0][i] - change;
            b[i] = change - dt * self.0[6][i] - a[i] - c[i];
        }
        Ok(())
    }
}
