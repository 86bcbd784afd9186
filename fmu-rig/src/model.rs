//! State and parameters of the FMU `Rig` and a warning, for this crate's FMI calls and table.

use actuator_table::{AXIS, DRIVE, ROOM_TEMPERATURE};
use fmu_export::{ExtrapolatedInput, ModelError};
use machine_file::{Drive, EmlaFields};
use rig::{CurrentLoop, Extras, Rig, State};
use serde::{Deserialize, Serialize};

/// The FMU's instance: actuator, its state and a pending warning.
#[derive(Clone, Serialize, Deserialize)]
pub struct RigFmu {
    pub(crate) rig: Rig,
    pub(crate) state: State,
    /// Rod position until the input `x` is set again, m.
    pub(crate) rod: ExtrapolatedInput<f64>,
    /// Warning for the importer's log, not part of the state.
    #[serde(skip)]
    pub(crate) warning: Option<String>,
}

/// Parameters of the FMU.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Item of [`DRIVE`].
    pub(crate) drive: i32,
    /// Communication steps after which the force acts.
    pub(crate) delay: i32,
    /// Item of [`AXIS`].
    pub(crate) axis: i32,
    /// The machine's section `emla`.
    pub(crate) of_machine: EmlaFields,
    /// Effects beyond the idealised actuator.
    pub(crate) extras: Extras,
    /// Whether the drive has its own current loop.
    pub(crate) current_loop: bool,
    /// Gains of the current loop.
    pub(crate) regulator: CurrentLoop,
    /// Voltage of the DC link below which an enabled drive trips, V.
    pub(crate) undervoltage: f64,
    /// Temperatures of winding and housing at the start, K.
    pub(crate) T_start: [f64; 2],
    /// File the machine came from; empty: the embedded reference machine.
    pub(crate) machine_file: String,
}

impl Parameters {
    pub(crate) fn reference() -> Self {
        Self {
            drive: DRIVE.number(Drive::Motion),
            delay: 0,
            axis: AXIS.number(0),
            of_machine: EmlaFields::new(actuator_table::own_machine().emla.slew),
            extras: Extras::AS_BUILT,
            current_loop: false,
            regulator: CurrentLoop::TYPICAL,
            undervoltage: 0.0,
            T_start: [ROOM_TEMPERATURE; 2],
            machine_file: String::new(),
        }
    }

    pub(crate) fn actuator(&self) -> Result<Rig, ModelError> {
        let p = self.of_machine.section()?;
        if self.current_loop && !self.extras.switching.on {
            return Err(ModelError::new(
                "`current_loop` = true needs `switching` = true: the loop runs at the switching frequency",
            ));
        }
        Ok(Rig::new(p, self.extras, DRIVE.item(self.drive)?)?
            .with_current_loop(self.current_loop.then_some(self.regulator))
            .with_undervoltage(self.undervoltage)
            .with_delay(u32::try_from(self.delay)?))
    }
}

/// Warning for a drive that trips at time `t`, s.
pub(crate) fn trip(rig: &Rig, u: &rig::Input, t: f64) -> String {
    machine_file::trip_message(t, rig.link_voltage(u), rig.undervoltage())
}
