//! The ball of the README, whose bounces accumulate, with and without rest.

use fmu_export::check;
use fmu_export::prelude::*;

macro_rules! ball {
    ($module:ident, $slowest:expr) => {
        mod $module {
            use super::*;

            #[derive(Parameters)]
            pub struct Parameters {
                /// Gravity
                #[fmu(unit = "m/s2", start = 9.81)]
                gravity: f64,
                /// Restitution
                #[fmu(unit = "1", start = 0.7, min = 0.0, max = 1.0)]
                pub restitution: f64,
            }

            /// A ball
            #[derive(State)]
            #[fmu(parameters = Parameters, model_exchange, max_step = 0.01)]
            pub struct Ball {
                /// Height
                #[fmu(unit = "m", start = 1.0)]
                pub height: f64,
                /// Speed
                #[fmu(unit = "m/s")]
                pub speed: f64,
                /// Bounces
                #[fmu(discrete)]
                pub bounces: i32,
                /// Lies on the floor
                #[fmu(discrete)]
                pub rests: bool,
            }

            impl Ode for Ball {
                fn derivative(&self, p: &Parameters, _u: &(), _t: f64, dx: &mut Self) {
                    (dx.height, dx.speed) = if self.rests {
                        (0.0, 0.0)
                    } else {
                        (self.speed, -p.gravity)
                    };
                }
                const INDICATORS: &'static [Variable<Self>] =
                    &[Variable::indicator("impact", "Height above the floor").unit("m")];
                fn indicators(&self, _p: &Parameters, _u: &(), _t: f64, z: &mut [f64]) {
                    z[0] = self.height;
                }
                fn event(&mut self, p: &Parameters, _u: &(), _t: f64) -> Event {
                    if self.height <= 0.0 && self.speed < 0.0 {
                        (self.speed, self.bounces) =
                            (-p.restitution * self.speed, self.bounces + 1);
                        self.rests = self.speed < $slowest;
                    }
                    Event::NONE
                }
            }
        }
    };
}

ball!(rests, 1e-3);
ball!(restless, 0.0);

/// Oracle: bounces until 4.43 m/s · 0.7ⁿ is below 1 mm/s, the last at √(2/g) (1 + 2 Σ 0.7ⁿ), whatever
/// the steps; it never is below the floor.
#[test]
fn a_ball_comes_to_rest_on_the_floor() {
    assert_eq!(check::<rests::Ball>(), [""; 0]);
    for h in [0.01, 0.5, 5.0] {
        let (p, u) = rests::Ball::defaults();
        let mut ball = rests::Ball::initialize(&p, &u, 0.0).unwrap();
        for k in 0..(5.0 / h) as u32 {
            let held = InputPolynomial::held(());
            Model::step(&mut ball, &p, &held, &(), f64::from(k) * h, h).unwrap();
            assert!(ball.height > -1e-12, "{h} {k}: {}", ball.height);
        }
        assert_eq!((ball.bounces, ball.rests), (24, true), "{h}");
        assert!(ball.height.abs() < 1e-12, "{h}: {}", ball.height);
    }
}

#[test]
fn a_ball_without_rest_ends_by_name() {
    for (h, restitution) in [(0.01, 0.7), (0.5, 0.7), (0.5, 0.1)] {
        let (mut p, u) = restless::Ball::defaults();
        p.restitution = restitution;
        let mut ball = restless::Ball::initialize(&p, &u, 0.0).unwrap();
        let error = (0..500).find_map(|k| {
            let held = InputPolynomial::held(());
            let end = Model::step(&mut ball, &p, &held, &(), f64::from(k) * h, h);
            assert!(ball.height > -1e-12, "{h} {k}: {}", ball.height);
            end.err()
        });
        let text = error.expect("events accumulate").to_string();
        let last = 0.451_523_640_985_7 * (1.0 + 2.0 * restitution / (1.0 - restitution));
        let place = format!("t = {}", &last.to_string()[..5]);
        assert!(text.starts_with(&place), "{text} {last}");
        assert!(
            text.contains("event indicator `impact` has changed its sign 1000 times"),
            "{text}"
        );
    }
}
