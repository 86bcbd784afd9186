//! Test FMU: a linear spring with damper, driven by the motion of its end.
//!
//! F = −k (1 + stage) x − d x_dot − m x_ddot (m = 0 unless set), 0 where it is off. Inside a step x
//! follows x + x_dot·s where no derivatives are given.

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use serde::{Deserialize, Serialize};

#[derive(Clone, Serialize, Deserialize)]
struct Spring {
    mean: f64,
}
#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    k: f64,
    d: f64,
    m: f64,
}
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    x: f64,
    x_dot: f64,
    x_ddot: f64,
    off: bool,
    stage: i32,
}
#[derive(Clone, Copy, Default)]
struct Output {
    force: f64,
    mean: f64,
}

type V = Variable<Spring>;
#[rustfmt::skip]
const VARIABLES: &[V] = &[
    V::parameter("k", "stiffness", |p| &p.k, |p| &mut p.k).unit("N/m").min(0.0),
    V::parameter("d", "damping", |p| &p.d, |p| &mut p.d).unit("N.s/m").min(0.0),
    V::parameter("m", "mass that moves with the end", |p| &p.m, |p| &mut p.m).unit("kg").min(0.0),
    V::input("x", "elongation", |u| &u.x, |u| &mut u.x).unit("m"),
    V::input("x_dot", "rate of elongation", |u| &u.x_dot, |u| &mut u.x_dot).unit("m/s"),
    V::input("x_ddot", "acceleration of the end", |u| &u.x_ddot, |u| &mut u.x_ddot).unit("m/s2"),
    V::boolean_input("off", "whether it gives no force", |u| &u.off, |u| &mut u.off),
    V::integer_input("stage", "springs added in parallel", |u| &u.stage, |u| &mut u.stage),
    V::output("F", "force on what moves", |y| &y.force).unit("N")
        .depends_on(&["x", "x_dot", "x_ddot", "off", "stage"]).initially_depends_on(&["x", "x_dot", "x_ddot", "off", "stage", "k", "d", "m"]),
    V::output("F_mean", "mean of F over the last step", |y| &y.mean).unit("N")
        .depends_on(&[]).initially_depends_on(&["x", "x_dot", "x_ddot", "off", "stage", "k", "d", "m"]),
];

fn force(p: &Parameters, u: &Input) -> f64 {
    if u.off {
        return 0.0;
    }
    -p.k * f64::from(1 + u.stage) * u.x - p.d * u.x_dot - p.m * u.x_ddot
}

impl Model for Spring {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Spring", "motion-driven spring and damper")
        .with_input_derivatives()
        .with_output_derivatives();

    fn variables() -> &'static [Variable<Self>] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        (
            Parameters {
                k: 3.0,
                d: 0.0,
                m: 0.0,
            },
            Input::default(),
        )
    }

    fn initialize(p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> {
        Ok(Self { mean: force(p, u) })
    }

    fn output(&self, p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(Output {
            force: force(p, u),
            mean: self.mean,
        })
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        _t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let at = |s: f64| {
            let Input {
                x,
                x_dot,
                x_ddot,
                off,
                stage,
            } = u.at::<Self>(s);
            let held = u.order() == 0;
            force(
                p,
                &Input {
                    x: if held { x + x_dot * s } else { x },
                    x_dot,
                    x_ddot,
                    off,
                    stage,
                },
            )
        };
        self.mean = (at(0.0) + 4.0 * at(0.5 * h) + at(h)) / 6.0; // Simpson: exact for these polynomials
        Ok(StepEnd::WHOLE)
    }

    fn output_derivative(
        &self,
        p: &Parameters,
        _u: &Input,
        _now: &(),
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok(Output {
            force: force(p, u_dot),
            mean: 0.0,
        })
    }
}

fmu_export::export_fmu!(Spring);
