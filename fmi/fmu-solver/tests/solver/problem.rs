//! Systems made of closures.

use fmu_solver::{Method, Solver, System};
use std::cell::Cell;

pub type Answer = Result<(), String>;

/// Equations, and how often they were evaluated.
pub struct Problem<F, Z> {
    pub f: F,
    pub z: Z,
    pub evaluations: Cell<u64>,
}

impl<F: Fn(f64, &[f64], &mut [f64]) -> Answer> Problem<F, fn(f64, &[f64], &mut [f64])> {
    pub fn new(f: F) -> Self {
        Self {
            f,
            z: |_, _, _| {},
            evaluations: Cell::new(0),
        }
    }
}

impl<F, Z> System for Problem<F, Z>
where
    F: Fn(f64, &[f64], &mut [f64]) -> Answer,
    Z: Fn(f64, &[f64], &mut [f64]),
{
    type Error = String;

    fn derivative(&mut self, s: f64, x: &[f64], dx: &mut [f64]) -> Answer {
        self.evaluations.set(self.evaluations.get() + 1);
        (self.f)(s, x, dx)
    }

    fn indicators(&mut self, s: f64, x: &[f64], z: &mut [f64]) -> Answer {
        (self.z)(s, x, z);
        Ok(())
    }
}

/// A solver with nominal values of 1 for `n` states.
pub fn solver(
    method: &Method,
    n: usize,
    indicators: usize,
    longest: f64,
    tolerance: f64,
) -> Solver {
    let mut solver = Solver::new(method.clone(), vec![1.0; n], indicators, longest);
    solver.set_tolerance(tolerance);
    solver
}
