//! Test FMU: a free mass under a force that is held or linear over the step; integrated exactly.

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use serde::{Deserialize, Serialize};

#[derive(Clone, Serialize, Deserialize)]
struct Mass {
    x: f64,
    x_dot: f64,
    steps: i32,
}
#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    m: f64,
    x_start: f64,
    x_dot_start: f64,
    fails_at: f64,
    pauses_at: f64,
}
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    f: f64,
}
#[derive(Clone, Copy, Default)]
struct Output {
    x: f64,
    x_dot: f64,
    x_ddot: f64,
    is_left: bool,
    steps: i32,
}

type V = Variable<Mass>;
#[rustfmt::skip]
const VARIABLES: &[V] = &[
    V::parameter("m", "mass", |p| &p.m, |p| &mut p.m).unit("kg").min(1e-3),
    V::parameter("x_start", "start position", |p| &p.x_start, |p| &mut p.x_start).unit("m"),
    V::parameter("x_dot_start", "start velocity", |p| &p.x_dot_start, |p| &mut p.x_dot_start).unit("m/s"),
    V::parameter("fails_at", "steps that begin here or later are refused", |p| &p.fails_at, |p| &mut p.fails_at).unit("s"),
    V::parameter("pauses_at", "a step over this time ends there", |p| &p.pauses_at, |p| &mut p.pauses_at).unit("s"),
    V::input("f", "force", |u| &u.f, |u| &mut u.f).unit("N").min(-1e3).max(1e3),
    V::output("x", "position", |y| &y.x).unit("m").depends_on(&[]).initially_depends_on(&["x_start"]),
    V::output("x_dot", "velocity", |y| &y.x_dot).unit("m/s").depends_on(&[]).initially_depends_on(&["x_dot_start"]),
    V::output("x_ddot", "acceleration", |y| &y.x_ddot).unit("m/s2").depends_on(&["f"]).initially_depends_on(&["f", "m"]),
    V::boolean_output("is_left", "whether x is negative", |y| &y.is_left).depends_on(&[]).initially_depends_on(&["x_start"]),
    V::integer_output("steps", "steps made", |y| &y.steps).depends_on(&[]).initially_depends_on(&[]),
];

impl Model for Mass {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Mass", "free mass")
        .with_input_derivatives()
        .with_directional_derivatives()
        .with_output_derivatives();

    fn variables() -> &'static [Variable<Self>] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        (
            Parameters {
                m: 1.0,
                x_start: 1.0,
                x_dot_start: 0.0,
                fails_at: 1e9,
                pauses_at: 1e9,
            },
            Input::default(),
        )
    }

    fn initialize(p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        Ok(Self {
            x: p.x_start,
            x_dot: p.x_dot_start,
            steps: 0,
        })
    }

    fn output(&self, p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(Output {
            x: self.x,
            x_dot: self.x_dot,
            x_ddot: u.f / p.m,
            is_left: self.x < 0.0,
            steps: self.steps,
        })
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        if t >= p.fails_at {
            return Err(ModelError::new("`fails_at` is reached"));
        }
        let rest = p.pauses_at - t;
        let reached = match p.pauses_at {
            0.0 => Some(0.5 * h),
            _ => Some(rest).filter(|rest| *rest > 1e-9 && *rest < h - 1e-9),
        };
        let h = reached.unwrap_or(h);
        let (a, jerk) = (u.value().f / p.m, u.derivative(1).f / p.m);
        self.x += h * (self.x_dot + h * (a / 2.0 + h * jerk / 6.0));
        self.x_dot += h * (a + h * jerk / 2.0);
        self.steps += 1;
        let mut end = StepEnd::WHOLE;
        (end.reached, end.event) = (reached, reached.is_some());
        Ok(end)
    }

    fn directional_derivative(
        &self,
        p: &Parameters,
        _u: &Input,
        _now: &(),
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok(Output {
            x_ddot: du.f / p.m,
            ..Output::default()
        })
    }

    fn output_derivative(
        &self,
        p: &Parameters,
        u: &Input,
        _now: &(),
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok(Output {
            x: self.x_dot,
            x_dot: u.f / p.m,
            x_ddot: u_dot.f / p.m,
            ..Output::default()
        })
    }
}

fmu_export::export_fmu!(Mass);
