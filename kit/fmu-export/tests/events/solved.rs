//! Models by hand that use a solver of the kit: `solved!`.

use fmu_export::prelude::*;
use fmu_export::{Continuous, ModelExchange, check, row};

macro_rules! ball {
    ($module:ident, $solver:ident $(, $longest:expr)?) => {
        mod $module {
            use super::*;

            /// Falls and bounces, and warms two bodies, one of which cools at once.
            #[derive(Clone, Serialize, Deserialize)]
            pub struct Ball {
                pub height: f64,
                pub speed: f64,
                pub warmth: [f64; 2],
                pub bounces: i32,
            }

            #[derive(Clone, Copy, Default)]
            pub struct Output {
                height: f64,
                speed: f64,
                warmth: [f64; 2],
            }

            type V = Variable<Ball>;

            impl Model for Ball {
                type Parameters = ();
                type Input = ();
                type Output = Output;
                type Evaluation = ();
                const INFO: Info = Info::new("Ball", "ball").with_tolerance(1e-8).with_input_derivatives();
                solved!($solver $(, $longest)?);

                fn variables() -> &'static [V] {
                    const {
                        &[
                            row!(V, output height, "Height").unit("m").depends_on(&[]).initially_depends_on(&[]),
                            row!(V, outputs warmth, "Warmth").unit("K").nominal(10.0).depends_on(&[]).initially_depends_on(&[]),
                            row!(V, output speed, "Speed").unit("m/s").depends_on(&[]).initially_depends_on(&[]),
                        ]
                    }
                }
                fn defaults() -> ((), ()) {
                    ((), ())
                }
                fn initialize(_: &(), _: &(), _: f64) -> Result<Self, ModelError> {
                    Ok(Ball { height: 1.0, speed: 0.0, warmth: [0.0, 1.0], bounces: 0 })
                }
                fn output(&self, _: &(), _: &(), _: &()) -> Result<Output, ModelError> {
                    let &Ball { height, speed, warmth, .. } = self;
                    Ok(Output { height, speed, warmth })
                }
            }

            impl Continuous for Ball {
                fn derivative_rows() -> &'static [V] {
                    const {
                        &[
                            V::derivative_of("height").unit("m/s").depends_on(&["speed"]),
                            V::derivatives_of("warmth").unit("K/s").depends_on(&["warmth[i]", "speed"]),
                            V::derivative_of("speed").unit("m/s2").depends_on(&[]),
                        ]
                    }
                }
                const INDICATORS: &'static [V] = &[V::indicator("impact", "Height above the floor").unit("m")];

                fn states(&self, x: &mut [f64]) {
                    x.copy_from_slice(&[self.height, self.warmth[0], self.warmth[1], self.speed]);
                }
                fn set_states(&mut self, x: &[f64]) {
                    (self.height, self.warmth, self.speed) = (x[0], [x[1], x[2]], x[3]);
                }
                fn derivatives(&self, _: &(), _: &(), _: &(), _: f64, dx: &mut Self) -> Result<(), ModelError> {
                    (dx.height, dx.speed) = (self.speed, -9.81);
                    dx.warmth = [-self.speed, 1e3 * (self.speed - self.warmth[1])];
                    if self.bounces == 9 {
                        dx.warmth[1] = f64::INFINITY;
                    }
                    Ok(())
                }
                fn indicators(&self, _: &(), _: &(), _: &(), _: f64, z: &mut [f64]) -> Result<(), ModelError> {
                    z[0] = self.height;
                    Ok(())
                }
                fn event(&mut self, _: &(), _: &(), _: f64) -> Result<Event, ModelError> {
                    if self.height <= 0.0 && self.speed < 0.0 {
                        (self.speed, self.bounces) = (-0.7 * self.speed, self.bounces + 1);
                    }
                    Ok(Event::NONE)
                }
            }

            /// Oracle: closed form of the second flight; what it warms is what it has fallen, and
            /// what cools at once lags 1 ms behind the speed. Steps err by 1e-6 of 10 K.
            #[test]
            fn a_model_by_hand_has_a_solver() {
                assert_eq!(check::<Ball>(), [""; 0]);
                let mut ball = Ball::initialize(&(), &(), 0.0).unwrap();
                let held = InputPolynomial::held(());
                for k in 0..3 {
                    ball.step(&(), &held, &(), f64::from(k) * 0.25, 0.25).unwrap();
                }
                let (fall, t) = ((2.0_f64 / 9.81).sqrt(), 0.75);
                let up = 0.7 * 9.81 * fall;
                let (height, speed) = (up * (t - fall) - 4.905 * (t - fall) * (t - fall), up - 9.81 * (t - fall));
                assert_eq!(ball.bounces, 1);
                let near = |a: f64, b: f64| assert!((a - b).abs() < 5e-5, "{a} {b}");
                near(ball.height, height);
                near(ball.speed, speed);
                near(ball.warmth[0], 1.0 - height);
                near(ball.warmth[1], speed + 9.81e-3);
            }

            #[test]
            fn its_states_are_named() {
                let mut ball = Ball::initialize(&(), &(), 0.0).unwrap();
                ball.bounces = 9;
                let text = ball.step(&(), &InputPolynomial::held(()), &(), 0.0, 0.25).unwrap_err().to_string();
                assert!(text.contains("`warmth`") || text.contains("error"), "{text}");
            }
        }
    };
}

ball!(fixed, Fixed, 2e-4);
ball!(adaptive, Adaptive);
ball!(stiff, Stiff, 0.1);

#[test]
fn events_are_declared() {
    fn has_events<M: Model>() -> bool {
        let events: Option<ModelExchange<M>> = M::EVENTS;
        events.is_some() && M::MODEL_EXCHANGE.is_none()
    }
    assert!(has_events::<stiff::Ball>());
}
