//! FMU `Chassis`: the body of a quarter car on its suspension, above a wheel whose velocity it is
//! given.
//!
//! ```text
//! F = −F_0 − k s − d |ṡ|^e sign ṡ     ṡ = v − v_body     m dv_body/dt = −F − F_0
//! ```
//! `F` acts on the wheel, `s` is by how much the wheel is nearer to the body than at rest,
//! where the suspension carries the load `F_0`.

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use serde::{Deserialize, Serialize};

/// Longest internal step, s.
const H_MAX: f64 = 1e-4;

#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    m: f64,
    k: f64,
    d: f64,
    exponent: f64,
    x_start: f64,
    s_start: f64,
    load: f64,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    v: f64,
}

#[derive(Clone, Serialize, Deserialize)]
struct Chassis {
    x: f64,
    v: f64,
    s: f64,
    /// Mean force over the last step, N.
    mean: f64,
}

#[derive(Clone, Copy, Default)]
struct Output {
    force: f64,
    mean: f64,
    x: f64,
    v: f64,
}

type V = Variable<Chassis>;
#[rustfmt::skip]
const VARIABLES: &[V] = &[
    V::parameter("m", "mass", |p| &p.m, |p| &mut p.m).unit("kg").min(1e-3),
    V::parameter("k", "stiffness of the suspension", |p| &p.k, |p| &mut p.k).unit("N/m").min(0.0),
    V::parameter("d", "force of the damper at 1 m/s", |p| &p.d, |p| &mut p.d).unit("N").min(0.0),
    V::parameter("exponent", "exponent of the damper's velocity", |p| &p.exponent, |p| &mut p.exponent).unit("1").min(0.1).max(2.0),
    V::parameter("x_start", "position at the start", |p| &p.x_start, |p| &mut p.x_start).unit("m"),
    V::parameter("s_start", "compression at the start", |p| &p.s_start, |p| &mut p.s_start).unit("m"),
    V::parameter("F_0", "load that the suspension carries at rest", |p| &p.load, |p| &mut p.load).unit("N"),
    V::input("v", "velocity of the wheel", |u| &u.v, |u| &mut u.v).unit("m/s"),
    V::output("F", "force on the wheel", |y| &y.force).unit("N").depends_on(&["v"]).initially_depends_on(&["v", "k", "d", "exponent", "s_start", "F_0"]),
    V::output("F_mean", "mean of F over the last step", |y| &y.mean).unit("N").depends_on(&[]).initially_depends_on(&["v", "k", "d", "exponent", "s_start", "F_0"]),
    V::output("x_body", "position", |y| &y.x).unit("m").depends_on(&[]).initially_depends_on(&["x_start"]),
    V::output("v_body", "velocity", |y| &y.v).unit("m/s").depends_on(&[]).initially_depends_on(&[]),
];

fn force(p: &Parameters, s: f64, s_dot: f64) -> f64 {
    -p.load - p.k * s - p.d * s_dot.abs().powf(p.exponent).copysign(s_dot)
}

impl Model for Chassis {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info =
        Info::new("Chassis", "body of a quarter car on its suspension").with_input_derivatives();

    fn variables() -> &'static [Variable<Self>] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let p = Parameters {
            m: 400.0,
            k: 15e3,
            d: 1e3,
            exponent: 1.0,
            x_start: 0.0,
            s_start: 0.0,
            load: 0.0,
        };
        (p, Input::default())
    }

    fn initialize(p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> {
        let (x, s) = (p.x_start, p.s_start);
        Ok(Self {
            x,
            v: 0.0,
            s,
            mean: force(p, s, u.v),
        })
    }

    fn output(&self, p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        let force = force(p, self.s, u.v - self.v);
        Ok(Output {
            force,
            mean: self.mean,
            x: self.x,
            v: self.v,
        })
    }

    /// Runge–Kutta of order 4 for position, velocity, compression and momentum given to the wheel.
    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        _t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let n = (h / H_MAX).ceil();
        let dt = h / n;
        let mut z = [self.x, self.v, self.s, 0.0];
        for k in 0..n as u32 {
            let rate = |z: [f64; 4], share: f64| {
                let s_dot = u.at::<Self>((f64::from(k) + share) * dt).v - z[1];
                let force = force(p, z[2], s_dot);
                [z[1], -(force + p.load) / p.m, s_dot, force]
            };
            let moved = |by: f64, rate: [f64; 4]| std::array::from_fn(|i| z[i] + by * rate[i]);
            let a = rate(z, 0.0);
            let b = rate(moved(0.5 * dt, a), 0.5);
            let c = rate(moved(0.5 * dt, b), 0.5);
            let d = rate(moved(dt, c), 1.0);
            z = std::array::from_fn(|i| z[i] + dt / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
        }
        *self = Self {
            x: z[0],
            v: z[1],
            s: z[2],
            mean: z[3] / h,
        };
        Ok(StepEnd::WHOLE)
    }
}

fmu_export::export_fmu!(Chassis);
