//! Four integrators, a model so cheap that a step measures the cost of fmu-export alone. The
//! benchmark `tests/bench/measure.py` compares it with the same FMU written by hand in C.

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use serde::{Deserialize, Serialize};

/// Four integrators, `x_dot = u`.
#[derive(Clone, Serialize, Deserialize)]
pub struct Integrators {
    x: [f64; 4],
}

/// No parameters.
#[derive(Clone, Serialize, Deserialize)]
pub struct Nothing;

/// Rates.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct Input {
    u: [f64; 4],
}

/// Integrals.
#[derive(Clone, Copy, Default)]
pub struct Output {
    x: [f64; 4],
}

type V = Variable<Integrators>;
const VARIABLES: &[V] = &[
    V::inputs("u", "rate", |u| &u.u, |u| &mut u.u)
        .min(-1e9)
        .max(1e9),
    V::outputs("x", "integral", |y| &y.x).depends_on(&[]),
];

impl Model for Integrators {
    type Parameters = Nothing;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Integrators", "next to nothing");

    fn variables() -> &'static [V] {
        VARIABLES
    }

    fn defaults() -> (Nothing, Input) {
        (Nothing, Input::default())
    }

    fn initialize(_p: &Nothing, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        Ok(Self { x: [0.0; 4] })
    }

    fn output(&self, _p: &Nothing, _u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(Output { x: self.x })
    }

    fn step(
        &mut self,
        _p: &Nothing,
        u: &InputPolynomial<Input>,
        _now: &(),
        _t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        for (x, u) in self.x.iter_mut().zip(u.value().u) {
            *x += h * u;
        }
        Ok(StepEnd::WHOLE)
    }
}

fmu_export::export_fmu!(Integrators);
