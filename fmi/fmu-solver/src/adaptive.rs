//! Step size control of `Solver` for methods with a tolerance: steps as long as the error allows.

use super::algorithm::{Algorithm, Step};
use super::system::System;
use super::{Failure, MOST_STEPS, Workspace};

/// Factor by which steps are shorter than the error allows, so that few are rejected.
const SAFETY: f64 = 0.9;
/// Smallest and largest factor between the lengths of successive steps.
const FACTORS: [f64; 2] = [0.2, 6.0];

/// The length of the next internal step.
#[derive(Clone, Copy)]
pub(super) struct Control {
    /// To try next, s; 0 if not known.
    pub(super) dt: f64,
    /// Largest factor from the last length to the next.
    pub(super) most: f64,
}

impl Control {
    /// With the length to try first, s.
    pub(super) fn new(first: f64) -> Self {
        Self {
            dt: first,
            most: FACTORS[1],
        }
    }
}

impl Workspace {
    /// The root mean square of `values` relative to the allowed errors of states of magnitude
    /// `|x|`.
    fn norm(&self, x: impl Iterator<Item = f64>, values: impl Iterator<Item = f64>) -> f64 {
        let sum: f64 = (self.step.nominal.iter().zip(x).zip(values))
            .map(|((nominal, x), value)| value / (self.tolerance * x.abs().max(*nominal)))
            .map(|ratio| ratio * ratio)
            .sum();
        (sum / self.step.nominal.len() as f64).sqrt()
    }

    /// A first step, s, in which the states change by one per cent of their magnitudes, ≤ `h`.
    fn first_step(&self, rate: &[f64], h: f64) -> f64 {
        let Step { nominal, x, .. } = &self.step;
        let sizes = || (nominal.iter().zip(x)).map(|(nominal, x)| nominal.max(x.abs()));
        let size = self.norm(sizes(), sizes());
        let change = self.norm(sizes(), rate.iter().copied());
        (0.01 * size / change).min(h) // infinite if nothing changes
    }

    /// Makes one internal step of at most `rest`, s: as long as the error allows, shorter ones in its
    /// place until the error is small enough. `h` is the length, s, on which the first step and the
    /// shortest one depend.
    pub(super) fn controlled_step<A: Algorithm, S: System>(
        &mut self,
        method: &mut A,
        system: &mut S,
        [rest, h]: [f64; 2],
        control: &mut Control,
    ) -> Result<(), Failure<S::Error>> {
        let dt = &mut control.dt;
        self.step.dt = if *dt > 0.0 { dt.min(h) } else { h };
        let rate = method.begin(system, &self.step)?;
        if *dt <= 0.0 {
            *dt = self.first_step(rate, h);
        }
        self.counts.jacobians += u64::from(A::HAS_JACOBIAN);
        let s = self.step.s;
        loop {
            *dt = dt.min(self.longest);
            // Two steps of half the rest rather than a full and a short one.
            let length = if *dt >= rest {
                rest
            } else {
                dt.min(0.5 * rest)
            };
            self.step.dt = length;
            let done = method.step(system, &mut self.step);
            let ends = self.step.x.iter().zip(&self.step.end);
            let sizes = ends.map(|(a, b)| a.abs().max(b.abs()));
            let norm = match done {
                Ok(true) => self.norm(sizes, self.step.error.iter().copied()),
                _ => f64::INFINITY,
            };
            let factor = SAFETY / fifth_root(norm.clamp(1e-30, 1e30));
            if norm <= 1.0 {
                let next = length * factor.clamp(FACTORS[0], control.most);
                *dt = if length < *dt { dt.max(next) } else { next };
                control.most = FACTORS[1];
                return Ok(());
            }
            self.counts.rejected += 1;
            *dt = length * factor.max(FACTORS[0]);
            control.most = 1.0;
            let may_retry = done.as_ref().err().is_none_or(|e| system.may_retry(e));
            if !may_retry || *dt < 16.0 * f64::EPSILON * (self.step.t + s).abs().max(h) {
                return Err(done
                    .err()
                    .map_or(Failure::TooShort(s, length), Failure::System));
            }
        }
    }

    /// Advances to the end of the communication step or the first event. Returns the time of the
    /// event, if any, and the internal step to try next, s.
    pub(super) fn adaptive_steps<A: Algorithm, S: System>(
        &mut self,
        method: &mut A,
        system: &mut S,
        h: f64,
        first: f64,
    ) -> Result<(Option<f64>, f64), Failure<S::Error>> {
        let mut control = Control::new(first);
        for _ in 0..MOST_STEPS as u64 {
            let rest = h - self.step.s;
            self.controlled_step(method, system, [rest, h], &mut control)?;
            let length = self.step.dt;
            if let Some(event) = self.accept_step(method, system)? {
                return Ok((Some(event), 0.0)); // the solution may change completely after it
            }
            if length == rest {
                return Ok((None, control.dt));
            }
            self.step.s += length;
        }
        Err(Failure::TooManySteps(MOST_STEPS, control.dt))
    }
}

/// The fifth root of a number from 10⁻³⁰ to 10³⁰, by Newton's method, starting with a fifth of the
/// exponent. `powf` gives different last bits on different platforms.
fn fifth_root(x: f64) -> f64 {
    let mut root = f64::from_bits(x.to_bits() / 5 + 1.0_f64.to_bits() / 5 * 4);
    for _ in 0..4 {
        let square = root * root;
        root -= 0.2 * (root - x / (square * square));
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oracle: the fifth power. Newton's method squares the relative error, below 0.1 at the start.
    #[test]
    fn the_fifth_root_is_one() {
        for k in -300..=300 {
            let root = 10_f64.powf(f64::from(k) / 50.0 + 1e-3);
            let found = fifth_root(root * root * root * root * root);
            assert!((found / root - 1.0).abs() < 1e-13, "{root} {found}");
        }
    }
}
