//! State, inputs, parameters, enumerations of the FMU `Sensors`, for this crate's calls and table.

use fmu_export::{Evaluation, Items, ModelError};
use sensors::{ForceKind, Params, Sample, Sensors, Signals, SpeedKind, State};
use serde::{Deserialize, Serialize};

#[rustfmt::skip] // an item a line
pub(crate) static SPEED: Items<SpeedKind, 3> = Items::new("Speed", "where speeds come from", [
    (SpeedKind::Ideal, "ideal", "the speeds at the inputs pass as they are"),
    (SpeedKind::Difference, "difference", "difference of two position readings over the communication step, and a first-order filter"),
    (SpeedKind::Observer, "observer", "tracking observer of third order on the position readings"),
]);

#[rustfmt::skip] // an item a line
pub(crate) static FORCE: Items<ForceKind, 3> = Items::new("Force", "what gives the rod forces", [
    (ForceKind::Ideal, "ideal", "the forces at the inputs pass as they are"),
    (ForceKind::Sensor, "sensor", "a sensor with bias, noise and bandwidth"),
    (ForceKind::Absent, "absent", "no sensor: F_measured is force.per_current times i_q_measured; whoever needs the true force must do without"),
]);

/// The FMU's instance: sensors and their state.
#[derive(Clone, Serialize, Deserialize)]
pub struct SensorsFmu {
    pub(crate) sensors: Sensors,
    pub(crate) state: State,
    /// Value of `Input::sets` at the last sample. Until an input is set again, the outputs are
    /// those of that sample: a master that reads all outputs before it sets inputs would otherwise
    /// get a speed from the difference of a position to itself.
    pub(crate) sets: u32,
}

/// Inputs of the FMU.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    pub(crate) u: Signals,
    /// Number of calls that set one of them.
    pub(crate) sets: u32,
}

/// Parameters of the FMU.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// All parameters except enumerations and unsigned integers.
    pub(crate) p: Params,
    pub(crate) seed: i32,
    pub(crate) delay: i32,
    /// Item of [`SPEED`].
    pub(crate) speed: i32,
    /// Item of [`FORCE`].
    pub(crate) force: i32,
}

impl Parameters {
    pub(crate) fn sensors(&self) -> Result<Sensors, ModelError> {
        let mut p = self.p;
        p.seed = u64::try_from(self.seed)?;
        p.delay = u32::try_from(self.delay)?;
        p.speed.kind = SPEED.item(self.speed)?;
        p.force.kind = FORCE.item(self.force)?;
        Ok(Sensors::new(p))
    }
}

/// The sample for the present inputs.
impl Evaluation<SensorsFmu> for Sample {
    fn new(model: &SensorsFmu, _p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        Ok(model.sensors.measure(&model.state, &u.u))
    }
}
