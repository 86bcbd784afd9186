//! Conduction in a rod of cells with isolated ends, whose first cell an input heats.

use fmu_export::prelude::*;
use std::cell::Cell;

pub const CELLS: usize = 20;

thread_local! {
    static EVALUATIONS: Cell<u64> = const { Cell::new(0) };
}

/// How often derivatives were evaluated in this thread.
pub fn evaluations() -> u64 {
    EVALUATIONS.get()
}

/// The discrete Laplacian's eigenvector of wave number k, cos(π k (i + ½)/n), decays at λ = 4 n²
/// sin²(π k/(2 n)).
pub fn exact(t: f64) -> [f64; CELLS] {
    let n = CELLS as f64;
    let wave = |k: f64, i: usize| {
        let half = std::f64::consts::FRAC_PI_2 * k / n;
        (half * (2 * i + 1) as f64).cos() * (-4.0 * n * n * half.sin().powi(2) * t).exp()
    };
    std::array::from_fn(|i| 2.0 + 0.7 * wave(1.0, i) + 0.3 * wave(5.0, i))
}

fn rate(x: &[f64; CELLS], heat: f64) -> [f64; CELLS] {
    EVALUATIONS.set(EVALUATIONS.get() + 1);
    let share = (CELLS * CELLS) as f64;
    std::array::from_fn(|i| {
        let left = if i > 0 { x[i - 1] - x[i] } else { 0.0 };
        let right = if i + 1 < CELLS { x[i + 1] - x[i] } else { 0.0 };
        share * (left + right) + if i == 0 { heat } else { 0.0 }
    })
}

#[derive(Input)]
pub struct Input {
    /// Heat
    #[fmu(unit = "1/s")]
    heat: f64,
}

/// Rod
#[derive(State)]
#[fmu(input = Input, solver = "stiff", tolerance = 1e-4)]
pub struct Rod {
    /// Cells
    #[fmu(unit = "1", start = exact(0.0), rate_depends_on(T[i - 1], T[i], T[i + 1], heat))]
    T: [f64; CELLS],
}

impl Ode for Rod {
    fn derivative(&self, _p: &(), u: &Input, _t: f64, dx: &mut Self) {
        dx.T = rate(&self.T, u.heat);
    }
}

/// Rod whose Jacobian is not known to be sparse
#[derive(State)]
#[fmu(input = Input, solver = "stiff", tolerance = 1e-4)]
pub struct Full {
    /// Cells
    #[fmu(unit = "1", start = exact(0.0))]
    T: [f64; CELLS],
}

impl Ode for Full {
    fn derivative(&self, _p: &(), u: &Input, _t: f64, dx: &mut Self) {
        dx.T = rate(&self.T, u.heat);
    }
}

/// Rod whose rate names no variable
#[derive(State)]
#[fmu(input = Input, solver = "stiff")]
pub struct Misnamed {
    /// Cells
    #[fmu(unit = "1", start = exact(0.0), rate_depends_on(t[i], heat))]
    T: [f64; CELLS],
}

impl Ode for Misnamed {
    fn derivative(&self, _p: &(), u: &Input, _t: f64, dx: &mut Self) {
        dx.T = rate(&self.T, u.heat);
    }
}

/// A step of 0.1 s.
pub fn step<S: Ode<P = (), U = Input>>(mut rod: S) {
    let u = InputPolynomial::held(Input::default());
    Model::step(&mut rod, &(), &u, &(), 0.0, 0.1).unwrap();
}

export_fmu!(Rod);
