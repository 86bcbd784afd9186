//! One instance's C functions, called with slices: any call, in any order and with any arguments,
//! also NULL. Each gives the status that the library answers.
//!
//! What is passed is valid for as long and as far as the library may look at it. Whether it looks
//! further, or bears what the standard forbids, is its own affair: only those who want to know that
//! call out of order, or with NULL and handles that are no more.

mod calls;
mod lists;

pub use lists::{ClockFunction, Inquiry};

use std::ffi::{CStr, c_int};
use std::ptr;
use std::sync::Arc;

use crate::calls::{Callbacks, Logger};
use crate::functions::Functions;
use crate::functions::OwnFunctions::{Fmi2, Fmi3};
use crate::log::{Log, Message, logger_3};
use crate::standard::{Pointer, Text};

/// An array that is given: its elements, or NULL with the number that it is said to have.
#[derive(Clone, Copy, Debug)]
pub enum Array<'a, T> {
    /// Elements.
    Elements(&'a [T]),
    /// NULL.
    Null(usize),
}

impl<'a, T> Array<'a, T> {
    /// The elements, or NULL in their place.
    pub fn or_null(elements: &'a [T], is_null: bool) -> Self {
        match is_null {
            true => Self::Null(elements.len()),
            false => Self::Elements(elements),
        }
    }

    fn pointer(self) -> *const T {
        match self {
            Self::Elements(elements) => elements.as_ptr(),
            Self::Null(_) => ptr::null(),
        }
    }

    fn len(self) -> usize {
        match self {
            Self::Elements(elements) => elements.len(),
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

/// The handle of a saved state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct StateHandle(Pointer);

impl StateHandle {
    /// NULL, which may be freed.
    pub const NULL: Self = Self(ptr::null_mut());
    /// One that no instance has given.
    pub const INVENTED: Self = Self(ptr::dangling_mut::<u64>().cast());

    /// It is NULL.
    pub fn is_null(self) -> bool {
        self.0.is_null()
    }
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
pub enum InstanceKind {
    /// Model Exchange.
    ModelExchange,
    /// Co-Simulation.
    CoSimulation,
    /// A number that is none of them, which only FMI 2.0 can be given.
    Other(c_int),
}

/// Callbacks that an instance is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CallbackSet {
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
    pub kind: InstanceKind,
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
    pub given: CallbackSet,
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
pub enum ContinuousValues {
    States,
    Derivatives,
    Indicators,
    Nominals,
}

impl ContinuousValues {
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

/// An instance, or NULL in the place of one; freed when dropped.
pub struct RawInstance {
    functions: Arc<Functions>,
    c: Pointer,
    log: Log,
    _callbacks: Box<Callbacks>,
}

impl RawInstance {
    /// An instance that speaks to this log; where the library gives NULL, what it said.
    pub fn new(
        functions: &Arc<Functions>,
        request: &Request,
        log: Log,
    ) -> Result<Self, Vec<Message>> {
        let mut callbacks = Box::new(log.callbacks());
        match request.given {
            CallbackSet::NoLogger => callbacks.logger = ptr::null(),
            #[cfg(feature = "native")]
            CallbackSet::LoggerAndMemory => {
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
                    CallbackSet::Nothing => ptr::null(),
                    _ => callbacks,
                };
                let kind = match request.kind {
                    InstanceKind::ModelExchange => 0,
                    InstanceKind::CoSimulation => 1,
                    InstanceKind::Other(kind) => kind,
                };
                (f.fmi2Instantiate)(name, kind, token, resources, callbacks, 0, logging.into())
            }
            Fmi3(f) => {
                let environment = match request.given {
                    CallbackSet::Nothing => ptr::null_mut(),
                    _ => callbacks.environment,
                };
                let has_logger =
                    !matches!(request.given, CallbackSet::Nothing | CallbackSet::NoLogger);
                let logger = has_logger.then_some(logger_3 as Logger);
                match request.kind {
                    InstanceKind::CoSimulation => (f.fmi3InstantiateCoSimulation)(
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
        unsafe {
            match &self.functions.own {
                Fmi2(f) => (f.fmi2FreeInstance)(self.c),
                Fmi3(f) => (f.fmi3FreeInstance)(self.c),
            }
        }
    }
}
