//! State and parameters of the FMU `Emla` and warnings, for this crate's FMI calls and table.

use actuator_table::{AXIS, DRIVE, ROOM_TEMPERATURE};
use emla::{Electric, Emla, State, Surrogate};
use fmu_export::{ExtrapolatedInput, ModelError};
use machine_file::{Drive, EmlaFields};
use serde::{Deserialize, Serialize};

/// The FMU's instance: actuator, its state and pending warnings.
#[derive(Clone, Serialize, Deserialize)]
pub struct EmlaFmu {
    pub(crate) emla: Emla,
    pub(crate) state: State,
    /// Rod position until the input `x` is set again, m.
    pub(crate) rod: ExtrapolatedInput<f64>,
    /// Direction in which an applied brake slips in Model Exchange, ±1; 0: it holds.
    pub(crate) slip: f64,
    /// When a commanded brake acts in Model Exchange, s; None: it does, or there is no command.
    pub(crate) closes: Option<f64>,
    /// Whether the warning about the network's trained range was given.
    #[serde(skip)]
    pub(crate) untrained_reported: bool,
    /// Warning for the importer's log, not part of the state.
    #[serde(skip)]
    pub(crate) warning: Option<String>,
}

/// Parameters of the FMU.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Item of [`DRIVE`].
    pub(crate) drive: i32,
    /// Blending factor of the network, 0…1.
    pub(crate) alpha: f64,
    /// Communication steps after which the force acts.
    pub(crate) delay: i32,
    /// Options of the electrical side.
    pub(crate) electric: Electric,
    /// Temperatures of winding and housing at the start, K.
    pub(crate) T_start: [f64; 2],
    /// Item of [`AXIS`].
    pub(crate) axis: i32,
    /// The machine's section `emla`.
    pub(crate) of_machine: EmlaFields,
    /// File the machine came from; empty: the embedded reference machine.
    pub(crate) machine_file: String,
    /// Network that is blended in.
    pub(crate) surrogate: Surrogate,
    /// File the network came from; empty: the embedded network.
    pub(crate) surrogate_file: String,
    /// Whether the efficiency's interval is an output.
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
            of_machine: EmlaFields::new(actuator_table::own_machine().emla.slew),
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
    /// Sets the state `after` and the warnings that are due: `trips` gives the text if the drive
    /// has tripped; outside the network's trained range there is one warning, at the time `t`, s.
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
            self.warning = Some(format!("t = {} s: {point}", machine_file::Seconds(t)));
        }
        self.untrained_reported = untrained.is_some();
    }
}

/// Warning for a drive that trips at time `t`, s.
pub(crate) fn trip(emla: &Emla, u: &emla::Input, t: f64) -> String {
    machine_file::trip_message(t, emla.link_voltage(u), emla.electric().undervoltage)
}
