//! State, inputs and parameters of the FMU.

use actuator_table::{AXIS, DRIVE, ROOM_TEMPERATURE};
use emla::{Electric, Emla, State, Surrogate};
use fmu_export::{Carried, ModelError};
use machine_file::{Drive, EmlaFields, Machine};
use serde::{Deserialize, Serialize};

/// The actuator behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct EmlaFmu {
    pub(crate) emla: Emla,
    pub(crate) state: State,
    /// Where the rod is until the input `x` is set again, m.
    pub(crate) rod: Carried<f64>,
    /// Which way an applied brake slips in Model Exchange, 1 or −1; 0: it holds.
    pub(crate) slip: f64,
    /// Whether the importer was told that the network is used where it was not trained.
    #[serde(skip)]
    pub(crate) untrained_reported: bool,
    /// Not part of the behaviour: handed to the importer's log once.
    #[serde(skip)]
    pub(crate) warning: Option<String>,
}

/// Parameters as the importer sees them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Item of [`DRIVE`].
    pub(crate) drive: i32,
    /// Blending of the network, 0…1.
    pub(crate) alpha: f64,
    /// Communication steps by which the force acts late.
    pub(crate) delay: i32,
    /// What the electrical side does beyond the paper.
    pub(crate) electric: Electric,
    /// Temperatures of winding and housing at the start, K.
    pub(crate) T_start: [f64; 2],
    /// Item of [`AXIS`].
    pub(crate) axis: i32,
    /// The machine's section `emla`.
    pub(crate) of_machine: EmlaFields,
    /// File the machine came from; empty: the embedded reference machine.
    pub(crate) machine_file: String,
    /// Network behind the blending.
    pub(crate) surrogate: Surrogate,
    /// File the network came from; empty: the embedded network.
    pub(crate) surrogate_file: String,
    /// Whether the efficiency's interval is given.
    pub(crate) interval: bool,
}

impl Parameters {
    pub(crate) fn reference() -> Self {
        Self {
            drive: DRIVE.number(Drive::Motion),
            alpha: 0.0,
            delay: 0,
            electric: Electric::default(),
            T_start: [ROOM_TEMPERATURE; 2],
            axis: AXIS.number(0),
            of_machine: EmlaFields::new(Machine::reference().emla.slew),
            machine_file: String::new(),
            surrogate: Surrogate::reference(),
            surrogate_file: String::new(),
            interval: false,
        }
    }

    pub(crate) fn actuator(&self) -> Result<Emla, ModelError> {
        let p = self.of_machine.section()?;
        let emla = Emla::new(p, DRIVE.item(self.drive)?)?
            .with_surrogate(self.surrogate.clone(), self.alpha)
            .with_electric(self.electric)
            .with_delay(u32::try_from(self.delay)?);
        if self.interval {
            return Ok(emla.with_interval()?);
        }
        Ok(emla)
    }
}

impl EmlaFmu {
    /// Goes on with the state `after`, and says what has come with it: `trips` is told of a drive
    /// that has tripped, and once, at the time `t`, s, that the network was not trained here.
    pub(crate) fn become_state(
        &mut self,
        after: State,
        t: f64,
        trips: impl FnOnce(&Emla) -> String,
    ) {
        if after.tripped && !self.state.tripped {
            self.warning = Some(trips(&self.emla));
        }
        self.state = after;
        let untrained = self.emla.untrained(&self.state);
        if let Some(point) = untrained.filter(|_| !self.untrained_reported) {
            self.warning = Some(format!("t = {t} s: {point}"));
        }
        self.untrained_reported = untrained.is_some();
    }
}

/// What to tell when the drive trips at time `t`, s.
pub(crate) fn trip(emla: &Emla, u: &emla::Input, t: f64) -> String {
    machine_file::trip_message(t, emla.link_voltage(u), emla.electric().undervoltage)
}
