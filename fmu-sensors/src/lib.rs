//! FMI 2.0 co-simulation FMU `Sensors`: what a controller knows of its plants.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it to the `sensors` library.
#![allow(non_snake_case)] // the paper's symbols

mod table;

use fmu_export::{Evaluation, Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use sensors::{ForceKind, Measured, Params, Sensors, Signals, SpeedKind, State};
use serde::{Deserialize, Serialize};

/// The sensors behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct SensorsFmu {
    sensors: Sensors,
    state: State,
    /// How often an input had been set at the last sample. Until one is set again, what is read is that sample: a master that reads all
    /// outputs before it sets any input would else get the difference of a position to itself for a speed.
    sets: u32,
}

/// Inputs as the importer sees them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    u: Signals,
    /// How often one of them was set.
    sets: u32,
}

/// Parameters as the importer sees them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// All that is not an enumeration, and no integer that FMI signs and the library does not.
    p: Params,
    seed: i32,
    delay: i32,
    /// Item of `table::SPEED`.
    speed: i32,
    /// Item of `table::FORCE`.
    force: i32,
}

impl Parameters {
    fn sensors(&self) -> Result<Sensors, ModelError> {
        let mut p = self.p;
        p.seed = u64::try_from(self.seed)?;
        p.delay = u32::try_from(self.delay)?;
        p.speed.kind = match self.speed {
            table::SPEED_IDEAL => SpeedKind::Ideal,
            table::SPEED_DIFFERENCE => SpeedKind::Difference,
            _ => SpeedKind::Observer,
        };
        p.force.kind = match self.force {
            table::FORCE_IDEAL => ForceKind::Ideal,
            table::FORCE_SENSOR => ForceKind::Sensor,
            _ => ForceKind::Absent,
        };
        Ok(Sensors::new(p))
    }
}

/// The sample that the present inputs give.
pub struct Sample(Measured);

impl Evaluation<SensorsFmu> for Sample {
    fn of(model: &SensorsFmu, _p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        Ok(Self(model.sensors.measure(&model.state, &u.u)))
    }
}

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
            speed: table::SPEED_IDEAL,
            force: table::FORCE_IDEAL,
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
            *self.sensors.read(&self.state, &now.0)
        })
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Sample,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        if !now.0.is_finite() {
            return Err(ModelError::new(format!(
                "t = {t} s: the sample is not finite; inputs and their differences over a step must be"
            )));
        }
        self.sensors.advance(&mut self.state, &now.0, h);
        self.sets = u.value().sets;
        Ok(StepEnd::WHOLE)
    }
}

fmu_export::export_fmu!(SensorsFmu);

#[cfg(test)]
mod tests;
