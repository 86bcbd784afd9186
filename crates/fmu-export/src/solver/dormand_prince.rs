//! The explicit method of Dormand and Prince (1980): order 5, with an error estimate of order 4 and
//! states between of order 4.

use super::course::Course;
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
/// Of the error: order 5 less order 4.
#[rustfmt::skip]
const E: [f64; 7] = [
    71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0,
];
/// Of the states between.
#[rustfmt::skip]
const D: [f64; 7] = [
    -12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0, -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0,
];

/// Rates of the seven stages; the last is that at the end of the step.
pub(crate) struct DormandPrince {
    rates: [Vec<f64>; 7],
    /// Whether the first rate is that of the point where the next step begins.
    has_start: bool,
}

impl DormandPrince {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            rates: std::array::from_fn(|_| vec![0.0; n]),
            has_start: false,
        }
    }

    /// Before the first step from a new point.
    pub(crate) fn forget(&mut self) {
        self.has_start = false;
    }

    /// The rates at the start of a step.
    pub(crate) fn begin<S: System>(
        &mut self,
        system: &mut S,
        s: f64,
        x: &[f64],
    ) -> Result<&[f64], S::Error> {
        if !self.has_start {
            system.derivative(s, x, &mut self.rates[0])?;
            self.has_start = true;
        }
        Ok(&self.rates[0])
    }

    /// A trial of one step of `dt` from `s`, after [`begin`](Self::begin): states at its end, and the
    /// estimate of their errors.
    pub(crate) fn step<S: System>(
        &mut self,
        system: &mut S,
        (s, dt): (f64, f64),
        x: &[f64],
        end: &mut [f64],
        error: &mut [f64],
    ) -> Result<(), S::Error> {
        for (k, (row, c)) in A.iter().zip(C).enumerate() {
            let (known, next) = self.rates.split_at_mut(k + 1);
            sum(end, dt, row, known);
            end.iter_mut().zip(x).for_each(|(end, x)| *end += x);
            system.derivative(s + c * dt, end, &mut next[0])?;
        }
        sum(error, dt, &E, &self.rates);
        Ok(())
    }

    /// The states in the step that was tried last.
    pub(crate) fn course(&self, dt: f64, x: &[f64], end: &[f64], course: &mut Course) {
        sum(&mut course.c, dt, &D, &self.rates);
        for i in 0..x.len() {
            let change = end[i] - x[i];
            course.a[i] = dt * self.rates[0][i] - change;
            course.b[i] = change - dt * self.rates[6][i] - course.a[i] + course.c[i];
            course.c[i] = -course.c[i];
        }
    }

    /// The step that was tried last is taken.
    pub(crate) fn accept(&mut self) {
        self.rates.swap(0, 6);
    }
}

/// `to` = `factor` · Σ `weights` · `vectors`.
fn sum(to: &mut [f64], factor: f64, weights: &[f64], vectors: &[Vec<f64>]) {
    to.fill(0.0);
    for (weight, vector) in weights
        .iter()
        .zip(vectors)
        .filter(|(weight, _)| **weight != 0.0)
    {
        for (to, value) in to.iter_mut().zip(vector) {
            *to += factor * weight * value;
        }
    }
}
