//! What FMI 3.0 adds, for `entry`: Event Mode, Configuration Mode, early return, updates.

use super::ffi::*;
use super::log::Logger;
use super::states::{STATES, STEP_MODE_AFTER_SET};
use crate::c_api::call_order::{self, CS, INTERMEDIATE_UPDATE, ME, SE, STEP_MODE};
use crate::c_api::fmi_instance::{self, Version};
use crate::core::fault::{Fault, refuse};
use crate::core::layout::TIME;
use crate::core::model_exchange::EventOutcome;
use crate::core::phase::Phase;
use crate::core::sizes;
use crate::core::step::CompletedStep;
use crate::core::storage::TypeNames;
use crate::{Event, Model};

const NOT_STRUCTURAL: &str =
    "this FMU has no structural parameters, so there is no Configuration Mode to enter or leave";

/// The data that FMI 3.0 adds to an instance.
pub(crate) struct Fmi3 {
    /// The importer uses Event Mode.
    pub(crate) has_event_mode: bool,
    /// The importer allows a step to return early.
    pub(crate) may_return_early: bool,
    /// The bit of the state while the phase is `Stepping`.
    pub(crate) step_state: u16,
    pub(crate) update: Option<Update>,
    /// The callbacks of Scheduled Execution.
    pub(crate) schedule: Option<Schedule>,
}

/// The importer's callbacks of Scheduled Execution.
#[derive(Clone)]
pub struct Schedule {
    /// Before and after a model partition.
    pub lock: Option<Preemption>,
    /// See above.
    pub unlock: Option<Preemption>,
    /// Tells of output clocks that tick, and of countdown clocks that were started.
    pub clock_update: Option<ClockUpdate>,
    /// What it receives.
    pub environment: InstanceEnvironment,
}

// SAFETY: as for `Update`.
unsafe impl Send for Schedule {}

/// The importer's intermediate update callback and the variables that it reads.
#[derive(Clone)]
pub(crate) struct Update {
    pub(crate) callback: IntermediateUpdate,
    pub(crate) environment: InstanceEnvironment,
    pub(crate) variables: Vec<ValueReference>,
}

// SAFETY: the environment is only passed on to the callback; FMI lets threads take turns.
unsafe impl Send for Update {}

/// An instance of FMI 3.0.
pub(crate) type Fmi3Instance<M> = fmi_instance::FmiInstance<M, Fmi3>;

/// The names of the types in FMI 3.0.
pub(crate) const NAMES: TypeNames = TypeNames {
    real: "Float64",
    integer: "Int32",
    size: "UInt64",
    enumeration: "Enumeration",
    enumeration_access: "Int64",
};

impl Version for Fmi3 {
    type Logger = Logger;
    const NAME: [u8; 4] = *b"3.0\0";
    const NAMES: TypeNames = NAMES;
    const STATES: &'static [(u16, &'static str)] = &STATES;
    const RECOVERY: &'static str = "fmi3Reset or fmi3SetFMUState";
    const TIME: Option<u32> = Some(TIME);

    #[inline]
    fn state<M: Model>(fmi: &Fmi3Instance<M>) -> u16 {
        match call_order::state(&fmi.instance) {
            STEP_MODE => fmi.version.step_state,
            state => state,
        }
    }
}

impl<M: Model> Fmi3Instance<M> {
    /// fmi3DoStep. If the importer does not allow early return, a model that stops early is stepped
    /// on to the end of the step; if it cannot reach it, the step fails.
    #[inline]
    pub(crate) fn do_step(&mut self, t: f64, h: f64) -> Result<CompletedStep, Fault> {
        let mut end = self.instance.do_step(t, h)?;
        let mut event = end.event;
        if !end.is_whole && !end.terminate && !self.version.may_return_early {
            (end, event) = self.rest_of_step(end, t + h, event)?;
        }
        self.version.step_state = STEP_MODE;
        event |= !end.is_whole && !end.terminate;
        end.event = event && self.version.has_event_mode;
        end.is_whole |= !self.version.may_return_early; // none is reported where none is allowed
        Ok(end)
    }

    /// Steps on from `end` to the time `until`.
    #[cold]
    #[inline(never)]
    fn rest_of_step(
        &mut self,
        mut end: CompletedStep,
        until: f64,
        mut event: bool,
    ) -> Result<(CompletedStep, bool), Fault> {
        while !end.is_whole && !end.terminate && end.time < until {
            let from = end.time;
            let stuck = |text: &str| {
                Fault::Refused(format!(
                    "{text}; the model stopped at {from} s, where the instance is now, and early return is not allowed"
                ))
            };
            end = match self.instance.do_rest_of_step(from, until - from) {
                Ok(end) if end.time > from || end.terminate => end,
                Ok(_) => return Err(stuck("the step makes no progress")),
                Err(Fault::Discarded(text)) => return Err(stuck(&text)),
                Err(fault) => return Err(fault),
            };
            event |= end.event;
        }
        Ok((end, event))
    }

    /// fmi3Reset.
    pub(crate) fn reset(&mut self) -> Result<(), Fault> {
        self.instance.reset();
        Ok(())
    }

    /// fmi3SetFMUState.
    pub(crate) fn restore(&mut self, handle: usize) -> Result<(), Fault> {
        self.instance.restore(handle)?;
        self.version.step_state = STEP_MODE;
        Ok(())
    }

    /// fmi3ExitInitializationMode.
    pub(crate) fn exit_initialization(&mut self) -> Result<(), Fault> {
        let has_event_mode = self.interface == ME || self.version.has_event_mode;
        self.instance.exit_initialization(has_event_mode)?;
        self.version.step_state = STEP_MODE;
        match self.interface {
            ME => self.instance.enter(Phase::Event),
            SE => self.instance.enter(Phase::Scheduled),
            _ if has_event_mode => self.instance.enter(Phase::Exchange),
            _ => Ok(()),
        }
    }

    /// fmi3EnterConfigurationMode.
    pub(crate) fn enter_configuration(&mut self) -> Result<(), Fault> {
        if sizes::sizes::<M>().next().is_none() {
            return refuse!("{NOT_STRUCTURAL}");
        }
        if self.instance.state.phase != Phase::Instantiated {
            return refuse!(
                "this FMU has no tunable structural parameters; sizes can only be set before initialization"
            );
        }
        self.instance.state.phase = Phase::Configuration;
        Ok(())
    }

    /// fmi3ExitConfigurationMode.
    pub(crate) fn exit_configuration(&mut self) -> Result<(), Fault> {
        if sizes::sizes::<M>().next().is_none() {
            return refuse!("{NOT_STRUCTURAL}");
        }
        if self.instance.state.phase != Phase::Configuration {
            return refuse!("fmi3EnterConfigurationMode must come before");
        }
        self.instance.state.phase = Phase::Instantiated;
        Ok(())
    }

    /// fmi3UpdateDiscreteStates.
    pub(crate) fn update_discrete_states(&mut self) -> Result<EventOutcome, Fault> {
        match self.interface {
            CS if M::EVENTS.is_none() && M::CLOCKS.is_empty() => Ok(EventOutcome {
                event: Event::NONE,
                is_moved: false,
            }),
            _ => self.instance.update_discrete_states(),
        }
    }

    /// fmi3EnterEventMode.
    pub(crate) fn enter_event_mode(&mut self) -> Result<(), Fault> {
        if self.interface == ME {
            return self.instance.enter(Phase::Event);
        }
        if !self.version.has_event_mode {
            return refuse!(
                "eventModeUsed was false in fmi3InstantiateCoSimulation; it must be true to enter Event Mode"
            );
        }
        self.instance.enter(Phase::Exchange)
    }

    /// fmi3EnterStepMode.
    pub(crate) fn enter_step_mode(&mut self) -> Result<(), Fault> {
        self.instance.leave_events(Phase::Stepping)?;
        self.version.step_state = STEP_MODE;
        Ok(())
    }

    /// Records that a value was set: in Step Mode, nothing can be read before the next step.
    #[inline]
    pub(crate) fn note_set(&mut self) {
        self.version.step_state = STEP_MODE_AFTER_SET;
    }

    /// Refuses clocked variables whose clocks are not active; `to` is what is to be done with them.
    #[inline]
    pub(crate) fn check_clocks(
        &self,
        number: impl Fn(usize) -> Option<ValueReference>,
        to: &str,
    ) -> Result<(), Fault> {
        match M::CLOCKS.is_empty() {
            true => Ok(()),
            false => self.instance.check_clocked(&number, to),
        }
    }

    /// Within a step, refuses variables that were not requested at instantiation; and clocked ones
    /// except at ticks.
    #[inline]
    pub(crate) fn check_update(
        &self,
        number: impl Fn(usize) -> Option<ValueReference>,
    ) -> Result<(), Fault> {
        if self.version.step_state == INTERMEDIATE_UPDATE {
            return self.not_for_update(number);
        }
        self.check_clocks(number, "read")
    }

    #[cold]
    #[inline(never)]
    fn not_for_update(
        &self,
        number: impl Fn(usize) -> Option<ValueReference>,
    ) -> Result<(), Fault> {
        let update = self.version.update.as_ref();
        let known = update.map_or(&[][..], |update| &update.variables);
        match (0..).map_while(number).find(|vr| !known.contains(vr)) {
            Some(vr) => refuse!(
                "value reference {vr} must be one of requiredIntermediateVariables of fmi3InstantiateCoSimulation"
            ),
            None => Ok(()),
        }
    }

    /// The numbers of all elements of the variables with these value references, in order.
    pub(crate) fn elements(
        &self,
        n: usize,
        number: impl Fn(usize) -> ValueReference,
    ) -> Result<Vec<u32>, Fault> {
        let mut elements = Vec::new();
        for k in 0..n {
            elements.extend(self.instance.layout.elements(number(k))?);
        }
        Ok(elements)
    }
}
