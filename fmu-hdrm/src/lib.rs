//! FMI 2.0 co-simulation FMU `Hdrm`: the heavy-duty manipulator, both closed loops included.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it
//! to the `hdrm` library.
#![allow(non_snake_case)] // the paper's symbols

mod table;

use fmu_export::{Evaluation, Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use hdrm::{DOF, Dynamics, Hdrm, Input, Options, Output, State};
use machine::Machine;
use serde::{Deserialize, Serialize};

/// The manipulator behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct HdrmFmu {
    plant: Hdrm,
    state: State,
}

/// Outputs and the first stage of a step both begin with the dynamics. They are of the state alone.
impl Evaluation<HdrmFmu> for Dynamics {
    fn of(model: &HdrmFmu, _p: &Parameters, _u: &Input) -> Result<Self, ModelError> {
        Ok(model.plant.dynamics(&model.state))
    }
}

/// Parameters as the importer sees them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    machine: Machine,
    /// File the machine came from; empty: the embedded reference machine.
    machine_file: String,
    options: Options,
    zeta_start: [f64; DOF],
    zeta_dot_start: [f64; DOF],
}

impl Parameters {
    fn of(machine: Machine, machine_file: String) -> Self {
        Self {
            options: Options::of(&machine),
            zeta_start: machine.start.zeta,
            zeta_dot_start: [0.0; DOF],
            machine,
            machine_file,
        }
    }

    /// A start outside the joint limits would begin inside an end stop.
    fn check_start(&self) -> Result<(), ModelError> {
        for (i, [min, max]) in self.machine.limits.zeta().into_iter().enumerate() {
            let zeta = self.zeta_start[i];
            if !(min..=max).contains(&zeta) {
                let name = i + 1;
                return Err(ModelError::new(format!(
                    "`zeta_start[{name}]` = {zeta} rad must be within the joint limits [{min}, {max}] rad"
                )));
            }
        }
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

    fn initialize(p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        p.check_start()?;
        let state = State {
            zeta: p.zeta_start,
            zeta_dot: p.zeta_dot_start,
        };
        Ok(Self {
            plant: Hdrm::new(&p.machine, &p.options)?,
            state,
        })
    }

    fn output(&self, _p: &Parameters, u: &Input, now: &Dynamics) -> Result<Output, ModelError> {
        Ok(self.plant.output_at(now, u))
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Dynamics,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        self.state = (self.plant).step_from(now, |s| u.at::<Self>(s), t, h)?;
        Ok(StepEnd::WHOLE)
    }

    fn output_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &Dynamics,
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.plant.output_derivative(&self.state, u, u_dot))
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &Dynamics,
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.plant.directional_derivative(&self.state, u, du))
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
