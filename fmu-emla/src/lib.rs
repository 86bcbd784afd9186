//! FMU `Emla` for co-simulation in FMI 2.0 and 3.0: an electromechanical linear actuator.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it to
//! the `emla` library.
#![allow(non_snake_case)] // the paper's symbols

mod course;
mod model;
mod table;

use actuator_table::Input;
use course::Course;
use emla::Output;
use fmu_export::{Carried, Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use machine::Drive;
pub use model::EmlaFmu;
use model::{Parameters, trip};
use table::{INFO, VARIABLES};

impl Model for EmlaFmu {
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
        let emla = p.actuator()?;
        let rod = Carried::at(&u.x);
        let u = u.now(&rod);
        let state = emla.start_at(&u, p.T_start)?;
        let warning = state.tripped.then(|| trip(&emla, &u, t));
        Ok(Self {
            emla,
            state,
            rod,
            told: false,
            warning,
        })
    }

    fn tune(&mut self, p: &Parameters) -> Result<(), ModelError> {
        self.emla.set_alpha(p.alpha);
        Ok(())
    }

    fn output(&self, _p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(self.emla.output(&self.state, &u.now(&self.rod)))
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let course = Course::new(&self.rod, u);
        let mut state = self.emla.step(&self.state, |s| course.at(s), t, h)?;
        state.shift += course.work_of_shift(&self.emla, &self.state);
        if state.tripped && !self.state.tripped {
            let u = u.value().now(&self.rod);
            self.warning = Some(trip(&self.emla, &u, t));
        }
        if self.emla.drive() == Drive::Motion {
            self.rod = course.end(h)?; // with a free rod `x` counts at the start only
        }
        self.state = state;
        let untrained = self.emla.untrained(&self.state);
        if let Some(point) = untrained.filter(|_| !self.told) {
            self.warning = Some(format!("t = {} s: {point}", t + h));
        }
        self.told = untrained.is_some();
        Ok(StepEnd::WHOLE)
    }

    fn output_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &(),
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok((self.emla).output_dot(&self.state, &u.now(&self.rod), &u_dot.direction()))
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &(),
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok((self.emla).output_along(&self.state, &u.now(&self.rod), &du.direction()))
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warning.take()
    }
}

fmu_export::export_fmu!(EmlaFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Accessors, and dependencies against trying.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<EmlaFmu>(), [""; 0]);
    }
}
