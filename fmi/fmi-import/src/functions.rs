//! The C functions of an FMU of either version, called alike: by what they do, with the arguments
//! of FMI 2.0. What FMI 3.0 wants beside them, such as the number of values of arrays, follows from
//! the model description.

use std::collections::HashMap;
use std::ffi::c_int;
use std::ptr;

use crate::calls::{Callbacks, Functions2, Functions3, Logger};
use crate::library::Library;
use fmi_description::{Causality, Description, Version};

use super::log::logger_3;
use super::names::in_3;
use super::symbols::{DISCARD, OK, Pointer, Text, WARNING};

/// The functions of a loaded library.
pub struct Functions {
    pub(super) own: OwnFunctions,
    /// Number of values by value reference; not told of scalars.
    sizes: HashMap<u32, usize>,
    time: Option<u32>,
    has_event_mode: bool,
}

/// Those of one version.
#[allow(clippy::large_enum_variant)] // one for each FMU
pub enum OwnFunctions {
    /// FMI 2.0.
    Fmi2(Functions2),
    /// FMI 3.0.
    Fmi3(Functions3),
}

use OwnFunctions::{Fmi2, Fmi3};

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Default)]
struct EventInfo {
    /// Again, end, nominals changed, states changed, next event known.
    flags: [c_int; 5],
    next: f64,
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

/// Functions of both versions, with the arguments of FMI 2.0, and how each version is called with
/// them: `f` are its functions.
macro_rules! both {
    ($self:ident, $f:ident: $(
        $(#[$about:meta])*
        fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)? = $in_2:expr, $in_3:expr;
    )*) => {
        $($(#[$about])*
        pub unsafe fn $name(&$self $(, $argument: $type)*) $(-> $result)? {
            // SAFETY: forwarded.
            unsafe {
                match &$self.own {
                    #[allow(unused_variables)]
                    Fmi2($f) => $in_2,
                    #[allow(unused_variables)]
                    Fmi3($f) => $in_3,
                }
            }
        })*
    };
}

/// # Safety
/// As for the C functions: a live instance or NULL, NULL or arrays of the length given, with room
/// for all elements of the variables.
#[allow(missing_docs, clippy::missing_safety_doc, clippy::too_many_arguments)] // named and explained in the standard
impl Functions {
    /// Those of the version that the description names.
    pub fn load(library: Library, description: &Description) -> Self {
        let variables = &description.variables;
        let arrays = variables.iter().filter(|v| v.size() > 1);
        let time = variables
            .iter()
            .find(|v| v.causality == Causality::Independent);
        Self {
            own: match description.fmi {
                Version::Fmi2 => Fmi2(Functions2::of(library)),
                Version::Fmi3 => Fmi3(Functions3::of(library)),
            },
            sizes: arrays.map(|v| (v.reference, v.size())).collect(),
            time: time.map(|v| v.reference),
            has_event_mode: description.capabilities.event_mode,
        }
    }

    /// Those of the version.
    pub fn own(&self) -> &OwnFunctions {
        &self.own
    }

    /// Those of FMI 3.0.
    pub fn fmi3(&self) -> Option<&Functions3> {
        match &self.own {
            Fmi2(_) => None,
            Fmi3(f) => Some(f),
        }
    }

    /// The name, in the version of the FMU, of a function named as in FMI 2.0.
    pub fn name<'a>(&self, name: &'a str) -> &'a str {
        match &self.own {
            Fmi2(_) => name,
            Fmi3(_) => in_3(name),
        }
    }

    /// Instances go through Event Mode.
    pub fn has_event_mode(&self) -> bool {
        self.has_event_mode && self.fmi3().is_some()
    }

    /// At a communication point values are read after others were set: in FMI 3.0 in Event Mode
    /// only.
    pub fn reads_after_set(&self) -> bool {
        self.has_event_mode || self.fmi3().is_none()
    }

    /// Number of values of these variables.
    pub fn count(&self, references: &[u32]) -> usize {
        let size = |r: &u32| self.sizes.get(r).copied().unwrap_or(1);
        references.iter().map(size).sum()
    }

    unsafe fn counted(&self, vr: *const u32, n: usize) -> usize {
        match vr.is_null() {
            true => n,
            // SAFETY: `n` references.
            false => self.count(unsafe { std::slice::from_raw_parts(vr, n) }),
        }
    }

    both! { self, f:
        fn get_version() -> Text = (f.fmi2GetVersion)(), (f.fmi3GetVersion)();
        fn set_debug_logging(c: Pointer, on: c_int, n: usize, list: *const Text) -> c_int
            = (f.fmi2SetDebugLogging)(c, on, n, list), (f.fmi3SetDebugLogging)(c, on != 0, n, list);
        fn free_instance(c: Pointer) = (f.fmi2FreeInstance)(c), (f.fmi3FreeInstance)(c);
        /// fmi2SetupExperiment; FMI 3.0 has it in fmi3EnterInitializationMode, and nothing is called
        /// here.
        fn setup_experiment(c: Pointer, experiment: Experiment) -> c_int
            = self.begin(c, experiment), OK;
        /// In FMI 3.0 with the experiment, which FMI 2.0 is told by fmi2SetupExperiment.
        fn enter_initialization_mode(c: Pointer, experiment: Experiment) -> c_int
            = (f.fmi2EnterInitializationMode)(c), self.begin(c, experiment);
        fn exit_initialization_mode(c: Pointer) -> c_int
            = (f.fmi2ExitInitializationMode)(c), (f.fmi3ExitInitializationMode)(c);
        fn terminate(c: Pointer) -> c_int = (f.fmi2Terminate)(c), (f.fmi3Terminate)(c);
        fn reset(c: Pointer) -> c_int = (f.fmi2Reset)(c), (f.fmi3Reset)(c);
        fn get_fmu_state(c: Pointer, state: *mut Pointer) -> c_int
            = (f.fmi2GetFMUstate)(c, state), (f.fmi3GetFMUState)(c, state);
        fn set_fmu_state(c: Pointer, state: Pointer) -> c_int
            = (f.fmi2SetFMUstate)(c, state), (f.fmi3SetFMUState)(c, state);
        fn free_fmu_state(c: Pointer, state: *mut Pointer) -> c_int
            = (f.fmi2FreeFMUstate)(c, state), (f.fmi3FreeFMUState)(c, state);
        fn serialized_fmu_state_size(c: Pointer, state: Pointer, size: *mut usize) -> c_int
            = (f.fmi2SerializedFMUstateSize)(c, state, size),
            (f.fmi3SerializedFMUStateSize)(c, state, size);
        fn serialize_fmu_state(c: Pointer, state: Pointer, bytes: *mut u8, size: usize) -> c_int
            = (f.fmi2SerializeFMUstate)(c, state, bytes, size),
            (f.fmi3SerializeFMUState)(c, state, bytes, size);
        fn deserialize_fmu_state(c: Pointer, bytes: *const u8, size: usize, state: *mut Pointer)
            -> c_int
            = (f.fmi2DeSerializeFMUstate)(c, bytes, size, state),
            (f.fmi3DeserializeFMUState)(c, bytes, size, state);
    }

    both! { self, f:
        fn enter_event_mode(c: Pointer) -> c_int = (f.fmi2EnterEventMode)(c), (f.fmi3EnterEventMode)(c);
        fn enter_continuous_time_mode(c: Pointer) -> c_int
            = (f.fmi2EnterContinuousTimeMode)(c), (f.fmi3EnterContinuousTimeMode)(c);
        fn set_time(c: Pointer, t: f64) -> c_int = (f.fmi2SetTime)(c, t), (f.fmi3SetTime)(c, t);
        fn set_continuous_states(c: Pointer, x: *const f64, n: usize) -> c_int
            = (f.fmi2SetContinuousStates)(c, x, n), (f.fmi3SetContinuousStates)(c, x, n);
        fn get_continuous_states(c: Pointer, x: *mut f64, n: usize) -> c_int
            = (f.fmi2GetContinuousStates)(c, x, n), (f.fmi3GetContinuousStates)(c, x, n);
        fn get_derivatives(c: Pointer, x: *mut f64, n: usize) -> c_int
            = (f.fmi2GetDerivatives)(c, x, n), (f.fmi3GetContinuousStateDerivatives)(c, x, n);
        fn get_event_indicators(c: Pointer, x: *mut f64, n: usize) -> c_int
            = (f.fmi2GetEventIndicators)(c, x, n), (f.fmi3GetEventIndicators)(c, x, n);
        fn get_nominals(c: Pointer, x: *mut f64, n: usize) -> c_int
            = (f.fmi2GetNominalsOfContinuousStates)(c, x, n), (f.fmi3GetNominalsOfContinuousStates)(c, x, n);
    }

    // FMI 3.0 is told the number of values, too.
    both! { self, f:
        fn get_real(c: Pointer, vr: *const u32, n: usize, values: *mut f64) -> c_int
            = (f.fmi2GetReal)(c, vr, n, values),
            (f.fmi3GetFloat64)(c, vr, n, values, self.counted(vr, n));
        fn set_real(c: Pointer, vr: *const u32, n: usize, values: *const f64) -> c_int
            = (f.fmi2SetReal)(c, vr, n, values),
            (f.fmi3SetFloat64)(c, vr, n, values, self.counted(vr, n));
        fn get_string(c: Pointer, vr: *const u32, n: usize, values: *mut Text) -> c_int
            = (f.fmi2GetString)(c, vr, n, values),
            (f.fmi3GetString)(c, vr, n, values, self.counted(vr, n));
        fn set_string(c: Pointer, vr: *const u32, n: usize, values: *const Text) -> c_int
            = (f.fmi2SetString)(c, vr, n, values),
            (f.fmi3SetString)(c, vr, n, values, self.counted(vr, n));
        fn get_output_derivatives(
            c: Pointer, vr: *const u32, n: usize, order: *const c_int, values: *mut f64
        ) -> c_int
            = (f.fmi2GetRealOutputDerivatives)(c, vr, n, order, values),
            (f.fmi3GetOutputDerivatives)(c, vr, n, order, values, self.counted(vr, n));
        /// Not in FMI 3.0, where nothing is called.
        fn set_input_derivatives(
            c: Pointer, vr: *const u32, n: usize, order: *const c_int, values: *const f64
        ) -> c_int
            = (f.fmi2SetRealInputDerivatives)(c, vr, n, order, values), DISCARD;
        fn get_directional_derivative(
            c: Pointer, unknown: *const u32, n: usize, known: *const u32, m: usize,
            seed: *const f64, result: *mut f64
        ) -> c_int
            = (f.fmi2GetDirectionalDerivative)(c, unknown, n, known, m, seed, result),
            (f.fmi3GetDirectionalDerivative)(
                c, unknown, n, known, m,
                seed, self.counted(known, m), result, self.counted(unknown, n)
            );
    }

    /// With a `kind` other than 1 for model exchange. In FMI 3.0 with Event Mode; what is no
    /// argument there is not looked at.
    pub unsafe fn instantiate(
        &self,
        name: Text,
        kind: c_int,
        token: Text,
        resources: Text,
        callbacks: *const Callbacks,
        visible: c_int,
        logging: c_int,
    ) -> Pointer {
        // SAFETY: forwarded.
        unsafe {
            match &self.own {
                Fmi2(f) => {
                    (f.fmi2Instantiate)(name, kind, token, resources, callbacks, visible, logging)
                }
                Fmi3(f) => {
                    let (visible, logging) = (visible != 0, logging != 0);
                    let callbacks = callbacks.as_ref();
                    let environment = callbacks.map_or(ptr::null_mut(), |c| c.environment);
                    let has_logger = callbacks.is_some_and(|c| !c.logger.is_null());
                    let logger = has_logger.then_some(logger_3 as Logger);
                    match kind {
                        1 => (f.fmi3InstantiateCoSimulation)(
                            name,
                            token,
                            resources,
                            visible,
                            logging,
                            self.has_event_mode,
                            false,
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
                            visible,
                            logging,
                            environment,
                            logger,
                        ),
                    }
                }
            }
        }
    }

    /// From Event Mode of Model Exchange: new discrete states until none is needed, at most a thousand
    /// times; then into Continuous-Time Mode. What is told is the time of the next event, infinite
    /// where none is known, and whether the simulation ends.
    pub unsafe fn handle_events(&self, c: Pointer, next: &mut f64, ends: &mut bool) -> c_int {
        for _ in 0..1000 {
            let mut info = EventInfo::default();
            let ([mut again, mut end, mut nominals, mut moved, mut defined], mut time) =
                ([false; 5], 0.0);
            // SAFETY: forwarded; places for the results.
            let status = unsafe {
                match &self.own {
                    Fmi2(f) => (f.fmi2NewDiscreteStates)(c, ptr::from_mut(&mut info).cast()),
                    Fmi3(f) => (f.fmi3UpdateDiscreteStates)(
                        c,
                        &mut again,
                        &mut end,
                        &mut nominals,
                        &mut moved,
                        &mut defined,
                        &mut time,
                    ),
                }
            };
            if status > WARNING {
                return status;
            }
            let [needed, _, _, _, is_known] = info.flags.map(|flag| flag != 0);
            *ends = end || info.flags[1] != 0;
            *next = match (is_known, defined) {
                (true, _) => info.next,
                (_, true) => time,
                _ => f64::INFINITY,
            };
            if !(needed || again) {
                break;
            }
        }
        // SAFETY: forwarded.
        unsafe { self.enter_continuous_time_mode(c) }
    }

    both! { self, f:
        /// Whether an event must be handled, and whether the simulation ends.
        fn completed_integrator_step(c: Pointer, told: &mut [bool; 2]) -> c_int = {
            let mut flags: [c_int; 2] = [0; 2];
            let [event, ends] = flags.each_mut();
            let status = (f.fmi2CompletedIntegratorStep)(c, 1, event, ends);
            *told = flags.map(|flag| flag != 0);
            status
        }, {
            let [event, ends] = told;
            (f.fmi3CompletedIntegratorStep)(c, true, event, ends)
        };
        /// fmi2SetupExperiment, or fmi3EnterInitializationMode with the same arguments.
        fn begin(c: Pointer, experiment: Experiment) -> c_int = {
            let Experiment { has_tolerance, tolerance, start, has_stop, stop } = experiment;
            let [has_tolerance, has_stop] = [has_tolerance, has_stop].map(c_int::from);
            (f.fmi2SetupExperiment)(c, has_tolerance, tolerance, start, has_stop, stop)
        }, {
            let Experiment { has_tolerance, tolerance, start, has_stop, stop } = experiment;
            (f.fmi3EnterInitializationMode)(c, has_tolerance, tolerance, start, has_stop, stop)
        };
        /// In FMI 3.0 a step that must be whole.
        fn do_step(c: Pointer, t: f64, h: f64, no_set_prior: c_int) -> c_int
            = (f.fmi2DoStep)(c, t, h, no_set_prior), {
                let ([mut event, mut ends, mut early], mut time) = ([false; 3], f64::NAN);
                let no_set_prior = no_set_prior != 0;
                (f.fmi3DoStep)(c, t, h, no_set_prior, &mut event, &mut ends, &mut early, &mut time)
            };
    }

    /// FMI 3.0: from Event Mode to Step Mode, where steps are made; else nothing.
    pub unsafe fn leave_events(&self, c: Pointer) -> c_int {
        let Fmi3(f) = &self.own else { return OK };
        if !self.has_event_mode {
            return OK;
        }
        let ([mut a, mut b, mut d, mut e, mut g], mut next) = ([false; 5], 0.0);
        // SAFETY: forwarded; places for the results.
        unsafe {
            match (f.fmi3UpdateDiscreteStates)(c, &mut a, &mut b, &mut d, &mut e, &mut g, &mut next)
            {
                OK | WARNING => (f.fmi3EnterStepMode)(c),
                status => status,
            }
        }
    }

    /// FMI 3.0: from Step Mode to Event Mode, where values are exchanged; else nothing.
    pub unsafe fn enter_events(&self, c: Pointer) -> c_int {
        match &self.own {
            // SAFETY: forwarded.
            Fmi3(f) if self.has_event_mode => unsafe { (f.fmi3EnterEventMode)(c) },
            _ => OK,
        }
    }

    /// Time of the last communication point: fmi2GetRealStatus, or the independent variable.
    pub unsafe fn last_time(&self, c: Pointer, time: &mut f64) -> c_int {
        // SAFETY: forwarded.
        unsafe {
            match (&self.own, self.time) {
                (Fmi2(f), _) => (f.fmi2GetRealStatus)(c, 2, time),
                (Fmi3(f), Some(vr)) => (f.fmi3GetFloat64)(c, &vr, 1, time, 1),
                (Fmi3(_), None) => DISCARD,
            }
        }
    }
}
