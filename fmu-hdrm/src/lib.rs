//! FMI 2.0 co-simulation FMU `Hdrm`: the heavy-duty manipulator, both closed loops included.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it
//! to the `hdrm` library.
#![allow(non_snake_case)] // the paper's symbols

mod table;

use fmu_export::{Evaluation, Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use hdrm::{DOF, Dynamics, Hdrm, Load, Options, Output, State};
use machine::Machine;
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// The manipulator behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct HdrmFmu {
    plant: Hdrm,
    state: State,
}

/// Inputs as the importer sees them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    u: hdrm::Input,
    /// Mass of the load, kg.
    load_mass: f64,
    /// Where it is, from the tip, m.
    load_com: [f64; 3],
}

impl Deref for Input {
    type Target = hdrm::Input;

    fn deref(&self) -> &hdrm::Input {
        &self.u
    }
}

impl DerefMut for Input {
    fn deref_mut(&mut self) -> &mut hdrm::Input {
        &mut self.u
    }
}

/// Outputs and the first stage of a step both begin with the dynamics. They are of the state and of the base's motion.
impl Evaluation<HdrmFmu> for Dynamics {
    fn of(model: &HdrmFmu, _p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        Ok(model.plant.dynamics_with(&model.state, u))
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
    /// Whether loads come with the velocity of the end-effector.
    load_moves_with_tip: bool,
    /// Else their own, m/s in the world.
    load_velocity: [f64; 3],
}

impl Parameters {
    fn of(machine: Machine, machine_file: String) -> Self {
        Self {
            options: Options::of(&machine),
            zeta_start: machine.start.zeta,
            zeta_dot_start: [0.0; DOF],
            load_moves_with_tip: true,
            load_velocity: [0.0; 3],
            machine,
            machine_file,
        }
    }

    /// What the end-effector carries by the parameters and the inputs.
    fn load(&self, u: &Input) -> Load {
        Load {
            mass: u.load_mass,
            com: u.load_com,
            ..self.options.load
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
        let (plant, state) = (self.plant).reloaded(now, &p.load(input), own, input)?;
        let start = plant.dynamics_with(&state, input);
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
        Ok(self.plant.output_at(now, u))
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
