//! The states between two points of a solver, and where an event lies there.

use super::system::System;

/// The states over one internal step: `x(θ) = x₀ + θ (Δ + (1 − θ) (a + θ (b + θ c)))`, θ from 0 to 1.
#[derive(Default)]
pub(crate) struct Course {
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) c: Vec<f64>,
}

impl Course {
    pub(crate) fn new(n: usize) -> Self {
        let zero = || vec![0.0; n];
        Self {
            a: zero(),
            b: zero(),
            c: zero(),
        }
    }

    /// The states at `theta` between `start` and `end`.
    pub(crate) fn at(&self, theta: f64, start: &[f64], end: &[f64], x: &mut [f64]) {
        for (i, x) in x.iter_mut().enumerate() {
            let inner = self.a[i] + theta * (self.b[i] + theta * self.c[i]);
            *x = start[i] + theta * (end[i] - start[i] + (1.0 - theta) * inner);
        }
    }
}

/// Signs of indicators, and room to look for the place where one changes.
#[derive(Default)]
pub(crate) struct Indicators {
    /// At the start of the internal step.
    pub(crate) start: Vec<f64>,
    /// At the end of the internal step.
    pub(crate) end: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    middle: Vec<f64>,
}

/// Whether the sign of an indicator changes from `a` to `b`.
fn changes(a: f64, b: f64) -> bool {
    (a > 0.0) != (b > 0.0)
}

impl Indicators {
    pub(crate) fn new(n: usize) -> Self {
        let zero = || vec![0.0; n];
        Self {
            start: zero(),
            end: zero(),
            low: zero(),
            high: zero(),
            middle: zero(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.start.is_empty()
    }

    /// Whether one changes within the internal step.
    pub(crate) fn has_event(&self) -> bool {
        (self.start.iter().zip(&self.end)).any(|(a, b)| changes(*a, *b))
    }

    /// The first place θ at which the sign of an indicator has changed, to `resolution`; `x` are the
    /// states there, and `states` computes them of θ. The place is that behind the change, so that
    /// whoever goes on from there does not meet it again.
    ///
    /// Regula falsi with the weights of the Illinois method, for the indicator that it says passes
    /// zero first; each fourth time the middle is taken, for indicators that it is slow with.
    pub(crate) fn locate<S: System>(
        &mut self,
        system: &mut S,
        (s, dt): (f64, f64),
        resolution: f64,
        states: impl Fn(f64, &mut [f64]),
        x: &mut [f64],
    ) -> Result<f64, S::Error> {
        let (mut low, mut high) = (0.0, 1.0);
        let mut was_low = None;
        self.low.copy_from_slice(&self.start);
        self.high.copy_from_slice(&self.end);
        for count in 1.. {
            if high - low <= resolution {
                break;
            }
            let least = 0.5 * resolution / (high - low);
            let share = match count % 4 {
                0 => 0.5,
                _ => self.first_crossing().clamp(least, 1.0 - least),
            };
            let theta = low + share * (high - low);
            states(theta, x);
            system.indicators(s + theta * dt, x, &mut self.middle)?;
            let is_low = !(self.start.iter().zip(&self.middle)).any(|(a, b)| changes(*a, *b));
            let (near, far) = match is_low {
                true => (&mut self.low, &mut self.high),
                false => (&mut self.high, &mut self.low),
            };
            near.copy_from_slice(&self.middle);
            if was_low == Some(is_low) {
                far.iter_mut().for_each(|z| *z *= 0.5);
            }
            was_low = Some(is_low);
            *if is_low { &mut low } else { &mut high } = theta;
        }
        states(high, x);
        Ok(high)
    }

    /// Where a straight line says that an indicator first changes its sign between the two ends.
    fn first_crossing(&self) -> f64 {
        (self.low.iter().zip(&self.high))
            .filter(|(a, b)| changes(**a, **b))
            .map(|(a, b)| a / (a - b))
            .fold(1.0, f64::min)
    }
}
