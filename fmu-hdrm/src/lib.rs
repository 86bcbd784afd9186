//! FMI 2.0 co-simulation FMU `Hdrm`: the heavy-duty manipulator, both closed loops included.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it
//! to the `hdrm` library.
#![allow(non_snake_case)] // the paper's symbols

mod table;

use fmu_export::{Info, InputPolynomial, Model, ModelError, Variable};
use hdrm::{DOF, Dynamics, Hdrm, Input, Options, Output, State};
use machine::Machine;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;

/// The manipulator behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct HdrmFmu {
    plant: Hdrm,
    state: State,
    /// At `state`, once outputs or a step have asked for them: the step begins where the outputs are.
    #[serde(skip)]
    dynamics: OnceCell<Dynamics>,
}

impl HdrmFmu {
    fn dynamics(&self) -> &Dynamics {
        self.dynamics
            .get_or_init(|| self.plant.dynamics(&self.state))
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
            dynamics: OnceCell::new(),
        })
    }

    fn output(&self, _p: &Parameters, u: &Input) -> Result<Output, ModelError> {
        Ok(self.plant.output_at(self.dynamics(), u))
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        t: f64,
        h: f64,
    ) -> Result<(), ModelError> {
        let start = self.dynamics();
        self.state = (self.plant).step_from(start, |s| u.at::<Self>(s), t, h)?;
        self.dynamics = OnceCell::new();
        Ok(())
    }

    fn output_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.plant.output_derivative(&self.state, u, u_dot))
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.plant.directional_derivative(&self.state, u, du))
    }
}

fmu_export::export_fmu!(HdrmFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether and when outputs are asked for changes nothing, bit for bit: the plant itself keeps no dynamics.
    #[test]
    fn kept_dynamics_change_no_result() {
        let (p, _) = HdrmFmu::defaults();
        let (t, h) = (0.0, 1e-3);
        let mut fmu = HdrmFmu::initialize(&p, &Input::default(), t).expect("valid defaults");
        for k in 0..50 {
            let u = Input {
                f: [311.0 * f64::from(k), 43_100.0, 31_700.0],
                ..Input::default()
            };
            if k % 3 > 0 {
                let output = fmu.output(&p, &u).expect("finite");
                assert_eq!(output, fmu.plant.output(&fmu.state, &u), "step {k}");
            }
            let expected = fmu.plant.step(&fmu.state, |_| u, t, h).expect("finite");
            let refused = fmu.step(&p, &InputPolynomial::held(u), t, -h);
            assert!(refused.is_err());
            fmu.step(&p, &InputPolynomial::held(u), t, h)
                .expect("finite");
            assert_eq!(fmu.state, expected, "step {k}");
        }
    }
}
