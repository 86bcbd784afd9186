//! Event Mode, and the calls of Model Exchange.

use std::ffi::c_int;
use std::ptr;

use super::{Array, RawInstance, either};
use crate::functions::OwnFunctions::{self, Fmi2, Fmi3};
use crate::status::{OK, WARNING};

/// What an update of discrete states told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// Once more.
    pub again: bool,
    /// The simulation ends.
    pub terminates: bool,
    /// When the next event is, s; infinite where that is not known.
    pub next: f64,
}

/// Numbers of a model that an importer integrates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // named in the standard
pub enum Continuous {
    States,
    Derivatives,
    Indicators,
    Nominals,
}

impl Continuous {
    /// The function that gets them, as in FMI 2.0.
    pub const fn function(self) -> &'static str {
        match self {
            Self::States => "fmi2GetContinuousStates",
            Self::Derivatives => "fmi2GetDerivatives",
            Self::Indicators => "fmi2GetEventIndicators",
            Self::Nominals => "fmi2GetNominalsOfContinuousStates",
        }
    }
}

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Default)]
struct EventInfo {
    /// Again, end, nominals changed, states changed, next event known.
    flags: [c_int; 5],
    next: f64,
}

impl RawInstance {
    /// Discrete states follow, once.
    pub fn update_discrete_states(&self, update: &mut Update) -> c_int {
        let mut info = EventInfo::default();
        let ([mut again, mut end, mut nominals, mut values, mut known], mut time) =
            ([false; 5], 0.0);
        // SAFETY: a live instance or NULL; places for the results.
        let status = unsafe {
            match &self.functions.own {
                Fmi2(f) => (f.fmi2NewDiscreteStates)(self.c, ptr::from_mut(&mut info).cast()),
                Fmi3(f) => (f.fmi3UpdateDiscreteStates)(
                    self.c,
                    &mut again,
                    &mut end,
                    &mut nominals,
                    &mut values,
                    &mut known,
                    &mut time,
                ),
            }
        };
        if let Fmi2(_) = &self.functions.own {
            [again, end, _, _, known] = info.flags.map(|flag| flag != 0);
            time = info.next;
        }
        *update = Update {
            again,
            terminates: end,
            next: if known { time } else { f64::INFINITY },
        };
        status
    }

    /// From Event Mode of Model Exchange: new discrete states until none is needed, at most a
    /// thousand times; then into Continuous-Time Mode.
    pub fn handle_events(&self, update: &mut Update) -> c_int {
        for _ in 0..1000 {
            let status = self.update_discrete_states(update);
            if status > WARNING {
                return status;
            }
            if !update.again {
                break;
            }
        }
        self.enter_continuous_time_mode()
    }

    /// FMI 3.0: from Event Mode to Step Mode, where steps are made; else nothing.
    pub fn leave_events(&self) -> c_int {
        if !self.functions.has_event_mode() {
            return OK;
        }
        let mut update = Update::default();
        match self.update_discrete_states(&mut update) {
            OK | WARNING => self.enter_step_mode(),
            status => status,
        }
    }

    /// FMI 3.0: from Step Mode to Event Mode, where values are exchanged; else nothing.
    pub fn enter_events(&self) -> c_int {
        match self.functions.has_event_mode() {
            true => self.enter_event_mode(),
            false => OK,
        }
    }

    /// Numbers of Model Exchange, or NULL in the place of room for `n` of them.
    pub fn get_continuous(&self, which: Continuous, values: Option<&mut [f64]>, n: usize) -> c_int {
        assert!(values.as_ref().is_none_or(|room| room.len() >= n));
        let to = values.map_or(ptr::null_mut(), <[f64]>::as_mut_ptr);
        // SAFETY: a live instance or NULL, NULL or room for `n` numbers.
        unsafe {
            match &self.functions.own {
                Fmi2(f) => match which {
                    Continuous::States => (f.fmi2GetContinuousStates)(self.c, to, n),
                    Continuous::Derivatives => (f.fmi2GetDerivatives)(self.c, to, n),
                    Continuous::Indicators => (f.fmi2GetEventIndicators)(self.c, to, n),
                    Continuous::Nominals => (f.fmi2GetNominalsOfContinuousStates)(self.c, to, n),
                },
                Fmi3(f) => match which {
                    Continuous::States => (f.fmi3GetContinuousStates)(self.c, to, n),
                    Continuous::Derivatives => (f.fmi3GetContinuousStateDerivatives)(self.c, to, n),
                    Continuous::Indicators => (f.fmi3GetEventIndicators)(self.c, to, n),
                    Continuous::Nominals => (f.fmi3GetNominalsOfContinuousStates)(self.c, to, n),
                },
            }
        }
    }

    /// Sets the states.
    pub fn set_continuous_states(&self, x: Array<f64>) -> c_int {
        let (from, n) = (x.pointer(), x.len());
        // SAFETY: a live instance or NULL, NULL or as many numbers as said.
        unsafe {
            either!(self, f =>
                (f.fmi2SetContinuousStates)(self.c, from, n),
                (f.fmi3SetContinuousStates)(self.c, from, n))
        }
    }

    /// Whether an event must be handled, and whether the simulation ends.
    pub fn completed_integrator_step(&self, told: &mut [bool; 2]) -> c_int {
        // SAFETY: a live instance or NULL, places for the results.
        unsafe {
            match &self.functions.own {
                Fmi2(f) => {
                    let mut flags: [c_int; 2] = [0; 2];
                    let [event, ends] = flags.each_mut();
                    let status = (f.fmi2CompletedIntegratorStep)(self.c, 1, event, ends);
                    *told = flags.map(|flag| flag != 0);
                    status
                }
                Fmi3(f) => {
                    let [event, ends] = told;
                    (f.fmi3CompletedIntegratorStep)(self.c, true, event, ends)
                }
            }
        }
    }
}
