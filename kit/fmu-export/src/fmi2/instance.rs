//! What FMI 2.0 adds to an instance, for `entry`: the names of its states, the status of the last
//! step, and the functions that set this status (fmi2DoStep, fmi2Reset, fmi2SetFMUstate).

use super::ffi::Status;
use super::log::Logger;
use crate::Model;
use crate::c_api::call_order::{self, *};
use crate::c_api::fmi_instance::{self, Version};
use crate::core::fault::Fault;
use crate::core::message::shown;
use crate::core::phase::Phase;
use crate::core::step::CompletedStep;
use crate::core::storage::TypeNames;

/// The data that FMI 2.0 adds to an instance.
pub(crate) struct Fmi2 {
    /// How the last fmi2DoStep ended.
    pub(crate) last_step: Status,
    /// Whether the model asked to end the simulation in that step.
    pub(crate) terminated: bool,
}

impl Fmi2 {
    /// Before any step.
    pub(crate) const NEW: Self = Self {
        last_step: Status::Ok,
        terminated: false,
    };
}

/// An instance of FMI 2.0.
pub(crate) type Fmi2Instance<M> = fmi_instance::FmiInstance<M, Fmi2>;

impl Version for Fmi2 {
    type Logger = Logger;
    const NAME: [u8; 4] = *b"2.0\0";
    const NAMES: TypeNames = TypeNames::PLAIN;
    const STATES: &'static [(u16, &'static str)] = &[
        (INSTANTIATED, "Instantiated"),
        (INITIALIZATION_MODE, "Initialization Mode"),
        (STEP_MODE, "Step Complete"),
        (ME_EVENT_MODE, "Event Mode"),
        (CONTINUOUS_TIME_MODE, "Continuous-Time Mode"),
        (TERMINATED, "Terminated"),
        (LOST, "lost by a panic"),
    ];
    const RECOVERY: &'static str = "fmi2Reset or fmi2SetFMUstate";

    #[inline]
    fn state<M: Model>(fmi: &Fmi2Instance<M>) -> u16 {
        call_order::state(&fmi.instance)
    }
}

/// The fault of a step that the model did not complete.
#[cold]
fn stopped(t: f64, h: f64, end: CompletedStep) -> Fault {
    let wish = if end.terminate {
        "ends the simulation"
    } else {
        "stops"
    };
    let [t, h, end] = [t, h, end.time].map(shown);
    Fault::discarded(format_args!(
        "t = {t} s, h = {h} s: the model {wish} at {end} s"
    ))
}

impl<M: Model> Fmi2Instance<M> {
    /// fmi2DoStep.
    #[inline]
    pub(crate) fn do_step(&mut self, t: f64, h: f64) -> Result<(), Fault> {
        match self.instance.do_step(t, h) {
            Ok(end) if end.is_whole && !end.terminate => {
                self.version.last_step = Status::Ok;
                Ok(())
            }
            Ok(end) => {
                self.version.last_step = Status::Discard;
                self.version.terminated = end.terminate;
                Err(stopped(t, h, end))
            }
            Err(fault) => {
                if matches!(fault, Fault::Discarded(_)) {
                    self.version.last_step = Status::Discard;
                }
                Err(fault)
            }
        }
    }

    /// fmi2ExitInitializationMode.
    pub(crate) fn exit_initialization(&mut self) -> Result<(), Fault> {
        self.instance.exit_initialization(self.interface == ME)?;
        match self.interface {
            ME => self.instance.enter(Phase::Event),
            _ => Ok(()),
        }
    }

    /// fmi2Reset.
    pub(crate) fn reset(&mut self) -> Result<(), Fault> {
        self.instance.reset();
        self.version = Fmi2::NEW;
        Ok(())
    }

    /// fmi2SetFMUstate.
    pub(crate) fn restore(&mut self, handle: usize) -> Result<(), Fault> {
        self.instance.restore(handle)?;
        self.version = Fmi2::NEW;
        Ok(())
    }
}
