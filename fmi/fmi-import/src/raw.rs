//! The C functions of one instance, called with slices: in any order, with any arguments, even
//! NULL. Each returns its status. All instances use them, `fmu-check` and `torture` directly too.
//!
//! All that is passed stays valid for as long as the library may read or write it. A library may
//! still crash when it is called out of order, with NULL or with a freed handle: call it so only to
//! find that out.
//!
//! ```
//! /// Whether an FMU refuses a call that passes NULL instead of an instance.
//! fn refuses_null(fmu: &fmi_import::Fmu) -> bool {
//!     fmi_import::raw::RawInstance::null(&fmu.functions).terminate() > 1
//! }
//! ```

mod calls;
mod lists;

pub use lists::{BinaryRoom, Inquiry};

use std::ffi::{CStr, CString, c_int};
use std::ptr;
use std::sync::Arc;

use crate::calls::{Callbacks, Logger};
use crate::functions::Functions;
use crate::functions::VersionFunctions::{self, Fmi2, Fmi3};
use crate::log::{Log, Message, logger_3};
use crate::standard::{Pointer, Text};
use crate::under_way::{self, Call, Slot};

/// An array argument: its elements, or NULL with a number of elements that the call claims.
#[derive(Clone, Copy, Debug)]
pub enum Array<'a, T> {
    /// The elements.
    Elements(&'a [T]),
    /// NULL, with the number of elements that the call claims.
    Null(usize),
}

impl<'a, T> Array<'a, T> {
    /// The elements, or NULL with their number.
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

/// A pointer to where a result is written, or NULL.
fn result_pointer<T>(place: Option<&mut T>) -> *mut T {
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
    /// NULL, which the standard allows to be freed.
    pub const NULL: Self = Self(ptr::null_mut());
    /// A handle that no instance has returned.
    pub const INVENTED: Self = Self(ptr::dangling_mut::<u64>().cast());

    /// Whether it is NULL.
    pub fn is_null(self) -> bool {
        self.0.is_null()
    }
}

/// The arguments of fmi2SetupExperiment: relative tolerance, start and stop time in s.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "master", derive(serde::Deserialize, serde::Serialize))]
#[allow(missing_docs)] // named and explained in the standard
pub struct Experiment {
    pub has_tolerance: bool,
    pub tolerance: f64,
    pub start: f64,
    pub has_stop: bool,
    pub stop: f64,
}

impl Experiment {
    /// An experiment from this time, s, on, without a stop time: the run may be continued.
    pub fn from_start(start: f64) -> Self {
        Self {
            start,
            ..Self::default()
        }
    }
}

/// `fmi2Type`: what an instance is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InstanceKind {
    /// Model Exchange.
    ModelExchange,
    /// Co-Simulation.
    CoSimulation,
    /// Scheduled Execution, of FMI 3.0.
    ScheduledExecution,
    /// Any other number, which only FMI 2.0 can be passed.
    Other(c_int),
}

/// Which callbacks an instance is passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CallbackSet {
    /// NULL instead of the callbacks.
    Nothing,
    /// Callbacks whose logger is NULL.
    NoLogger,
    /// A logger alone.
    Logger,
    /// A logger and functions for memory.
    LoggerAndMemory,
}

/// The arguments of fmi2Instantiate or its equivalents in FMI 3.0.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Interface that is instantiated.
    pub kind: InstanceKind,
    /// instanceName.
    pub name: Option<&'a CStr>,
    /// `guid` or `instantiationToken`.
    pub token: Option<&'a CStr>,
    /// fmuResourceLocation (a URI) or resourcePath (FMI 3.0).
    pub resources: Option<&'a CStr>,
    /// loggingOn.
    pub is_logging: bool,
    /// eventModeUsed (FMI 3.0).
    pub has_events: bool,
    /// earlyReturnAllowed (FMI 3.0).
    pub returns_early: bool,
    /// Callbacks that it is passed.
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

/// Results of an update of discrete states; by default no event is announced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// Discrete states must be updated once more.
    pub again: bool,
    /// The FMU asks to end the simulation.
    pub terminates: bool,
    /// Time of the next event, s; infinite if the FMU announces none.
    pub next: f64,
}

impl Default for Update {
    fn default() -> Self {
        Self {
            again: false,
            terminates: false,
            next: f64::INFINITY,
        }
    }
}

/// The vectors of Model Exchange that an importer reads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // named in the standard
pub enum ContinuousValues {
    States,
    Derivatives,
    Indicators,
    Nominals,
}

impl ContinuousValues {
    /// C name in FMI 2.0 of the function that gets them.
    pub const fn function(self) -> &'static str {
        match self {
            Self::States => "fmi2GetContinuousStates",
            Self::Derivatives => "fmi2GetDerivatives",
            Self::Indicators => "fmi2GetEventIndicators",
            Self::Nominals => "fmi2GetNominalsOfContinuousStates",
        }
    }
}

/// An instance, or NULL instead of one; freed when dropped.
pub struct RawInstance {
    functions: Arc<Functions>,
    /// Those of `functions`, without a step through it at each call.
    version: VersionFunctions,
    c: Pointer,
    /// Where calls are noted, and under which name.
    slot: &'static Slot,
    label: CString,
    log: Log,
    callbacks: Box<Callbacks>,
}

impl RawInstance {
    /// Makes an instance that logs to `log`. If the library returns NULL, its messages are the
    /// error.
    pub fn new(
        functions: &Arc<Functions>,
        request: &Request,
        log: Log,
    ) -> Result<Self, Vec<Message>> {
        let mut new = Self::without_pointer(functions, request.name.unwrap_or_default(), log);
        match request.given {
            CallbackSet::NoLogger => new.callbacks.logger = ptr::null(),
            #[cfg(feature = "native")]
            CallbackSet::LoggerAndMemory => {
                new.callbacks.allocate_memory = Some(libc::calloc);
                new.callbacks.free_memory = Some(libc::free);
            }
            _ => {}
        }
        let texts = [request.name, request.token, request.resources].map(c_text);
        new.log.name_variables(functions);
        let call = new.call();
        // SAFETY: NULL or C strings; the callbacks outlive the instance.
        new.c = unsafe { instantiate(functions, request, texts, &new.callbacks) };
        drop(call);
        match new.c.is_null() {
            true => Err(new.log.take_own()),
            false => Ok(new),
        }
    }

    /// NULL instead of an instance.
    pub fn null(functions: &Arc<Functions>) -> Self {
        Self::without_pointer(functions, c"NULL", Log::for_thread(""))
    }

    fn without_pointer(functions: &Arc<Functions>, label: &CStr, log: Log) -> Self {
        Self {
            version: functions.version.clone(),
            functions: functions.clone(),
            c: ptr::null_mut(),
            slot: Slot::fresh(),
            label: label.to_owned(),
            callbacks: Box::new(log.callbacks()),
            log,
        }
    }

    /// The functions of its library.
    pub fn functions(&self) -> &Arc<Functions> {
        &self.functions
    }

    /// The log that it writes to.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// Notes that it is called, until what is returned is dropped.
    #[inline]
    fn call(&self) -> Call {
        self.slot.call(&self.label)
    }

    /// A run begins anew in this process: what there is now is what the FMU must leave.
    #[cfg(all(feature = "master", feature = "native"))]
    pub(crate) fn begin_anew(&self) {
        Slot::fresh();
    }

    /// Frees NULL, which by the standard does nothing.
    pub fn free_null(functions: &Functions) {
        let _call = Slot::fresh().call(c"NULL");
        // SAFETY: NULL may be freed.
        unsafe { free(&functions.version, ptr::null_mut()) }
    }
}

/// # Safety
/// NULL, or a live instance that is not used any more.
unsafe fn free(functions: &VersionFunctions, c: Pointer) {
    // SAFETY: as the caller promises.
    unsafe {
        match functions {
            Fmi2(f) => (f.fmi2FreeInstance)(c),
            Fmi3(f) => (f.fmi3FreeInstance)(c),
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
        match &functions.version {
            Fmi2(f) => {
                let callbacks = match request.given {
                    CallbackSet::Nothing => ptr::null(),
                    _ => callbacks,
                };
                let kind = match request.kind {
                    InstanceKind::ModelExchange => 0,
                    InstanceKind::CoSimulation => 1,
                    InstanceKind::ScheduledExecution => 2,
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
                    // Its partitions are activated one after the other, in one thread: there is nothing
                    // to lock, and clocks are asked after each.
                    InstanceKind::ScheduledExecution => (f.fmi3InstantiateScheduledExecution)(
                        name,
                        token,
                        resources,
                        false,
                        logging,
                        environment,
                        logger,
                        clock_update as *const () as Pointer,
                        preemption as *const () as Pointer,
                        preemption as *const () as Pointer,
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

/// `fmi3ClockUpdateCallback`.
extern "C" fn clock_update(_environment: Pointer) {}

/// `fmi3LockPreemptionCallback` and its opposite.
extern "C" fn preemption() {}

impl Drop for RawInstance {
    fn drop(&mut self) {
        if !self.c.is_null() {
            under_way::remember_late();
            let _call = self.call();
            // SAFETY: a live instance, freed once.
            unsafe { free(&self.version, self.c) }
        }
    }
}
