//! FMU `Emla` for Co-Simulation and Model Exchange in FMI 2.0 and 3.0: an electromechanical linear
//! actuator, for systems in `system` and for any importer.
//!
//! This file connects the table of variables (`table`) to the `emla` library.
#![allow(non_snake_case)] // the paper's symbols

mod course;
mod model;
mod table;

use actuator_table::Input;
use course::Course;
use emla::Output;
use fmu_export::{
    Continuous, Event, ExtrapolatedInput, Info, InputPolynomial, Model, ModelError, ModelExchange,
    StepEnd, Variable,
};
use machine_file::Drive;
pub use model::EmlaFmu;
use model::{Parameters, trip};
use table::{DERIVATIVES, INDICATORS, INFO, VARIABLES};

impl Model for EmlaFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = INFO;
    const MODEL_EXCHANGE: Option<ModelExchange<Self>> = ModelExchange::from_continuous();

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
        let rod = ExtrapolatedInput::from_input(&u.x);
        let u = u.now(&rod);
        let state = emla.start_at(&u, p.T_start)?;
        let warning = state.tripped.then(|| trip(&emla, &u, t));
        Ok(Self {
            emla,
            state,
            rod,
            slip: 0.0,
            closes: None,
            untrained_reported: false,
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
        let begun = u.value().now(&self.rod);
        if self.emla.drive() == Drive::Motion {
            self.rod = course.end(h)?; // with a free rod `x` counts at the start only
        }
        self.become_state(state, t + h, |emla| trip(emla, &begun, t));
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

impl Continuous for EmlaFmu {
    const INDICATORS: &'static [Variable<Self>] = INDICATORS;
    const HAS_DIRECTIONAL: bool = true;

    fn derivative_rows() -> &'static [Variable<Self>] {
        DERIVATIVES
    }

    fn states(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.state.moving());
    }

    fn set_states(&mut self, x: &[f64]) {
        self.state.set_moving(x);
    }

    fn derivatives(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &(),
        _t: f64,
        dx: &mut Self,
    ) -> Result<(), ModelError> {
        dx.state = (self.emla).derivative(&self.state, &u.now(&self.rod), self.slip);
        Ok(())
    }

    fn indicators(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &(),
        _t: f64,
        z: &mut [f64],
    ) -> Result<(), ModelError> {
        let indicators = (self.emla).indicators(&self.state, &u.now(&self.rod), self.slip);
        z.copy_from_slice(&indicators);
        Ok(())
    }

    fn event(&mut self, p: &Parameters, u: &Input, t: f64) -> Result<Event, ModelError> {
        let now = u.now(&self.rod);
        let shift = (self.emla).work_of_shift(&self.state, self.rod.value(), now.x);
        let is_due = self.closes.is_some_and(|closes| t >= closes);
        let (mut state, slip) = (self.emla).after_event(&self.state, &now, self.slip, is_due);
        state.shift += shift;
        self.slip = slip;
        let wait = self.emla.awaited_brake(&state, &now);
        self.closes = (wait > 0.0).then(|| self.closes.unwrap_or(t + wait));
        self.become_state(state, t, |emla| trip(emla, &now, t));
        self.completed_step(p, u, t)?;
        Ok(self.closes.map_or(Event::NONE, Event::at))
    }

    fn directional(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &(),
        _t: f64,
        (seed, du): (&Self, &Input),
        dx: &mut Self,
        y: Option<&mut Output>,
    ) -> Result<(), ModelError> {
        let (u, du) = (u.now(&self.rod), du.direction());
        if let Some(y) = y {
            *y = self.emla.output_tangent(&self.state, &u, &seed.state, &du);
        }
        dx.state = (self.emla).derivative_along(&self.state, &u, self.slip, (&seed.state, &du));
        Ok(())
    }

    fn completed_step(&mut self, _p: &Parameters, u: &Input, t: f64) -> Result<bool, ModelError> {
        let now = u.now(&self.rod);
        let state = self.emla.with_observations(&self.state, &now);
        self.become_state(state, t, |emla| trip(emla, &now, t));
        self.rod = ExtrapolatedInput::from_input(&u.x);
        Ok(false)
    }
}

#[cfg(not(test))] // tests need no C functions, which take longest to compile
fmu_export::export_fmu!(EmlaFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Every accessor works, and the declared dependencies are those found by varying the inputs.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<EmlaFmu>(), [""; 0]);
    }
}
