//! FMU `Oscillator`, an example for authors of models and for tests, with a handwritten table: the
//! table of variables, and `impl Model` and `impl Continuous` for the model in `oscillator`.

mod oscillator;

use fmu_export::{
    Continuous, Enumeration, File, Info, InputPolynomial, Model, ModelError, ModelExchange,
    StepEnd, Variable,
};
use oscillator::{Parameters, State, advance};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The model's state is the FMU's state.
#[derive(Clone, Serialize, Deserialize)]
pub struct Oscillator(State);

/// The forces on the mass.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct Input {
    force: [f64; 2],
}

/// The outputs.
#[derive(Clone, Copy, Default)]
pub struct Output {
    x: [f64; 2],
    v: [f64; 2],
    a: [f64; 2],
    energy: f64,
    at_rest: bool,
}

const SPRING: Enumeration = Enumeration::new(
    "Spring",
    "Law of the springs",
    &[
        ("linear", "force k x"),
        ("hardening", "force k x (1 + (x/x_h)^2)"),
    ],
);

const NONE: &[&str] = &[];
const START: &[&str] = &["x_start[i]"];

type V = Variable<Oscillator>;

#[rustfmt::skip]
const VARIABLES: &[V] = &[
    //            name         description                                   where it lives
    V::parameter ("m",         "Mass",                                       |p| &p.m,       |p| &mut p.m).unit("kg").min(1e-3),
    V::parameter ("d",         "Damping",                                    |p| &p.d,       |p| &mut p.d).unit("N.s/m").min(0.0).tunable(),
    V::parameter ("k",         "Stiffness",                                  |p| &p.k,       |p| &mut p.k).unit("N/m").display_unit("N/mm").min(1e-3),
    V::parameter ("x_h",       "Deflection that doubles a hardening force",  |p| &p.x_h,     |p| &mut p.x_h).unit("m").display_unit("mm").min(1e-3),
    V::parameters("x_start",   "Position at the start",                      |p| &p.x_start, |p| &mut p.x_start).unit("m").display_unit("mm"),
    V::integer_parameter("spring", "Law of the springs",                     |p| &p.spring,  |p| &mut p.spring).enumeration(&SPRING),
    V::string_parameter("parameter_file", "File with lines `name = value` to use instead of the built-in m, d, k", |p| &p.file, read_file),
    V::inputs    ("F",         "Force on the mass along each axis",          |u| &u.force,   |u| &mut u.force).unit("N").nominal(10.0),
    V::outputs   ("x",         "Position",                                   |y| &y.x).unit("m").display_unit("mm").depends_on(NONE).initially_depends_on(START),
    V::outputs   ("v",         "Velocity",                                   |y| &y.v).unit("m/s").depends_on(NONE).initially_depends_on(NONE),
    V::outputs   ("a",         "Acceleration",                               |y| &y.a).unit("m/s2").depends_on(&["F[i]", "x[i]", "v[i]"])
                 .initially_depends_on(&["F[i]", "x_start[i]", "m", "k", "x_h", "spring"]),
    V::output    ("energy",    "Kinetic and potential energy",               |y| &y.energy).unit("J").depends_on(&["x", "v"])
                 .initially_depends_on(&["x_start", "k", "x_h", "spring"]),
    V::boolean_output("at_rest", "Whether the mass stands still",            |y| &y.at_rest).depends_on(&["v"]).initially_depends_on(NONE),
];

/// The rows of the derivatives, for Model Exchange.
#[rustfmt::skip]
const DERIVATIVES: &[V] = &[
    V::derivatives_of("x").unit("m/s").depends_on(&["v[i]"]),
    V::derivatives_of("v").unit("m/s2").depends_on(&["x[i]", "v[i]", "F[i]"]),
];

/// Reads `name = value` lines; a relative path is looked up in the FMU's `resources` folder.
fn read_file(p: &mut Parameters, path: &str, resources: Option<&Path>) -> Result<(), String> {
    p.file = path.to_owned();
    if path.is_empty() {
        return Ok(());
    }
    let path = resources.unwrap_or(Path::new("")).join(path);
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let (name, value) = line
            .split_once('=')
            .ok_or(format!("`{line}` is no `name = value`"))?;
        let value: f64 = value.trim().parse().map_err(|e| format!("`{line}`: {e}"))?;
        match name.trim() {
            name @ ("m" | "d" | "k") if !(value.is_finite() && value > 0.0) => {
                return Err(format!("{name} = {value} must be finite and > 0"));
            }
            "m" => p.m = value,
            "d" => p.d = value,
            "k" => p.k = value,
            name => return Err(format!("unknown name `{name}`; it must be m, d or k")),
        }
    }
    Ok(())
}

impl Oscillator {
    /// The acceleration of each axis under a force.
    fn accelerations(&self, p: &Parameters, force: [f64; 2]) -> [f64; 2] {
        let State { x, v } = self.0;
        [0, 1].map(|i| p.acceleration(x[i], v[i], force[i]))
    }
}

impl Model for Oscillator {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();

    const INFO: Info = Info::new("Oscillator", "A mass in a plane on springs and dampers")
        .version(env!("CARGO_PKG_VERSION"))
        .license(env!("CARGO_PKG_LICENSE"))
        .experiment(0.0, 5.0, 0.01)
        .documentation(&[File {
            path: "index.html",
            bytes: include_bytes!("../index.html"),
        }])
        .resources(&[File {
            path: "heavy.txt",
            bytes: include_bytes!("../resources/heavy.txt"),
        }])
        .with_input_derivatives()
        .with_output_derivatives()
        .with_directional_derivatives();

    const MODEL_EXCHANGE: Option<ModelExchange<Self>> = ModelExchange::from_continuous();

    fn variables() -> &'static [V] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let x_start = [0.1, 0.0];
        let file = String::new();
        let p = Parameters {
            m: 2.0,
            d: 1.5,
            k: 80.0,
            x_h: 0.2,
            spring: 1,
            x_start,
            file,
        };
        (p, Input::default())
    }

    fn initialize(p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        Ok(Self(State {
            x: p.x_start,
            v: [0.0; 2],
        }))
    }

    fn output(&self, p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        let s = &self.0;
        let a = self.accelerations(p, u.force);
        Ok(Output {
            x: s.x,
            v: s.v,
            a,
            energy: p.energy(s),
            at_rest: s.v == [0.0; 2],
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
        let s = advance(p, self.0, h, |s| u.at::<Self>(s).force);
        let finite = s.x.iter().chain(&s.v).all(|value| value.is_finite());
        if !finite {
            return Err(ModelError::new(format!(
                "t = {t} s: the motion became infinite: {s:?}"
            )));
        }
        self.0 = s;
        Ok(StepEnd::WHOLE)
    }

    /// d/dt of each output: x' = v, v' = a, a' = (F' − d a − k'(x) v)/m, energy' = (F − d v)·v.
    fn output_derivative(
        &self,
        p: &Parameters,
        u: &Input,
        _now: &(),
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        let State { x, v } = self.0;
        let a = self.accelerations(p, u.force);
        let jerk =
            [0, 1].map(|i| (u_dot.force[i] - p.d * a[i] - p.spring_force(x[i]).1 * v[i]) / p.m);
        let power = (0..2).map(|i| (u.force[i] - p.d * v[i]) * v[i]).sum();
        Ok(Output {
            x: v,
            v: a,
            a: jerk,
            energy: power,
            at_rest: false,
        })
    }

    /// Only the acceleration depends on the force directly: ∂a/∂F = 1/m.
    fn directional_derivative(
        &self,
        p: &Parameters,
        _u: &Input,
        _now: &(),
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok(Output {
            a: du.force.map(|f| f / p.m),
            ..Output::default()
        })
    }
}

impl Continuous for Oscillator {
    const HAS_DIRECTIONAL: bool = true;

    fn derivative_rows() -> &'static [V] {
        DERIVATIVES
    }

    fn states(&self, x: &mut [f64]) {
        x[..2].copy_from_slice(&self.0.x);
        x[2..].copy_from_slice(&self.0.v);
    }

    fn set_states(&mut self, x: &[f64]) {
        self.0.x.copy_from_slice(&x[..2]);
        self.0.v.copy_from_slice(&x[2..]);
    }

    fn derivatives(
        &self,
        p: &Parameters,
        u: &Input,
        _now: &(),
        _t: f64,
        dx: &mut Self,
    ) -> Result<(), ModelError> {
        let (x, v) = (self.0.v, self.accelerations(p, u.force));
        dx.0 = State { x, v };
        Ok(())
    }

    /// a = (F − d v − f(x))/m changes by (dF − d dv − f'(x) dx)/m, the energy by f(x) dx + m v dv.
    fn directional(
        &self,
        p: &Parameters,
        _u: &Input,
        _now: &(),
        _t: f64,
        (Self(seed), du): (&Self, &Input),
        dx: &mut Self,
        y: Option<&mut Output>,
    ) -> Result<(), ModelError> {
        let State { x, v } = self.0;
        let spring = [0, 1].map(|i| p.spring_force(x[i]));
        let a = [0, 1].map(|i| (du.force[i] - p.d * seed.v[i] - spring[i].1 * seed.x[i]) / p.m);
        dx.0 = State { x: seed.v, v: a };
        let Some(y) = y else { return Ok(()) };
        let work = (0..2)
            .map(|i| spring[i].0 * seed.x[i] + p.m * v[i] * seed.v[i])
            .sum();
        *y = Output {
            x: seed.x,
            v: seed.v,
            a,
            energy: work,
            at_rest: false,
        };
        Ok(())
    }
}

fmu_export::export_fmu!(Oscillator);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order() {
        fmu_export::model_description::<Oscillator>().unwrap();
    }

    /// Oracle: a central difference of the outputs over ±e. Its error is e²/6 of the third
    /// derivative, here ≤ (k/m)^1.5 times the value ≈ 2e3, plus rounding 1e-16/e times the value.
    #[test]
    fn output_derivatives_are_the_slopes() {
        let (mut p, _) = Oscillator::defaults();
        p.spring = 2;
        let (u, u_dot, e) = (
            Input { force: [3.0, -4.0] },
            Input {
                force: [50.0, 70.0],
            },
            1e-4,
        );
        let middle = Oscillator(State {
            x: [0.15, -0.22],
            v: [0.7, 0.4],
        });
        let at = |h: f64| {
            // Backwards in time is forwards with reversed velocity, damping and slope of the force.
            let s = if h > 0.0 {
                advance(&p, middle.0, h, |s| {
                    [0, 1].map(|i| u.force[i] + u_dot.force[i] * s)
                })
            } else {
                let reversed = Parameters {
                    d: -p.d,
                    ..p.clone()
                };
                let start = State {
                    v: middle.0.v.map(|v| -v),
                    ..middle.0
                };
                let s = advance(&reversed, start, -h, |s| {
                    [0, 1].map(|i| u.force[i] - u_dot.force[i] * s)
                });
                State {
                    v: s.v.map(|v| -v),
                    ..s
                }
            };
            let force = [0, 1].map(|i| u.force[i] + u_dot.force[i] * h);
            let y = Oscillator(s).output(&p, &Input { force }, &()).unwrap();
            [y.x[0], y.x[1], y.v[0], y.v[1], y.a[0], y.a[1], y.energy]
        };
        let y = middle.output_derivative(&p, &u, &(), &u_dot).unwrap();
        let analytic = [y.x[0], y.x[1], y.v[0], y.v[1], y.a[0], y.a[1], y.energy];
        for ((after, before), analytic) in at(e).into_iter().zip(at(-e)).zip(analytic) {
            let slope = (after - before) / (2.0 * e);
            assert!(
                (slope - analytic).abs() < 1e-4 * analytic.abs().max(1.0),
                "{slope} {analytic}"
            );
        }
    }

    #[test]
    fn parameter_files_say_what_is_wrong_with_them() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/resources"));
        let (mut p, _) = Oscillator::defaults();
        read_file(&mut p, "heavy.txt", Some(folder)).unwrap();
        assert_eq!((p.m, p.d, p.k), (20.0, 4.5, 80.0));
        let error = read_file(&mut p, "none.txt", Some(folder)).unwrap_err();
        assert!(
            error.contains("none.txt") && error.contains(folder.to_str().unwrap()),
            "{error}"
        );
    }

    /// Accessors and dependencies agree with those that running the model shows.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<Oscillator>(), [""; 0]);
    }
}
