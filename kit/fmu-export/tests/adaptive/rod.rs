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
    conduction(x, heat)
}

fn conduction(x: &[f64; CELLS], heat: f64) -> [f64; CELLS] {
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

/// Rod that knows its Jacobian
#[derive(State)]
#[fmu(input = Input, solver = "stiff", tolerance = 1e-4, model_exchange)]
pub struct Rod {
    /// Cells
    #[fmu(unit = "1", start = exact(0.0), rate_depends_on(T[i - 1], T[i], T[i + 1], heat))]
    T: [f64; CELLS],
}

impl Ode for Rod {
    fn derivative(&self, _p: &(), u: &Input, _t: f64, dx: &mut Self) {
        dx.T = rate(&self.T, u.heat);
    }

    const HAS_DIRECTIONAL: bool = true;

    /// Conduction is linear.
    fn directional(&self, _p: &(), _u: &Input, _t: f64, seed: (&Self, &Input), dx: &mut Self) {
        dx.T = conduction(&seed.0.T, seed.1.heat);
    }
}

/// Rod whose Jacobian is that of differences
#[derive(State)]
#[fmu(input = Input, solver = "stiff", tolerance = 1e-4)]
pub struct Sparse {
    /// Cells
    #[fmu(unit = "1", start = exact(0.0), rate_depends_on(T[i - 1], T[i], T[i + 1], heat))]
    T: [f64; CELLS],
}

impl Ode for Sparse {
    fn derivative(&self, _p: &(), u: &Input, _t: f64, dx: &mut Self) {
        dx.T = rate(&self.T, u.heat);
    }
}

/// Rod that is wrong about its Jacobian
#[derive(State)]
#[fmu(input = Input, output = Shown, model_exchange)]
pub struct Wrong {
    /// Temperature
    #[fmu(unit = "1", start = 1.0)]
    T: f64,
}

#[derive(Output)]
pub struct Shown {
    /// Twice the temperature and the heat
    #[fmu(unit = "1")]
    twice: f64,
}

impl Ode for Wrong {
    fn derivative(&self, _p: &(), u: &Input, _t: f64, dx: &mut Self) {
        dx.T = u.heat - 3.0 * self.T;
    }

    fn outputs(&self, _p: &(), u: &Input) -> Shown {
        Shown {
            twice: 2.0 * (self.T + u.heat),
        }
    }

    const HAS_DIRECTIONAL: bool = true;

    fn directional(&self, _p: &(), _u: &Input, _t: f64, seed: (&Self, &Input), dx: &mut Self) {
        dx.T = 0.5 * seed.1.heat + 3.0 * seed.0.T;
    }

    fn outputs_directional(&self, _p: &(), _u: &Input, seed: (&Self, &Input), dy: &mut Shown) {
        dy.twice = 2.0 * seed.1.heat;
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
