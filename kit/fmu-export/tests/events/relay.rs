//! A relay that switches by a discrete state: it never leaves its side without an event.

use fmu_export::prelude::*;
use fmu_export::{Evaluation, check};

#[derive(Parameters)]
pub struct Parameters {
    /// Speed
    #[fmu(unit = "m/s", start = 1.0)]
    speed: f64,
}

/// A relay
#[derive(State)]
#[fmu(parameters = Parameters, model_exchange, max_step = 0.01)]
pub struct Relay {
    /// Level
    #[fmu(unit = "m", start = -0.2)]
    level: f64,
    /// Falls
    #[fmu(discrete)]
    falls: bool,
    /// Switched
    #[fmu(discrete)]
    switched: i32,
}

impl Ode for Relay {
    fn derivative(&self, p: &Parameters, _u: &(), _t: f64, dx: &mut Self) {
        dx.level = if self.falls { -p.speed } else { p.speed };
    }
    const INDICATORS: &'static [Variable<Self>] =
        &[Variable::indicator("limit", "Level above zero").unit("m")];
    fn indicators(&self, _p: &Parameters, _u: &(), _t: f64, z: &mut [f64]) {
        z[0] = self.level;
    }
    fn event(&mut self, _p: &Parameters, _u: &(), _t: f64) -> Event {
        if self.falls != (self.level > 0.0) {
            (self.falls, self.switched) = (!self.falls, self.switched + 1);
        }
        Event::NONE
    }
}

/// It slides along zero from 0.2 s on, which no number of events ends.
#[test]
fn a_relay_without_hysteresis_ends_by_name() {
    let (p, u) = Relay::defaults();
    let mut relay = Relay::initialize(&p, &u, 0.0).unwrap();
    let held = InputPolynomial::held(());
    let mut step = |k: u32| Model::step(&mut relay, &p, &held, &(), 0.1 * f64::from(k), 0.1);
    let ended = (0..5).find_map(|k| step(k).err().map(|error| (k, error.to_string())));
    let (k, error) = ended.expect("it slides");
    assert!(k == 1 || k == 2, "{k}: {error}");
    assert!(
        error.contains("event indicator `limit`") && error.contains("accumulate"),
        "{error}"
    );
    assert!(
        relay.level.abs() < 0.11 && relay.switched <= 1,
        "{}",
        relay.level
    );
}

macro_rules! falls {
    ($name:ident, [$($row:expr),*], |$t:ident, $x:ident, $z:ident| $write:expr) => {
        /// Falls from 1 m at 1 m/s
        #[derive(State)]
        #[fmu(parameters = (), model_exchange)]
        struct $name {
            /// Height
            #[fmu(unit = "m", start = 1.0)]
            x: f64,
            /// Events
            #[fmu(discrete)]
            count: i32,
        }

        impl Ode for $name {
            fn derivative(&self, _p: &(), _u: &(), _t: f64, dx: &mut Self) {
                dx.x = -1.0;
            }
            const INDICATORS: &'static [Variable<Self>] =
                &[$(Variable::indicator($row, "An indicator").unit("m")),*];
            fn indicators(&self, _p: &(), _u: &(), $t: f64, $z: &mut [f64]) {
                let $x = self.x;
                $write
            }
            fn event(&mut self, _p: &(), _u: &(), t: f64) -> Event {
                self.count += i32::from(t > 0.0);
                Event::NONE
            }
        }
    };
}

falls! { Undefined, ["first", "second"], |t, x, z| (z[0], z[1]) = (x, if t > 0.55 { f64::NAN } else { 1.0 }) }
falls! { Infinite, ["first", "second"], |t, x, z| (z[0], z[1]) = (x, if t > 0.55 { f64::NEG_INFINITY } else { -1.0 }) }
falls! { Forgetful, ["first", "second"], |_t, x, z| z[0] = x }
falls! { Rowless, [], |_t, x, z| z[0] = x }

/// What the step from 0 to 2 s and `check` say of a model; the state must be as before.
fn said<M: Model<Parameters = (), Input = ()>>(x: fn(&M) -> (f64, i32)) -> (String, Vec<String>) {
    let mut model = M::initialize(&(), &(), 0.0).unwrap();
    let held = InputPolynomial::held(());
    let now = M::Evaluation::new(&model, &(), &()).unwrap();
    let error = Model::step(&mut model, &(), &held, &now, 0.0, 2.0).err();
    assert!(error.is_none() || x(&model) == (1.0, 0));
    (
        error.map_or(String::new(), |error| error.to_string()),
        check::<M>(),
    )
}

/// A sign of what is no number would be an event, or hide one.
#[test]
fn indicators_that_are_no_numbers_are_refused_by_name() {
    let (error, problems) = said::<Undefined>(|m| (m.x, m.count));
    assert!(
        error.contains("event indicator `second` became NaN; it must be finite"),
        "{error}"
    );
    assert_eq!(problems, [""; 0]);
    let (error, _) = said::<Infinite>(|m| (m.x, m.count));
    assert!(error.contains("`second` became -inf"), "{error}");
    let (error, problems) = said::<Forgetful>(|m| (m.x, m.count));
    assert!(error.contains("`second` became NaN"), "{error}");
    assert_eq!(problems[0], "event indicator `second` is not written");
}

/// Nothing looks at an indicator without a row.
#[test]
fn indicators_without_rows_are_told() {
    let (_, problems) = said::<Rowless>(|m| (m.x, m.count));
    assert_eq!(
        problems,
        [
            "`fn indicators` writes event indicators, but `const INDICATORS` has none, so their events are never found"
        ]
    );
}
