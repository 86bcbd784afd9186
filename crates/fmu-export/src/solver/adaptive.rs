//! Internal steps as long as a tolerance allows.

use super::dormand_prince::DormandPrince;
use super::rosenbrock::Rosenbrock;
use super::system::System;
use super::{Algorithm, Failure, MOST_STEPS, Solver, TOLERANCE};

/// A method with an estimate of its own error, of order 4.
pub(crate) enum Adaptive {
    Explicit(DormandPrince),
    Implicit(Box<Rosenbrock>),
}

/// How large an error may be.
pub(crate) struct Control {
    nominal: Vec<f64>,
    pub(crate) tolerance: f64,
    /// What an internal step may at most be, s.
    pub(crate) longest: f64,
    /// The estimate of the errors of an internal step.
    error: Vec<f64>,
}

/// How much shorter than the error allows steps are, so that few are rejected.
const SAFETY: f64 = 0.9;
/// By what the length of a step changes at least and at most.
const FACTORS: [f64; 2] = [0.2, 6.0];

impl Control {
    pub(crate) fn new(nominal: Vec<f64>, longest: f64) -> Self {
        let error = vec![0.0; nominal.len()];
        Self {
            nominal,
            tolerance: TOLERANCE,
            longest,
            error,
        }
    }

    /// Room for states while no step is tried.
    pub(crate) fn room(&mut self) -> &mut [f64] {
        &mut self.error
    }

    /// The root of the mean square of `values` over what errors may be where the sizes of the states
    /// are at least `|x|`.
    fn norm(&self, x: impl Iterator<Item = f64>, values: impl Iterator<Item = f64>) -> f64 {
        let sum: f64 = (self.nominal.iter().zip(x).zip(values))
            .map(|((nominal, x), value)| value / (self.tolerance * x.abs().max(*nominal)))
            .map(|ratio| ratio * ratio)
            .sum();
        (sum / self.nominal.len() as f64).sqrt()
    }

    /// A first step, s, in which the states change by one per cent of their sizes, and at most `h`.
    fn first_step(&self, x: &[f64], rate: &[f64], h: f64) -> f64 {
        let sizes = || (self.nominal.iter().zip(x)).map(|(nominal, x)| nominal.max(x.abs()));
        let size = self.norm(sizes(), sizes());
        let change = self.norm(sizes(), rate.iter().copied());
        (0.01 * size / change).min(h) // infinite if nothing changes
    }
}

/// The fifth root of a number from 10⁻³⁰ to 10³⁰, by Newton's method from a fifth of its exponent.
/// That of the standard library has other last bits on other machines.
fn fifth_root(x: f64) -> f64 {
    let mut root = f64::from_bits(x.to_bits() / 5 + 1.0_f64.to_bits() / 5 * 4);
    for _ in 0..4 {
        let square = root * root;
        root -= 0.2 * (root - x / (square * square));
    }
    root
}

impl Solver {
    /// To the end of the step or the first event. The answer is when that was, and the internal step
    /// to try next, s.
    pub(super) fn adapt<S: System>(
        &mut self,
        system: &mut S,
        (t, h): (f64, f64),
        first: f64,
    ) -> Result<(Option<f64>, f64), Failure<S::Error>> {
        let (mut s, mut dt) = (0.0, first);
        let mut most = FACTORS[1];
        self.method().forget();
        for _ in 0..MOST_STEPS as u64 {
            let Self {
                algorithm: Algorithm::Adaptive(method),
                control,
                x,
                end,
                counts,
                ..
            } = self
            else {
                unreachable!("asked for above");
            };
            let about = if dt > 0.0 { dt.min(h) } else { h };
            let rate = method
                .begin(system, (t, s, about), x, &control.nominal)
                .map_err(Failure::System)?;
            if dt <= 0.0 {
                dt = control.first_step(x, rate, h);
            }
            dt = dt.min(control.longest);
            let rest = h - s;
            // Two steps of half the rest rather than one whole and a short one.
            let trial = if dt >= rest { rest } else { dt.min(0.5 * rest) };
            let done = method.step(system, (s, trial), x, end, &mut control.error);
            let size = x.iter().zip(&*end).map(|(a, b)| a.abs().max(b.abs()));
            let norm = match done {
                Ok(true) => control.norm(size, control.error.iter().copied()),
                _ => f64::INFINITY,
            };
            let factor = SAFETY / fifth_root(norm.clamp(1e-30, 1e30));
            if !(norm <= 1.0) {
                counts.rejected += 1;
                dt = trial * factor.max(FACTORS[0]);
                most = 1.0;
                if dt < 16.0 * f64::EPSILON * (t + s).abs().max(h) {
                    return Err(done
                        .err()
                        .map_or(Failure::TooShort { s, dt: trial }, Failure::System));
                }
                continue;
            }
            counts.steps += 1;
            let next = trial * factor.clamp(FACTORS[0], most);
            dt = if trial < dt { dt.max(next) } else { next };
            most = FACTORS[1];
            if let Some(event) = self
                .arrive(system, t, (s, trial))
                .map_err(Failure::System)?
            {
                return Ok((Some(event), 0.0)); // what follows may be quite another course
            }
            if trial == rest {
                return Ok((None, dt));
            }
            self.method().accept();
            s += trial;
        }
        Err(Failure::TooManySteps {
            steps: MOST_STEPS,
            longest: dt,
        })
    }

    fn method(&mut self) -> &mut Adaptive {
        match &mut self.algorithm {
            Algorithm::Adaptive(method) => method,
            Algorithm::Fixed(..) => unreachable!("has no tolerance"),
        }
    }
}

impl Adaptive {
    fn begin<S: System>(
        &mut self,
        system: &mut S,
        (t, s, dt): (f64, f64, f64),
        x: &[f64],
        nominal: &[f64],
    ) -> Result<&[f64], S::Error> {
        match self {
            Self::Explicit(method) => method.begin(system, s, x),
            Self::Implicit(method) => method.begin(system, (t, s, dt), x, nominal),
        }
    }

    /// Whether there is an estimate of the error; none if equations have no solution.
    fn step<S: System>(
        &mut self,
        system: &mut S,
        (s, dt): (f64, f64),
        x: &[f64],
        end: &mut [f64],
        error: &mut [f64],
    ) -> Result<bool, S::Error> {
        match self {
            Self::Explicit(method) => method.step(system, (s, dt), x, end, error).map(|()| true),
            Self::Implicit(method) => method.step(system, (s, dt), x, end, error),
        }
    }

    fn forget(&mut self) {
        match self {
            Self::Explicit(method) => method.forget(),
            Self::Implicit(method) => method.forget(),
        }
    }

    fn accept(&mut self) {
        match self {
            Self::Explicit(method) => method.accept(),
            Self::Implicit(method) => method.forget(),
        }
    }
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
