//! A mistake in a field of a model is told once: nothing else follows from it.

use fmu_export::prelude::*;

#[derive(Parameters)]
struct Parameters {
    /// Mass
    #[fmu(start = 1.0)]
    mass: f64,
}

#[derive(Input)]
struct Input {
    /// Force
    #[fmu(unit = "furlong")]
    force: f64,
}

#[derive(Output)]
struct Output {
    power: f64,
}

/// A mass
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, solver = "best")]
struct Mass {
    /// Speed
    #[fmu(unit = "m/s", starts = 1.0)]
    speed: f64,
}

impl Ode for Mass {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        *dx = Self { speed: u.force / p.mass };
    }

    fn outputs(&self, _p: &Parameters, u: &Input) -> Output {
        Output { power: u.force * self.speed }
    }
}

export_fmu!(Mass);

#[derive(Parameters)]
struct Nested {
    own: Parameters,
}

#[derive(Clone, Copy, Enumeration)]
enum Mode {
    /// nobody
    Off,
}

#[derive(Input)]
struct Chosen {
    /// Mode
    mode: Choice<Mode>,
}

fn main() {}
