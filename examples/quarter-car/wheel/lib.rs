//! FMU `Wheel`: the wheel of a quarter car on its tyre, on a road that steps up, and where
//! `road.period` is given also down and up again, under the force of a suspension.
//!
//! ```text
//! m dv/dt = F + F_0 − k (x − road(t))
//! ```
//! Positions are those beside rest, where the suspension carries the load `F_0`. Under a force that is held over a step, or linear in it, the
//! motion is computed exactly, from one edge of the road to the next.

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use serde::{Deserialize, Serialize};

#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    m: f64,
    k: f64,
    x_start: f64,
    height: f64,
    time: f64,
    period: f64,
    load: f64,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    f: f64,
}

#[derive(Clone, Serialize, Deserialize)]
struct Wheel {
    x: f64,
    v: f64,
}

#[derive(Clone, Copy, Default)]
struct Output {
    x: f64,
    v: f64,
}

type V = Variable<Wheel>;
#[rustfmt::skip]
const VARIABLES: &[V] = &[
    V::parameter("m", "mass", |p| &p.m, |p| &mut p.m).unit("kg").min(1e-3),
    V::parameter("k", "stiffness of the tyre", |p| &p.k, |p| &mut p.k).unit("N/m").min(1e-3),
    V::parameter("x_start", "position at the start", |p| &p.x_start, |p| &mut p.x_start).unit("m"),
    V::parameter("road.height", "height of the road's step", |p| &p.height, |p| &mut p.height).unit("m"),
    V::parameter("road.time", "time of the first edge", |p| &p.time, |p| &mut p.time).unit("s"),
    V::parameter("road.period", "time from edge to edge, down and up in turn; 0: one edge", |p| &p.period, |p| &mut p.period).unit("s").min(0.0),
    V::parameter("F_0", "load that the suspension carries at rest", |p| &p.load, |p| &mut p.load).unit("N"),
    V::input("f", "force of the suspension", |u| &u.f, |u| &mut u.f).unit("N"),
    V::output("x", "position", |y| &y.x).unit("m").depends_on(&[]).initially_depends_on(&["x_start"]),
    V::output("v", "velocity", |y| &y.v).unit("m/s").depends_on(&[]).initially_depends_on(&[]),
];

impl Parameters {
    /// Edges of the road up to and at `t`, s.
    fn edges(&self, t: f64) -> f64 {
        match (t >= self.time, self.period > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => 1.0 + ((t - self.time) / self.period).floor(),
        }
    }

    /// Time of the edge after so many, s.
    fn next_edge(&self, edges: f64) -> f64 {
        match edges == 0.0 || self.period > 0.0 {
            true => self.time + edges * self.period,
            false => f64::INFINITY,
        }
    }
}

impl Model for Wheel {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info =
        Info::new("Wheel", "wheel of a quarter car on its tyre").with_input_derivatives();

    fn variables() -> &'static [Variable<Self>] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let p = Parameters {
            m: 40.0,
            k: 150e3,
            x_start: 0.0,
            height: 0.1,
            time: 0.0,
            period: 0.0,
            load: 0.0,
        };
        (p, Input::default())
    }

    fn initialize(p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        Ok(Self {
            x: p.x_start,
            v: 0.0,
        })
    }

    fn output(&self, _p: &Parameters, _u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(Output {
            x: self.x,
            v: self.v,
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
        let (w, f_dot) = ((p.k / p.m).sqrt(), u.derivative(1).f);
        let mut from = 0.0;
        let mut edges = p.edges(t);
        while from < h {
            let to = (p.next_edge(edges) - t).clamp(from, h);
            let road = if edges % 2.0 == 1.0 { p.height } else { 0.0 };
            // Beside the position of rest, which moves with the force.
            let rest = |s: f64| road + (u.at::<Self>(s).f + p.load) / p.k;
            let (x, v) = (self.x - rest(from), self.v - f_dot / p.k);
            let (sin, cos) = (w * (to - from)).sin_cos();
            self.x = rest(to) + x * cos + v / w * sin;
            self.v = f_dot / p.k + v * cos - x * w * sin;
            (from, edges) = (to, edges + 1.0);
        }
        Ok(StepEnd::WHOLE)
    }
}

fmu_export::export_fmu!(Wheel);
