//! FMU `Sensors` for Co-Simulation in FMI 2.0 and 3.0: measurements between plants and controller,
//! for the system `Real.ssd` and for any importer. This file connects the table of variables
//! (`table`) to the `sensors` library.
#![allow(non_snake_case)] // the paper's symbols

mod model;
mod table;

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use model::{FORCE, Input, Parameters, SPEED, SensorsFmu};
use sensors::{ForceKind, Params, Sample, Signals, SpeedKind};

impl Model for SensorsFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Signals;
    type Evaluation = Sample;
    const INFO: Info = table::INFO;

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let parameters = Parameters {
            p: Params::OFF,
            seed: 0,
            delay: 0,
            speed: SPEED.number(SpeedKind::Ideal),
            force: FORCE.number(ForceKind::Ideal),
        };
        (parameters, Input::default())
    }

    fn initialize(p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> {
        let sensors = p.sensors()?;
        Ok(Self {
            state: sensors.start(&u.u),
            sensors,
            sets: u.sets,
        })
    }

    fn output(&self, _p: &Parameters, u: &Input, now: &Sample) -> Result<Signals, ModelError> {
        Ok(if u.sets == self.sets {
            *self.sensors.held(&self.state)
        } else {
            *self.sensors.read(&self.state, now)
        })
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Sample,
        _t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        if !now.is_finite() {
            return Err(ModelError::new(
                "the sample is not finite; inputs and their differences over a step must be",
            ));
        }
        self.sensors.advance(&mut self.state, now, h);
        self.sets = u.value().sets;
        Ok(StepEnd::WHOLE)
    }
}

#[cfg(not(test))] // tests need no C functions, which take longest to compile
fmu_export::export_fmu!(SensorsFmu);

#[cfg(test)]
#[path = "../tests/unit/sensors.rs"]
mod tests;
