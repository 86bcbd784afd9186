//! One instance's C functions, called with slices: any call, in any order and with any arguments,
//! also NULL. Each gives the status that the library answers.
//!
//! What is passed is valid for as long and as far as the library may look at it. Whether it looks
//! further, or bears what the standard forbids, is its own affair: only those who want to know that
//! call out of order, or with NULL and handles that are no more.

mod derivatives;
mod events;
mod states;
mod values;

use std::ffi::{CStr, c_int};
use std::ptr;
use std::sync::Arc;

use crate::calls::{Callbacks, Logger};
use crate::functions::Functions;
use crate::functions::OwnFunctions::{self, Fmi2, Fmi3};
use crate::log::{Log, Message, logger_3};
use crate::standard::{Pointer, Text};
use crate::status::{ABSENT, DISCARD, OK};

pub use events::{Continuous, Update};
pub use states::StateHandle;

/// Calls the function of the version of an instance: `f` are its functions.
macro_rules! either {
    ($instance:ident, $f:ident => $two:expr, $three:expr) => {
        match &$instance.functions.own {
            OwnFunctions::Fmi2($f) => $two,
            OwnFunctions::Fmi3($f) => $three,
        }
    };
}
use either;

/// An array that is given: its elements, or NULL with the number that it is said to have.
#[derive(Clone, Copy, Debug)]
pub enum Array<'a, T> {
    /// Elements.
    Of(&'a [T]),
    /// NULL.
    Null(usize),
}

impl<'a, T> Array<'a, T> {
    /// The elements, or NULL in their place.
    pub fn or_null(elements: &'a [T], is_null: bool) -> Self {
        match is_null {
            true => Self::Null(elements.len()),
            false => Self::Of(elements),
        }
    }

    fn pointer(self) -> *const T {
        match self {
            Self::Of(elements) => elements.as_ptr(),
            Self::Null(_) => ptr::null(),
        }
    }

    fn len(self) -> usize {
        match self {
            Self::Of(elements) => elements.len(),
            Self::Null(count) => count,
        }
    }
}

/// Room for one result, or NULL.
fn room<T>(place: Option<&mut T>) -> *mut T {
    place.map_or(ptr::null_mut(), ptr::from_mut)
}

/// A C string, or NULL.
fn c_text(text: Option<&CStr>) -> Text {
    text.map_or(ptr::null(), CStr::as_ptr)
}

/// What is simulated, as the C functions take it: relative tolerance, first and last time in s.
#[derive(Clone, Copy, Debug, Default)]
#[allow(missing_docs)] // named and explained in the standard
pub struct Experiment {
    pub has_tolerance: bool,
    pub tolerance: f64,
    pub start: f64,
    pub has_stop: bool,
    pub stop: f64,
}

/// `fmi2Type`: what an instance is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Model Exchange.
    ModelExchange,
    /// Co-Simulation.
    CoSimulation,
    /// A number that is none of them, which only FMI 2.0 can be given.
    Other(c_int),
}

/// Callbacks that an instance is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Given {
    /// NULL in their place.
    Nothing,
    /// Without a logger.
    NoLogger,
    /// A logger alone.
    Logger,
    /// A logger and functions for memory.
    LoggerAndMemory,
}

/// What an instance is made with.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// What it is made for.
    pub kind: Kind,
    /// Name.
    pub name: Option<&'a CStr>,
    /// `guid` or `instantiationToken`.
    pub token: Option<&'a CStr>,
    /// Where the resources are.
    pub resources: Option<&'a CStr>,
    /// loggingOn.
    pub is_logging: bool,
    /// eventModeUsed (FMI 3.0).
    pub has_events: bool,
    /// earlyReturnAllowed (FMI 3.0).
    pub returns_early: bool,
    /// Callbacks.
    pub given: Given,
}

/// How a step of FMI 3.0 ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(missing_docs)] // named and explained in the standard
pub struct StepEnd {
    pub event_needed: bool,
    pub terminates: bool,
    pub early: bool,
    /// Last successful time, s.
    pub time: f64,
}

/// An instance, or NULL in the place of one; freed when dropped.
pub struct RawInstance {
    functions: Arc<Functions>,
    c: Pointer,
    log: Log,
    _callbacks: Box<Callbacks>,
}

/// Functions that differ in their names alone.
macro_rules! alike {
    ($($(#[$about:meta])* $name:ident($($argument:ident: $type:ty),*) = $in_2:ident $in_3:ident;)*) => {
        $($(#[$about])*
        pub fn $name(&self $(, $argument: $type)*) -> c_int {
            // SAFETY: a live instance or NULL, plain values.
            unsafe {
                either!(self, f =>
                    (f.$in_2)(self.c $(, $argument)*),
                    (f.$in_3)(self.c $(, $argument)*))
            }
        })*
    };
}

/// Functions that FMI 3.0 alone has, and that have no arguments.
macro_rules! only_3 {
    ($($name:ident = $function:ident;)*) => {
        $(pub fn $name(&self) -> c_int {
            match &self.functions.own {
                Fmi2(_) => ABSENT,
                // SAFETY: a live instance or NULL.
                Fmi3(f) => unsafe { (f.$function)(self.c) },
            }
        })*
    };
}

#[allow(missing_docs)] // named and explained in the standard
impl RawInstance {
    /// An instance that speaks to this log; where the library gives NULL, what it said.
    pub fn new(
        functions: &Arc<Functions>,
        request: &Request,
        log: Log,
    ) -> Result<Self, Vec<Message>> {
        let mut callbacks = Box::new(log.callbacks());
        match request.given {
            Given::NoLogger => callbacks.logger = ptr::null(),
            #[cfg(feature = "native")]
            Given::LoggerAndMemory => {
                callbacks.allocate_memory = Some(libc::calloc);
                callbacks.free_memory = Some(libc::free);
            }
            _ => {}
        }
        let texts = [request.name, request.token, request.resources].map(c_text);
        // SAFETY: NULL or C strings; the callbacks outlive the instance.
        let c = unsafe { instantiate(functions, request, texts, &callbacks) };
        match c.is_null() {
            true => Err(log.take_own()),
            false => Ok(Self {
                functions: functions.clone(),
                c,
                log,
                _callbacks: callbacks,
            }),
        }
    }

    /// NULL in the place of an instance.
    pub fn null(functions: &Arc<Functions>) -> Self {
        let log = Log::of_thread("");
        Self {
            functions: functions.clone(),
            c: ptr::null_mut(),
            _callbacks: Box::new(log.callbacks()),
            log,
        }
    }

    /// The functions of its library.
    pub fn functions(&self) -> &Arc<Functions> {
        &self.functions
    }

    /// Its messages.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// `fmi2Component`.
    #[cfg(feature = "master")]
    pub(crate) fn pointer(&self) -> Pointer {
        self.c
    }

    alike! {
        exit_initialization_mode() = fmi2ExitInitializationMode fmi3ExitInitializationMode;
        terminate() = fmi2Terminate fmi3Terminate;
        reset() = fmi2Reset fmi3Reset;
        enter_event_mode() = fmi2EnterEventMode fmi3EnterEventMode;
        enter_continuous_time_mode() = fmi2EnterContinuousTimeMode fmi3EnterContinuousTimeMode;
        set_time(t: f64) = fmi2SetTime fmi3SetTime;
    }

    only_3! {
        enter_step_mode = fmi3EnterStepMode;
        evaluate_discrete_states = fmi3EvaluateDiscreteStates;
        enter_configuration_mode = fmi3EnterConfigurationMode;
        exit_configuration_mode = fmi3ExitConfigurationMode;
    }

    /// Frees NULL, which does nothing.
    pub fn free_null(functions: &Functions) {
        // SAFETY: NULL is what the standard lets pass.
        unsafe {
            match &functions.own {
                Fmi2(f) => (f.fmi2FreeInstance)(ptr::null_mut()),
                Fmi3(f) => (f.fmi3FreeInstance)(ptr::null_mut()),
            }
        }
    }

    /// Switches on or off what these categories say, all of them where none is named.
    pub fn set_debug_logging(&self, on: bool, categories: Array<Option<&CStr>>) -> c_int {
        let pointers: Vec<Text> = match categories {
            Array::Of(categories) => categories.iter().map(|c| c_text(*c)).collect(),
            Array::Null(_) => Vec::new(),
        };
        let list = match categories {
            Array::Of(_) => pointers.as_ptr(),
            Array::Null(_) => ptr::null(),
        };
        let n = categories.len();
        // SAFETY: NULL, or as many elements as said, each NULL or a C string.
        unsafe {
            either!(self, f =>
                (f.fmi2SetDebugLogging)(self.c, on.into(), n, list),
                (f.fmi3SetDebugLogging)(self.c, on, n, list))
        }
    }

    /// fmi2SetupExperiment; FMI 3.0 has it in fmi3EnterInitializationMode, and nothing is called
    /// here.
    pub fn setup_experiment(&self, experiment: Experiment) -> c_int {
        match &self.functions.own {
            Fmi2(_) => self.begin(experiment),
            Fmi3(_) => OK,
        }
    }

    /// In FMI 3.0 with the experiment, which FMI 2.0 is told by fmi2SetupExperiment.
    pub fn enter_initialization_mode(&self, experiment: Experiment) -> c_int {
        match &self.functions.own {
            // SAFETY: a live instance or NULL.
            Fmi2(f) => unsafe { (f.fmi2EnterInitializationMode)(self.c) },
            Fmi3(_) => self.begin(experiment),
        }
    }

    /// fmi2SetupExperiment, or fmi3EnterInitializationMode with the same arguments.
    pub fn begin(&self, experiment: Experiment) -> c_int {
        let Experiment {
            has_tolerance,
            tolerance,
            start,
            has_stop,
            stop,
        } = experiment;
        let c = self.c;
        // SAFETY: a live instance or NULL, plain values.
        unsafe {
            match &self.functions.own {
                Fmi2(f) => {
                    let [has_tolerance, has_stop] = [has_tolerance, has_stop].map(c_int::from);
                    (f.fmi2SetupExperiment)(c, has_tolerance, tolerance, start, has_stop, stop)
                }
                Fmi3(f) => (f.fmi3EnterInitializationMode)(
                    c,
                    has_tolerance,
                    tolerance,
                    start,
                    has_stop,
                    stop,
                ),
            }
        }
    }

    /// A step; how it ended is told by FMI 3.0 only.
    #[inline]
    pub fn do_step(&self, t: f64, h: f64, no_set_prior: c_int, end: &mut StepEnd) -> c_int {
        // SAFETY: a live instance or NULL, places for the results.
        unsafe {
            match &self.functions.own {
                Fmi2(f) => (f.fmi2DoStep)(self.c, t, h, no_set_prior),
                Fmi3(f) => {
                    let StepEnd {
                        event_needed,
                        terminates,
                        early,
                        time,
                    } = end;
                    let no_set_prior = no_set_prior != 0;
                    (f.fmi3DoStep)(
                        self.c,
                        t,
                        h,
                        no_set_prior,
                        event_needed,
                        terminates,
                        early,
                        time,
                    )
                }
            }
        }
    }

    /// fmi2CancelStep.
    pub fn cancel_step(&self) -> c_int {
        match &self.functions.own {
            // SAFETY: a live instance or NULL.
            Fmi2(f) => unsafe { (f.fmi2CancelStep)(self.c) },
            Fmi3(_) => ABSENT,
        }
    }

    /// Time of the last communication point: fmi2GetRealStatus, or the independent variable.
    pub fn last_time(&self, time: &mut f64) -> c_int {
        // SAFETY: a live instance or NULL, one reference, a place for the result.
        unsafe {
            match (&self.functions.own, self.functions.time) {
                (Fmi2(f), _) => (f.fmi2GetRealStatus)(self.c, 2, time),
                (Fmi3(f), Some(vr)) => (f.fmi3GetFloat64)(self.c, &vr, 1, time, 1),
                (Fmi3(_), None) => DISCARD,
            }
        }
    }

    /// The inquiry `kind` by one of `fmi2GetStatus`, `fmi2GetRealStatus`, `fmi2GetIntegerStatus`,
    /// `fmi2GetBooleanStatus` and `fmi2GetStringStatus`, in this order.
    pub fn inquire(&self, which: usize, kind: c_int, is_null: bool) -> (&'static str, c_int) {
        let Fmi2(f) = &self.functions.own else {
            return ("fmi2GetStatus", ABSENT);
        };
        let (mut integer, mut number, mut string) = (-1, f64::NAN, ptr::null());
        macro_rules! ask {
            ($function:ident, $place:expr) => {
                (
                    stringify!($function),
                    (f.$function)(self.c, kind, room((!is_null).then_some($place))),
                )
            };
        }
        // SAFETY: a live instance or NULL; places for one result or NULL.
        unsafe {
            match which {
                0 => ask!(fmi2GetStatus, &mut integer),
                1 => ask!(fmi2GetRealStatus, &mut number),
                2 => ask!(fmi2GetIntegerStatus, &mut integer),
                3 => ask!(fmi2GetBooleanStatus, &mut integer),
                _ => ask!(fmi2GetStringStatus, &mut string),
            }
        }
    }
}

/// # Safety
/// NULL or C strings, and callbacks that outlive the instance.
unsafe fn instantiate(
    functions: &Functions,
    request: &Request,
    [name, token, resources]: [Text; 3],
    callbacks: &Callbacks,
) -> Pointer {
    let logging = request.is_logging;
    // SAFETY: as the caller promises.
    unsafe {
        match &functions.own {
            Fmi2(f) => {
                let callbacks = match request.given {
                    Given::Nothing => ptr::null(),
                    _ => callbacks,
                };
                let kind = match request.kind {
                    Kind::ModelExchange => 0,
                    Kind::CoSimulation => 1,
                    Kind::Other(kind) => kind,
                };
                (f.fmi2Instantiate)(name, kind, token, resources, callbacks, 0, logging.into())
            }
            Fmi3(f) => {
                let environment = match request.given {
                    Given::Nothing => ptr::null_mut(),
                    _ => callbacks.environment,
                };
                let has_logger = !matches!(request.given, Given::Nothing | Given::NoLogger);
                let logger = has_logger.then_some(logger_3 as Logger);
                match request.kind {
                    Kind::CoSimulation => (f.fmi3InstantiateCoSimulation)(
                        name,
                        token,
                        resources,
                        false,
                        logging,
                        request.has_events,
                        request.returns_early,
                        ptr::null(),
                        0,
                        environment,
                        logger,
                        ptr::null_mut(),
                    ),
                    _ => (f.fmi3InstantiateModelExchange)(
                        name,
                        token,
                        resources,
                        false,
                        logging,
                        environment,
                        logger,
                    ),
                }
            }
        }
    }
}

impl Drop for RawInstance {
    fn drop(&mut self) {
        if self.c.is_null() {
            return;
        }
        // SAFETY: a live instance, freed once.
        unsafe { either!(self, f => (f.fmi2FreeInstance)(self.c), (f.fmi3FreeInstance)(self.c)) }
    }
}
