//! FMU `Hdrm` for co-simulation in FMI 2.0 and 3.0: the heavy-duty manipulator, both closed loops
//! included.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it
//! to the `hdrm` library.
#![allow(non_snake_case)] // the paper's symbols

mod model;
mod table;

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use hdrm::{Dynamics, Hdrm, Output, State};
use machine::Machine;
pub use model::HdrmFmu;
use model::{Input, Parameters};

impl HdrmFmu {
    /// A step that begins with another load.
    #[cold]
    #[inline(never)]
    fn step_reloaded(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Dynamics,
        t: f64,
        h: f64,
    ) -> Result<(), ModelError> {
        let input = u.value();
        let own = (!p.load_moves_with_tip).then_some(p.load_velocity);
        let (plant, state) = (self.plant).reloaded(now, &p.load(input), own, &input.u)?;
        let start = plant.dynamics_with(&state, &input.u);
        self.state = plant.step_from(&start, |s| u.at::<Self>(s).u, t, h)?;
        self.plant = plant;
        Ok(())
    }
}

impl Model for HdrmFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = Dynamics;
    const INFO: Info = table::INFO;

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        (
            Parameters::of(Machine::reference(), String::new()),
            Input::default(),
        )
    }

    fn initialize(p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> {
        p.check_start()?;
        let state = State {
            zeta: p.zeta_start,
            zeta_dot: p.zeta_dot_start,
            ..State::default()
        };
        Ok(Self {
            plant: Hdrm::new(&p.machine, &p.options)?.with_load(&p.load(u))?,
            state,
        })
    }

    fn output(&self, _p: &Parameters, u: &Input, now: &Dynamics) -> Result<Output, ModelError> {
        Ok(self.plant.output_at(now, &u.u))
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Dynamics,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        if p.load(u.value()) != *self.plant.load() {
            self.step_reloaded(p, u, now, t, h)?;
            return Ok(StepEnd::WHOLE);
        }
        self.state = (self.plant).step_from(now, |s| u.at::<Self>(s).u, t, h)?;
        Ok(StepEnd::WHOLE)
    }

    fn output_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &Dynamics,
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.plant.output_derivative(&self.state, &u.u, &u_dot.u))
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &Dynamics,
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.plant.directional_derivative(&self.state, &u.u, &du.u))
    }
}

fmu_export::export_fmu!(HdrmFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Accessors, and dependencies against trying.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<HdrmFmu>(), [""; 0]);
    }
}
