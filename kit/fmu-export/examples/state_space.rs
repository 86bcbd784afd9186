//! FMU for `tests/test_sizes.py`: a linear state-space system like that of the Reference-FMUs,
//! whose sizes are structural parameters.

#![allow(non_snake_case)] // matrices

use fmu_export::prelude::*;

#[derive(Parameters)]
struct Parameters {
    /// Number of states
    #[fmu(structural, start = 3, min = 1, max = 1000)]
    n: i32,
    /// Number of inputs
    #[fmu(structural, start = 3, min = 1, max = 1000)]
    m: i32,
    /// Number of outputs
    #[fmu(structural, start = 3, min = 1, max = 1000)]
    r: i32,
    /// State matrix
    #[fmu(unit = "1/s", start = if i.is_multiple_of(n.isqrt() + 1) { 1.0 } else { 0.0 }, len = (p.n, p.n))]
    A: Vec<f64>,
    /// Input matrix
    #[fmu(unit = "1/s", len = (p.n, p.m), start = 0.0)]
    B: Vec<f64>,
    /// Output matrix
    #[fmu(unit = "1", len = (p.r, p.n), start = 1.0)]
    C: Vec<f64>,
    /// Feedthrough matrix
    #[fmu(unit = "1", len = (p.r, p.m), start = 0.0)]
    D: Vec<f64>,
    /// States at the start
    #[fmu(unit = "1", len = p.n, start = 1.0 + i as f64)]
    x0: Vec<f64>,
}

#[derive(Input)]
struct Input {
    /// Inputs
    #[fmu(unit = "1", len = p.m)]
    u: Vec<f64>,
}

#[derive(Output)]
struct Output {
    /// Outputs
    #[fmu(unit = "1", len = p.r, depends_on(x, u), initially_depends_on(x0, C, D, u))]
    y: Vec<f64>,
}

/// x' = A x + B u, y = C x + D u
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, max_step = 0.01, experiment(0.0, 1.0, 0.1), model_exchange)]
struct StateSpace {
    /// States
    #[fmu(unit = "1", len = p.n, start = p.x0[i], rate_depends_on(x, u))]
    x: Vec<f64>,
}

/// to = M x + N u, matrices row by row
fn sums(to: &mut [f64], (M, x): (&[f64], &[f64]), (N, u): (&[f64], &[f64])) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let rows = M.chunks(x.len()).zip(N.chunks(u.len()));
    for (to, (row_M, row_N)) in to.iter_mut().zip(rows) {
        *to = dot(row_M, x) + dot(row_N, u);
    }
}

impl Ode for StateSpace {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        sums(&mut dx.x, (&p.A, &self.x), (&p.B, &u.u));
    }

    fn outputs_into(&self, p: &Parameters, u: &Input, y: &mut Output) {
        sums(&mut y.y, (&p.C, &self.x), (&p.D, &u.u));
    }
}

export_fmu!(StateSpace);
