//! Inputs of the actuator during a step of Co-Simulation, with the rod moving along its polynomial.

use super::model::EmlaFmu;
use actuator_table::{Input, rod_end};
use emla::{Emla, State};
use fmu_export::{ExtrapolatedInput, InputPolynomial, ModelError};
use std::cell::Cell;

/// Inputs over a step.
pub(crate) struct Course<'a> {
    u: &'a InputPolynomial<Input>,
    /// Rod position at the end of the previous step, m.
    from: f64,
    /// Rod position at the start of the step, m.
    start: f64,
    /// Voltage of the DC link, V; None: the machine's.
    v_dc: Option<f64>,
    /// Time derivatives of the rod position there, from the first on.
    derivatives: [f64; 4],
    /// Largest magnitude of the rod position so far, m.
    farthest: Cell<f64>,
}

impl<'a> Course<'a> {
    /// The inputs over a step that begins with this rod.
    pub(crate) fn new(rod: &ExtrapolatedInput<f64>, u: &'a InputPolynomial<Input>) -> Self {
        // The importer's derivatives of x, or those of x_dot if it gives none.
        let derivative = |k| match u.derivative(k).x.value {
            0.0 => u.derivative(k - 1).u.x_dot,
            given => given,
        };
        let now = u.value();
        Self {
            u,
            from: rod.value(),
            start: rod.now(&now.x),
            v_dc: now.v_dc.if_set(),
            derivatives: [1, 2, 3, 4].map(derivative),
            farthest: Cell::new(0.0),
        }
    }

    /// Work on the load by setting the rod elsewhere than the previous step ended, J, in state `s`.
    pub(crate) fn work_of_shift(&self, emla: &Emla, s: &State) -> f64 {
        emla.work_of_shift(s, self.from, self.start)
    }

    /// The inputs `s` seconds into the step.
    pub(crate) fn at(&self, s: f64) -> emla::Input {
        let [v, a, jerk, snap] = self.derivatives;
        let x = self.start + s * (v + s / 2.0 * (a + s / 3.0 * (jerk + s / 4.0 * snap)));
        self.farthest.set(self.farthest.get().max(x.abs()));
        emla::Input {
            x,
            v_dc: self.v_dc,
            ..self.u.at::<EmlaFmu>(s).u
        }
    }

    /// The rod after a step of `h` s; an error if it left the bounds of `x`.
    pub(crate) fn end(&self, h: f64) -> Result<ExtrapolatedInput<f64>, ModelError> {
        let x = self.at(h).x;
        rod_end(&self.u.value().x, x, self.farthest.get())
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::Parameters;
    use super::*;
    use emla::Output;
    use fmu_export::{CountedInput, Model, StepEnd};

    const H: f64 = 1e-3;

    /// The FMU as its importer sees it, without the border.
    struct Actuator {
        parameters: Parameters,
        fmu: EmlaFmu,
    }

    impl Actuator {
        fn new(u: &Input) -> Self {
            let (parameters, _) = EmlaFmu::defaults();
            let fmu = EmlaFmu::initialize(&parameters, u, 0.0).expect("valid defaults");
            Self { parameters, fmu }
        }

        fn step(&mut self, u: &InputPolynomial<Input>, h: f64) -> Result<StepEnd, ModelError> {
            self.fmu.step(&self.parameters, u, &(), 0.0, h)
        }

        fn output(&self, u: &Input) -> Output {
            let output = self.fmu.output(&self.parameters, u, &());
            output.expect("finite")
        }
    }

    /// Inputs after `x` was set so often.
    fn inputs(sets: u32, x: f64, x_dot: f64) -> Input {
        let u = emla::Input {
            v_q: 30.0,
            x_dot,
            F_hold: 9e3,
            ..emla::Input::default()
        };
        Input {
            u,
            x: CountedInput { value: x, sets },
            ..Input::default()
        }
    }

    /// Set once, and set at every communication point to where the velocity has taken the rod: the
    /// same motion. Tolerance: K_b times the rounding of a position that 1000 sums have made.
    #[test]
    fn a_rod_that_is_set_once_moves_on() {
        let once = inputs(1, 0.3, 0.1);
        let (mut a, mut b) = (Actuator::new(&once), Actuator::new(&once));
        for k in 0..1000 {
            let at = |k: u32| inputs(k, 0.3 + f64::from(k) * H * 0.1, 0.1);
            a.step(&InputPolynomial::held(once), H).expect("finite");
            b.step(&InputPolynomial::held(at(k)), H).expect("finite");
            let (of_once, of_each) = (a.output(&once), b.output(&at(k + 1)));
            assert!(
                (of_once.F - of_each.F).abs() < 3e8 * 1000.0 * f64::EPSILON,
                "{k}"
            );
        }
        assert!((a.output(&once).x_rod - 0.4).abs() < 1e-12);
    }

    /// A value that is set takes effect at once, also one that was set before, and the rod moves on
    /// from there.
    #[test]
    fn a_value_that_is_set_takes_effect() {
        let first = inputs(1, 0.3, 0.1);
        let mut actuator = Actuator::new(&first);
        actuator
            .step(&InputPolynomial::held(first), H)
            .expect("finite");
        assert_eq!(actuator.output(&first).x_rod, 0.3 + H * 0.1);
        assert_eq!(actuator.output(&inputs(2, 0.3, 0.1)).x_rod, 0.3);
        let other = inputs(2, 0.2, 0.1);
        assert_eq!(actuator.output(&other).x_rod, 0.2);
        actuator
            .step(&InputPolynomial::held(other), H)
            .expect("finite");
        assert_eq!(actuator.output(&other).x_rod, 0.2 + H * 0.1);
    }

    /// x(s) is the Taylor polynomial of the derivatives of x, and of those of x_dot where x has
    /// none.
    #[test]
    fn derivatives_of_both_inputs_count() {
        let of = |x: f64, x_dot: f64| Input {
            u: emla::Input {
                x_dot,
                ..emla::Input::default()
            },
            x: CountedInput::new(x),
            ..Input::default()
        };
        let value = of(0.3, 0.02);
        let s: f64 = 0.5;
        let (a, jerk, snap) = (0.4, -1.1, 2.3);
        let expected =
            0.3 + 0.02 * s + a * s.powi(2) / 2.0 + jerk * s.powi(3) / 6.0 + snap * s.powi(4) / 24.0;
        for derivatives in [
            [of(0.0, a), of(0.0, jerk), of(0.0, snap)],
            [of(0.02, a), of(0.0, jerk), of(0.0, snap)],
            [of(0.02, 7.0), of(a, jerk), of(0.0, snap)],
            [of(0.02, 7.0), of(a, 8.0), of(jerk, snap)],
        ] {
            let u = InputPolynomial::with_derivatives(value, &derivatives);
            let x = Course::new(&ExtrapolatedInput::from_input(&value.x), &u)
                .at(s)
                .x;
            assert!(
                (x - expected).abs() < 1e-15,
                "{derivatives:?}: {x}, {expected}"
            );
        }
    }

    /// Until the link's voltage is set, that of the parameters counts; then the one that was set,
    /// also 0.
    #[test]
    fn a_link_voltage_counts_once_it_is_set() {
        let unset = inputs(1, 0.3, 0.1);
        let actuator = Actuator::new(&unset);
        let y = actuator.output(&unset);
        assert!((y.P_in / y.i_dc - 650.0).abs() < 1e-9);
        let set = |value: f64| Input {
            v_dc: CountedInput { value, sets: 1 },
            ..unset
        };
        let y = actuator.output(&set(432.1));
        assert!((y.P_in / y.i_dc - 432.1).abs() < 1e-9);
        assert_eq!(actuator.output(&set(0.0)).i_dc, 0.0);
    }

    /// The bounds of `x` hold inside a step, also where the rod comes back before its end.
    #[test]
    fn the_rod_stays_within_the_bounds_of_x() {
        let mut actuator = Actuator::new(&inputs(0, 9.9, 0.0));
        let away = InputPolynomial::held(inputs(0, 9.9, 90.0));
        let text = actuator.step(&away, 2e-3).expect_err("beyond").to_string();
        assert!(
            text.contains("10.08") && text.contains("within 10 m"),
            "{text}"
        );
        let turn = Input {
            u: emla::Input {
                x_dot: -2.0 * 90.0 / 2e-3,
                ..emla::Input::default()
            },
            ..Input::default()
        };
        let back = InputPolynomial::with_derivatives(inputs(1, 9.96, 90.0), &[turn]);
        let text = actuator.step(&back, 2e-3).expect_err("10.005 m");
        assert!(text.to_string().contains("10.00"), "{text}");
        assert!(actuator.step(&away, 1e-3).is_ok(), "9.99 m is within");
        let bound = inputs(2, 10.0, 0.0);
        let held = InputPolynomial::held(bound);
        assert!(Actuator::new(&bound).step(&held, H).is_ok(), "10 m is too");
    }
}
