//! Each mistake that `check` promises to find is found, by name.

use fmu_export::{Evaluation, Info, InputPolynomial, Model, ModelError, StepEnd, Variable, check};
use serde::{Deserialize, Serialize};

/// x' = u₁ + w, y = x + gain·u₂, with the `K`-th table.
#[derive(Clone, Serialize, Deserialize)]
struct Tried<const K: usize> {
    x: f64,
}

#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    gain: f64,
    start: f64,
    count: i32,
    law: bool,
    many: [f64; 2],
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    u: [f64; 2],
    w: f64,
    on: bool,
}

#[derive(Clone, Copy, Default)]
struct Output {
    x: f64,
    y: f64,
    constant: f64,
    zero: f64,
    on: bool,
}

/// The state times two; with the tables 12 to 14 it follows w, too, which the 12th declares to be
/// beside it.
struct Now(f64);

impl<const K: usize> Evaluation<Tried<K>> for Now {
    fn new(model: &Tried<K>, _p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        Ok(Now(
            2.0 * model.x + if matches!(K, 12..=14) { u.w } else { 0.0 }
        ))
    }
}

type V<const K: usize> = Variable<Tried<K>>;

macro_rules! rows {
    ($($name:ident $row:expr;)*) => { $(const fn $name<const K: usize>() -> V<K> { $row })* };
}

#[rustfmt::skip]
rows! {
    gain  V::parameter("gain", "a factor", |p| &p.gain, |p| &mut p.gain).min(0.0);
    start V::parameter("start", "of x", |p| &p.start, |p| &mut p.start);
    count V::integer_parameter("count", "a number", |p| &p.count, |p| &mut p.count);
    law   V::boolean_parameter("law", "a flag", |p| &p.law, |p| &mut p.law);
    many  V::parameters("many", "two", |p| &p.many, |p| &mut p.many);
    u     V::inputs("u", "two", |u| &u.u, |u| &mut u.u);
    w     V::input("w", "one", |u| &u.w, |u| &mut u.w).not_in_evaluation();
    on    V::boolean_input("on", "a switch", |u| &u.on, |u| &mut u.on).not_in_evaluation();
    x     V::output("x", "the state", |y| &y.x).depends_on(&[]).initially_depends_on(&["start"]);
    y     V::output("y", "with feedthrough", |y| &y.y).depends_on(&["u[2]"]).initially_depends_on(&["u[2]", "start", "gain"]);
    is_on V::boolean_output("is_on", "the switch", |y| &y.on).depends_on(&["on"]).initially_depends_on(&["on"]);
}

#[rustfmt::skip]
macro_rules! tables {
    ($($k:literal $rows:expr, $said:expr;)*) => {
        impl<const K: usize> Tried<K> {
            fn table() -> &'static [V<K>] {
                match K {
                    $($k => const { &$rows },)*
                    _ => &[],
                }
            }
        }

        #[test]
        fn each_mistake_is_found() {
            $(assert_eq!(check::<Tried<$k>>(), $said as &[&str], "table {}", $k);)*
        }
    };
}

#[rustfmt::skip]
tables! {
    0  [gain(), start(), count(), law(), many(), u(), w(), on(), x(), y(), is_on()], &[];
    1  [gain(), start(), V::parameter("z", "a setter of another field", |p| &p.many[0], |p| &mut p.many[1])],
       &["`z`: its accessors are of different fields"];
    2  [gain(), start(), V::parameter("z", "a field used twice", |p| &p.gain, |p| &mut p.gain)], &["`gain` and `z` share a field"];
    3  [count(), V::integer_parameter("z", "a setter of another row", |p| &p.count, |p| &mut p.count)], &["`count` and `z` share a field"];
    4  [u(), V::input("z", "an element of a vector", |u| &u.u[1], |u| &mut u.u[1])], &["`u[2]` and `z` share a field"];
    5  [on(), V::boolean_input("z", "a flag used twice", |u| &u.on, |u| &mut u.on)], &["`on` and `z` share a field"];
    6  [gain(), start(), u(), y(), V::output("x", "an output of the wrong field", |y| &y.y).depends_on(&[]).initially_depends_on(&["start"])],
       &["`y` and `x` share a field"];
    7  [gain(), start(), u(), V::output("x", "an output of the wrong field", |y| &y.y).depends_on(&[]).initially_depends_on(&["start"])],
       &["`x` depends initially on `gain`, which it does not declare",
         "`x` depends initially on `u[2]`, which it does not declare",
         "`x` depends on `u[2]`, which it does not declare"];
    8  [gain(), start(), u(), V::output("y", "too few", |y| &y.y).depends_on(&["u[1]"]).initially_depends_on(&["u", "start", "gain"])],
       &["`y` depends on `u[2]`, which it does not declare"];
    9  [gain(), start(), u(), V::output("y", "too few", |y| &y.y).depends_on(&["u[2]"]).initially_depends_on(&["u[2]", "start"])],
       &["`y` depends initially on `gain`, which it does not declare"];
    10 [on(), V::boolean_output("is_on", "too few", |y| &y.on).depends_on(&[]).initially_depends_on(&["on"])],
       &["`is_on` depends on `on`, which it does not declare"];
    11 [V::parameters("many", "vectors of different fields", |p| &p.many, |p| std::slice::from_mut(&mut p.gain))],
       &["`many[1]`: its accessors are of different fields", "`many[2]`: its accessors are of different fields"];
    12 [gain(), start(), u(), w(), x()], &["`w`: the evaluation depends on it, but it is declared `not_in_evaluation`",
       "`x` depends initially on `w`, which it does not declare", "`x` depends on `w`, which it does not declare"];
    13 [gain(), start(), u(), V::input("w", "may fall a little", |u| &u.w, |u| &mut u.w).min(-1.5e-6).max(0.0), x()],
       &["`x` depends initially on `w`, which it does not declare", "`x` depends on `w`, which it does not declare"];
    14 [gain(), start(), u(), V::input("w", "may rise a little", |u| &u.w, |u| &mut u.w).min(0.0).max(1.5e-6), x()],
       &["`x` depends initially on `w`, which it does not declare", "`x` depends on `w`, which it does not declare"];
    15 [u().unit("furlong")], &["variable `u[1]`: unit `furlong` is no expression of units such as `m3/(s.Pa)`, and not in Info::units"];
    16 [gain(), start(), u(), w(), x(), y()], &[];
    17 [gain(), start(), u(), y()],
       &["the directional derivative of `y` by `u[1]` is 1.0000e-3, differences of the output give 0.0000e0"];
    18 [gain(), start(), u(), y()], 
       &["the directional derivative u·(J v) = 4.3940 must be v·(J' u) = 3.3800 by its own columns",
         "the directional derivative u·(J v) = 4.3940 must be v·(J' u) = 3.3800 by the adjoint derivative"];
    19 [gain(), start(), u(), y()], &["derivatives: there are none"];
    20 [gain(), start(), u(), V::calculated_parameter("c", "the state", |y| &y.x).initially_depends_on(&["start"])],
       &["`c` changes in a step, but is a Real calculated parameter"];
    21 [gain(), start(), u(), V::calculated_parameter("c", "of an input", |y| &y.y).initially_depends_on(&["start", "gain"])],
       &["`c` changes in a step, but is a Real calculated parameter", "`c` depends on `u[2]`, but is a Real calculated parameter"];
    22 [gain(), start(), u(), V::constant("c", "the state", |y| &y.x)],
       &["`c` changes in a step, but is a Real constant", "`c` depends on `start`, but is a Real constant"];
    23 [gain(), start(), u(), V::calculated_parameter("c", "too few", |y| &y.constant).initially_depends_on(&["start"])],
       &["`c` depends initially on `gain`, which it does not declare"];
    24 [gain(), start(), V::calculated_parameter("c", "twice gain", |y| &y.constant).initially_depends_on(&["gain"]), V::constant("g", "a number", |_| &2.5)], &[];
    25 [gain(), start()], &["initialize with the start values: there is no start"];
    26 [gain(), V::output("y", "nowhere", |y| &y.y)], &["`y` = NaN with the start values must be finite"];
    27 [gain()], &["step with the start values: there is no way"];
    28 [gain()], &["output_derivative with the start values: output_derivative is not implemented"];
    29 [gain()], &["default experiment: start = 1 s, stop = 1 s, step = 0.1 s must be finite, with stop > start and step > 0"];
    30 [gain()], &["log category `logAll` is declared twice, or is a standard category"];
    31 [gain(), start(), u(), V::output("zero", "always", |y| &y.zero).depends_on(&["u"]).initially_depends_on(&[])], &[];
}

impl<const K: usize> Model for Tried<K> {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = Now;
    const INFO: Info = {
        let info = Info::new("Tried", "tables to be tried");
        match K {
            16..20 | 31 => info.with_directional_derivatives(),
            28 => info.with_output_derivatives(),
            29 => info.experiment(1.0, 1.0, 0.1),
            30 => info.log_categories(&[("logAll", "not mine")]),
            _ => info,
        }
    };

    fn variables() -> &'static [V<K>] {
        Self::table()
    }

    fn defaults() -> (Parameters, Input) {
        let parameters = Parameters {
            gain: 2.0,
            start: 1.5,
            count: 3,
            law: false,
            many: [0.5, 0.75],
        };
        // Not zero, where a product hides its other factor.
        let input = Input {
            u: [0.25, -0.5],
            ..Input::default()
        };
        (parameters, input)
    }

    fn initialize(p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        if K == 25 {
            return Err(ModelError::new("there is no start"));
        }
        Ok(Self { x: p.start })
    }

    fn output(&self, p: &Parameters, u: &Input, now: &Now) -> Result<Output, ModelError> {
        Ok(Output {
            x: now.0 / 2.0,
            y: match K {
                26 => f64::NAN,
                _ => self.x + p.gain * u.u[1],
            },
            constant: 2.0 * p.gain,
            zero: 0.0,
            on: u.on,
        })
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &Now,
        _t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        if K == 27 {
            return Err(ModelError::new("there is no way"));
        }
        let u = u.value();
        self.x += h * (u.u[0] + u.w);
        Ok(StepEnd::WHOLE)
    }

    fn directional_derivative(
        &self,
        p: &Parameters,
        _u: &Input,
        _now: &Now,
        du: &Input,
    ) -> Result<Output, ModelError> {
        let y = p.gain * du.u[1];
        let y = match K {
            17 => y + 1e-3 * du.u[0],
            18 => y * du.u[1],
            19 => return Err(ModelError::new("there are none")),
            _ => y,
        };
        Ok(Output {
            y,
            ..Output::default()
        })
    }
}
