//! FMU `Rig` for Co-Simulation in FMI 2.0 and 3.0: the linear actuator in detail, "as built", for
//! the systems `Real.ssd` and `RigTestbed.ssd` and for any importer. This file connects the table
//! of variables (`table`) to the `rig` library.
#![allow(non_snake_case)] // the paper's symbols

mod model;
mod table;

use actuator_table::{Input, rod_end};
use fmu_export::{ExtrapolatedInput, Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use machine_file::Drive;
use model::{Parameters, RigFmu, trip};
use rig::Output;
use table::{INFO, VARIABLES};

impl Model for RigFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = INFO;

    fn variables() -> &'static [Variable<Self>] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let parameters = Parameters::reference();
        let input = Input::unset(&parameters.of_machine);
        (parameters, input)
    }

    fn initialize(p: &Parameters, u: &Input, t: f64) -> Result<Self, ModelError> {
        let (rig, rod) = (p.actuator()?, ExtrapolatedInput::from_input(&u.x));
        let u = u.now(&rod);
        let state = rig.start(&u, p.T_start)?;
        let warning = state.tripped.then(|| trip(&rig, &u, t));
        Ok(Self {
            rig,
            state,
            rod,
            warning,
        })
    }

    fn output(&self, _p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(self.rig.output(&self.state, &u.now(&self.rod)))
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let now = u.value().now(&self.rod);
        let mut state = self.rig.step(&self.state, &now, t, h)?;
        state.shift += self.rig.work_of_shift(&self.state, self.rod.value(), now.x);
        if state.tripped && !self.state.tripped {
            self.warning = Some(trip(&self.rig, &now, t));
        }
        if self.rig.drive() == Drive::Motion {
            let x = now.moved(h).x;
            self.rod = rod_end(&u.value().x, x, x.abs())?; // with a free rod `x` counts at the start only
        }
        self.state = state;
        Ok(StepEnd::WHOLE)
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warning.take()
    }
}

#[cfg(not(test))] // tests need no C functions, which take longest to compile
fmu_export::export_fmu!(RigFmu);

#[cfg(test)]
mod tests {
    use super::*;
    use fmu_export::CountedInput;

    /// Every accessor works, and the declared dependencies are those found by varying the inputs.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<RigFmu>(), [""; 0]);
    }

    /// Set once, and set at every communication point to where the velocity has taken the rod: the
    /// same motion, to the rounding of a position that 1000 sums have made. Beyond the bounds of
    /// `x` a step is refused and changes nothing.
    #[test]
    fn a_rod_that_is_set_once_moves_on() {
        let (parameters, defaults) = RigFmu::defaults();
        let at = |sets: u32, value: f64| Input {
            u: rig::Input {
                x_dot: 0.1,
                v_q: 30.0,
                ..defaults.u
            },
            x: CountedInput { value, sets },
            ..defaults
        };
        let start = at(0, 0.3);
        let fmu = RigFmu::initialize(&parameters, &start, 0.0).expect("valid");
        let (mut once, mut each) = (fmu.clone(), fmu);
        let step = |fmu: &mut RigFmu, u: Input| {
            fmu.step(&parameters, &InputPolynomial::held(u), &(), 0.0, 1e-3)
        };
        for k in 0..1000 {
            step(&mut once, start).expect("within");
            step(&mut each, at(k, 0.3 + f64::from(k) * 1e-4)).expect("within");
            let of = |fmu: &RigFmu, u| fmu.output(&parameters, &u, &()).expect("finite").F;
            let difference = of(&once, start) - of(&each, at(k + 1, 0.3 + f64::from(k + 1) * 1e-4));
            assert!(difference.abs() < 1e-4, "{k}: {difference}");
        }
        let before = once.state;
        let beyond = step(&mut once, at(7, 9.99995)).expect_err("beyond 10 m");
        assert!(beyond.to_string().contains("10.0000"), "{beyond}");
        assert_eq!(once.state, before);
    }
}
