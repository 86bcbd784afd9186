//! A relay that switches by a discrete state: it never leaves its side without an event.

use fmu_export::prelude::*;

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
