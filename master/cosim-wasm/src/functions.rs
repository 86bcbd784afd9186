//! The C functions of FMI 3.0 for an instance of a component: each calls the method of its name, and
//! copies what that gives. Whatever ends the instance, such as a trap, is a message and Fatal.
#![allow(unsafe_code, non_snake_case)] // C calls in; named as in the standard

use std::ffi::{CStr, CString, c_int, c_void};
use std::{ptr, slice};

use fmi_import::standard::{Logger, Pointer, Text};
use wasmtime::Result;

use crate::component::{Arguments, DependencyKind, Guest, Instance, IntervalFraction, Status};

/// The C function of this name.
pub fn named(name: &str) -> Option<*const c_void> {
    macro_rules! all {
        ($($function:ident $interface:ident [$($states:tt)*] ($($type:ty),*) $(-> $result:ty)?;)*) => {
            match name {
                $(stringify!($function) => {
                    let function: unsafe extern "C" fn($($type),*) $(-> $result)? = $function;
                    Some(function as *const c_void)
                })*
                _ => None,
            }
        };
    }
    fmi_import::fmi3_functions!(all!)
}

/// What a call of the component gives: an error ends the instance.
type Given<T> = Result<std::result::Result<T, Status>>;

/// An array of an importer.
unsafe fn list<'a, T>(at: *const T, count: usize) -> &'a [T] {
    // SAFETY: by FMI there are so many; of none, it may be NULL.
    if count == 0 { &[] } else { unsafe { slice::from_raw_parts(at, count) } }
}

/// Lets an instance do something; returns its status.
unsafe fn with(this: Pointer, run: impl FnOnce(&mut Instance) -> Result<Status>) -> c_int {
    // SAFETY: an instance that was made below, which one thread uses at a time.
    let Some(instance) = (unsafe { this.cast::<Instance>().as_mut() }) else {
        return Status::Error as c_int;
    };
    let status = run(instance).unwrap_or_else(|error| {
        let text = format!("{:#}", error.root_cause());
        instance.store.data().log(Status::Fatal, "logStatusFatal", &text);
        Status::Fatal
    });
    status as c_int
}

/// Lets an instance give something, which `take` takes; returns its status.
unsafe fn read<T>(
    this: Pointer,
    run: impl FnOnce(&mut Instance) -> Given<T>,
    take: impl FnOnce(&mut Instance, T) -> Status,
) -> c_int {
    let done = |instance: &mut Instance| match run(instance)? {
        Ok(given) => Ok(take(instance, given)),
        Err(status) => Ok(status),
    };
    // SAFETY: forwarded.
    unsafe { with(this, done) }
}

impl Instance {
    /// Copies values to an array of so many.
    unsafe fn copy<T: Copy>(&mut self, given: &[T], to: *mut T, count: usize) -> Status {
        if given.len() != count {
            let text = format!("the component gave {} values instead of {count}", given.len());
            self.store.data().log(Status::Error, "logStatusError", &text);
            return Status::Error;
        }
        // SAFETY: by FMI there is room for so many.
        unsafe { ptr::copy_nonoverlapping(given.as_ptr(), to, count) };
        Status::Ok
    }
}

/// Calls a method that both interfaces have.
macro_rules! call {
    ($instance:expr, $method:ident $(, $argument:expr)*) => {{
        let Instance { store, guest, this, .. } = $instance;
        match guest {
            Guest::CoSimulation(guest) => {
                guest.co_simulation_instance().$method(store, *this $(, $argument)*)
            }
            Guest::ModelExchange(guest) => {
                guest.model_exchange_instance().$method(store, *this $(, $argument)*)
            }
        }
    }};
}

/// Calls a method of Model Exchange.
macro_rules! exchange {
    ($instance:expr, $method:ident $(, $argument:expr)*) => {{
        let Instance { store, guest, this, .. } = $instance;
        let Guest::ModelExchange(guest) = guest else {
            wasmtime::bail!("the instance is not for Model Exchange");
        };
        guest.model_exchange_instance().$method(store, *this $(, $argument)*)
    }};
}

/// Defines functions of the same arguments: a name, the method and what differs.
macro_rules! functions {
    (plain $call:ident $($name:ident $method:ident;)*) => {$(
        unsafe extern "C" fn $name(this: Pointer) -> c_int {
            // SAFETY: FMI's promise, as in all of these.
            unsafe { with(this, |i| $call!(i, $method)) }
        }
    )*};
    (get $($name:ident $method:ident $type:ty;)*) => {$(
        unsafe extern "C" fn $name(
            this: Pointer, vr: *const u32, n: usize, to: *mut $type, count: usize,
        ) -> c_int {
            // SAFETY: as above.
            unsafe { read(this, |i| call!(i, $method, list(vr, n)), |i, given| i.copy(&given, to, count)) }
        }
    )*};
    (set $($name:ident $method:ident $type:ty;)*) => {$(
        unsafe extern "C" fn $name(
            this: Pointer, vr: *const u32, n: usize, values: *const $type, count: usize,
        ) -> c_int {
            // SAFETY: as above.
            unsafe { with(this, |i| call!(i, $method, list(vr, n), list(values, count))) }
        }
    )*};
    (set_clock $($name:ident $method:ident $type:ty;)*) => {$(
        unsafe extern "C" fn $name(
            this: Pointer, vr: *const u32, n: usize, values: *const $type,
        ) -> c_int {
            // SAFETY: as above.
            unsafe { with(this, |i| call!(i, $method, list(vr, n), list(values, n))) }
        }
    )*};
    (set_fraction $($name:ident $method:ident;)*) => {$(
        unsafe extern "C" fn $name(
            this: Pointer, vr: *const u32, n: usize, counters: *const u64, resolutions: *const u64,
        ) -> c_int {
            // SAFETY: as above.
            let [counters, resolutions] = unsafe { [counters, resolutions].map(|at| list(at, n)) };
            let pairs = counters.iter().zip(resolutions);
            let pairs = pairs.map(|(&counter, &resolution)| IntervalFraction { counter, resolution });
            let pairs: Vec<_> = pairs.collect();
            // SAFETY: as above.
            unsafe { with(this, |i| call!(i, $method, list(vr, n), &pairs)) }
        }
    )*};
    (vector $($name:ident $method:ident;)*) => {$(
        unsafe extern "C" fn $name(this: Pointer, to: *mut f64, count: usize) -> c_int {
            // SAFETY: as above.
            unsafe { read(this, |i| exchange!(i, $method), |i, given| i.copy(&given, to, count)) }
        }
    )*};
    (number $($name:ident $method:ident;)*) => {$(
        unsafe extern "C" fn $name(this: Pointer, to: *mut usize) -> c_int {
            // SAFETY: as above.
            unsafe { read(this, |i| exchange!(i, $method), |i, count| i.copy(&[count as usize], to, 1)) }
        }
    )*};
    (derivative $($name:ident $method:ident;)*) => {$(
        unsafe extern "C" fn $name(
            this: Pointer, of: *const u32, n_of: usize, along: *const u32, n_along: usize,
            seeds: *const f64, n_seeds: usize, to: *mut f64, count: usize,
        ) -> c_int {
            // SAFETY: as above.
            unsafe {
                let [of, along] = [(of, n_of), (along, n_along)].map(|(at, n)| list(at, n));
                let run = |i: &mut Instance| call!(i, $method, of, along, list(seeds, n_seeds));
                read(this, run, |i, given| i.copy(&given, to, count))
            }
        }
    )*};
}

functions! { plain call
    fmi3ExitInitializationMode call_exit_initialization_mode;
    fmi3EnterEventMode call_enter_event_mode;
    fmi3Terminate call_terminate;
    fmi3Reset call_reset;
    fmi3EnterConfigurationMode call_enter_configuration_mode;
    fmi3ExitConfigurationMode call_exit_configuration_mode;
    fmi3EvaluateDiscreteStates call_evaluate_discrete_states;
    fmi3EnterStepMode call_enter_step_mode;
}
functions! { plain exchange
    fmi3EnterContinuousTimeMode call_enter_continuous_time_mode;
}
functions! { get
    fmi3GetFloat32 call_get_float32 f32;
    fmi3GetFloat64 call_get_float64 f64;
    fmi3GetInt8 call_get_int8 i8;
    fmi3GetUInt8 call_get_uint8 u8;
    fmi3GetInt16 call_get_int16 i16;
    fmi3GetUInt16 call_get_uint16 u16;
    fmi3GetInt32 call_get_int32 i32;
    fmi3GetUInt32 call_get_uint32 u32;
    fmi3GetInt64 call_get_int64 i64;
    fmi3GetUInt64 call_get_uint64 u64;
    fmi3GetBoolean call_get_boolean bool;
}
functions! { set
    fmi3SetFloat32 call_set_float32 f32;
    fmi3SetFloat64 call_set_float64 f64;
    fmi3SetInt8 call_set_int8 i8;
    fmi3SetUInt8 call_set_uint8 u8;
    fmi3SetInt16 call_set_int16 i16;
    fmi3SetUInt16 call_set_uint16 u16;
    fmi3SetInt32 call_set_int32 i32;
    fmi3SetUInt32 call_set_uint32 u32;
    fmi3SetInt64 call_set_int64 i64;
    fmi3SetUInt64 call_set_uint64 u64;
    fmi3SetBoolean call_set_boolean bool;
}
functions! { set_clock
    fmi3SetClock call_set_clock bool;
    fmi3SetIntervalDecimal call_set_interval_decimal f64;
    fmi3SetShiftDecimal call_set_shift_decimal f64;
}
functions! { set_fraction
    fmi3SetIntervalFraction call_set_interval_fraction;
    fmi3SetShiftFraction call_set_shift_fraction;
}
functions! { vector
    fmi3GetContinuousStates call_get_continuous_states;
    fmi3GetContinuousStateDerivatives call_get_continuous_state_derivatives;
    fmi3GetEventIndicators call_get_event_indicators;
    fmi3GetNominalsOfContinuousStates call_get_nominals_of_continuous_states;
}
functions! { number
    fmi3GetNumberOfEventIndicators call_get_number_of_event_indicators;
    fmi3GetNumberOfContinuousStates call_get_number_of_continuous_states;
}
functions! { derivative
    fmi3GetDirectionalDerivative call_get_directional_derivative;
    fmi3GetAdjointDerivative call_get_adjoint_derivative;
}

extern "C" fn fmi3GetVersion() -> Text {
    c"3.0".as_ptr()
}

/// An instance for Co-Simulation, or without more arguments for Model Exchange; NULL if there is
/// none.
unsafe fn instantiate(
    texts: [Text; 2],
    is_logging: bool,
    environment: Pointer,
    logger: Option<Logger>,
    kind: Option<([bool; 2], &[u32])>,
) -> Pointer {
    // SAFETY: C strings.
    let texts = texts.map(|text| unsafe { CStr::from_ptr(text) });
    let arguments = Arguments { texts, is_logging, environment, logger };
    Instance::new(arguments, kind).map_or(ptr::null_mut(), |made| Box::into_raw(made).cast())
}

unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: Text,
    token: Text,
    _resources: Text,
    _visible: bool,
    is_logging: bool,
    environment: Pointer,
    logger: Option<Logger>,
) -> Pointer {
    // SAFETY: forwarded.
    unsafe { instantiate([name, token], is_logging, environment, logger, None) }
}

unsafe extern "C" fn fmi3InstantiateCoSimulation(
    name: Text,
    token: Text,
    _resources: Text,
    _visible: bool,
    is_logging: bool,
    has_events: bool,
    returns_early: bool,
    variables: *const u32,
    count: usize,
    environment: Pointer,
    logger: Option<Logger>,
    _update: Pointer,
) -> Pointer {
    // SAFETY: forwarded.
    unsafe {
        let kind = Some(([has_events, returns_early], list(variables, count)));
        instantiate([name, token], is_logging, environment, logger, kind)
    }
}

extern "C" fn fmi3InstantiateScheduledExecution(
    _name: Text,
    _token: Text,
    _resources: Text,
    _visible: bool,
    _is_logging: bool,
    _environment: Pointer,
    _logger: Option<Logger>,
    _update: Pointer,
    _lock: Pointer,
    _unlock: Pointer,
) -> Pointer {
    ptr::null_mut()
}

extern "C" fn fmi3ActivateModelPartition(_: Pointer, _: u32, _: f64) -> c_int {
    Status::Error as c_int
}

unsafe extern "C" fn fmi3FreeInstance(this: Pointer) {
    if this.is_null() {
        return;
    }
    // SAFETY: an instance that was made above, which is not used any more.
    let mut instance = unsafe { Box::from_raw(this.cast::<Instance>()) };
    let Instance { store, this, .. } = &mut *instance;
    let _ = this.resource_drop(store); // after a trap nothing can be done with it
}

unsafe extern "C" fn fmi3SetDebugLogging(
    this: Pointer,
    on: bool,
    count: usize,
    categories: *const Text,
) -> c_int {
    // SAFETY: C strings.
    unsafe {
        let categories = texts(list(categories, count));
        with(this, |i| call!(i, call_set_debug_logging, on, &categories))
    }
}

unsafe extern "C" fn fmi3EnterInitializationMode(
    this: Pointer,
    has_tolerance: bool,
    tolerance: f64,
    start: f64,
    has_stop: bool,
    stop: f64,
) -> c_int {
    let (tolerance, stop) = (has_tolerance.then_some(tolerance), has_stop.then_some(stop));
    // SAFETY: as above.
    unsafe { with(this, |i| call!(i, call_enter_initialization_mode, tolerance, start, stop)) }
}

/// C strings as texts.
unsafe fn texts(all: &[Text]) -> Vec<String> {
    // SAFETY: C strings.
    let text = |text: &Text| unsafe { CStr::from_ptr(*text) }.to_string_lossy().into_owned();
    all.iter().map(text).collect()
}

unsafe extern "C" fn fmi3GetString(
    this: Pointer,
    vr: *const u32,
    n: usize,
    to: *mut Text,
    count: usize,
) -> c_int {
    let take = |i: &mut Instance, given: Vec<String>| {
        let texts = given.into_iter().map(|text| CString::new(text).unwrap_or_default());
        i.texts = texts.collect();
        let at: Vec<Text> = i.texts.iter().map(|text| text.as_ptr()).collect();
        // SAFETY: forwarded.
        unsafe { i.copy(&at, to, count) }
    };
    // SAFETY: as above.
    unsafe { read(this, |i| call!(i, call_get_string, list(vr, n)), take) }
}

unsafe extern "C" fn fmi3SetString(
    this: Pointer,
    vr: *const u32,
    n: usize,
    values: *const Text,
    count: usize,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        let values = texts(list(values, count));
        with(this, |i| call!(i, call_set_string, list(vr, n), &values))
    }
}

unsafe extern "C" fn fmi3GetBinary(
    this: Pointer,
    vr: *const u32,
    n: usize,
    sizes: *mut usize,
    to: *mut *const u8,
    count: usize,
) -> c_int {
    let take = |i: &mut Instance, given: Vec<Vec<u8>>| {
        let (lengths, at): (Vec<usize>, Vec<*const u8>) =
            given.iter().map(|bytes| (bytes.len(), bytes.as_ptr())).unzip();
        i.bytes = given;
        // SAFETY: forwarded.
        unsafe {
            i.copy(&lengths, sizes, count);
            i.copy(&at, to, count)
        }
    };
    // SAFETY: as above.
    unsafe { read(this, |i| call!(i, call_get_binary, list(vr, n)), take) }
}

unsafe extern "C" fn fmi3SetBinary(
    this: Pointer,
    vr: *const u32,
    n: usize,
    sizes: *const usize,
    values: *const *const u8,
    count: usize,
) -> c_int {
    // SAFETY: as above, and so many bytes each.
    unsafe {
        let values = list(values, count).iter().zip(list(sizes, count));
        let values: Vec<Vec<u8>> = values.map(|(at, size)| list(*at, *size).to_vec()).collect();
        with(this, |i| call!(i, call_set_binary, list(vr, n), &values))
    }
}

unsafe extern "C" fn fmi3GetClock(this: Pointer, vr: *const u32, n: usize, to: *mut bool) -> c_int {
    // SAFETY: as above.
    unsafe { read(this, |i| call!(i, call_get_clock, list(vr, n)), |i, given| i.copy(&given, to, n)) }
}

unsafe extern "C" fn fmi3GetIntervalDecimal(
    this: Pointer,
    vr: *const u32,
    n: usize,
    to: *mut f64,
    qualifiers: *mut c_int,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        read(this, |i| call!(i, call_get_interval_decimal, list(vr, n)), |i, given| {
            let (intervals, kinds): (Vec<_>, Vec<_>) =
                given.into_iter().map(|(interval, kind)| (interval, kind as c_int)).unzip();
            i.copy(&kinds, qualifiers, n);
            i.copy(&intervals, to, n)
        })
    }
}

impl Instance {
    /// Copies fractions to two arrays of so many.
    unsafe fn split(&mut self, given: Vec<IntervalFraction>, to: [*mut u64; 2], n: usize) -> Status {
        let (counters, resolutions): (Vec<_>, Vec<_>) =
            given.into_iter().map(|fraction| (fraction.counter, fraction.resolution)).unzip();
        // SAFETY: forwarded.
        unsafe {
            self.copy(&counters, to[0], n);
            self.copy(&resolutions, to[1], n)
        }
    }
}

unsafe extern "C" fn fmi3GetIntervalFraction(
    this: Pointer,
    vr: *const u32,
    n: usize,
    counters: *mut u64,
    resolutions: *mut u64,
    qualifiers: *mut c_int,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        read(this, |i| call!(i, call_get_interval_fraction, list(vr, n)), |i, given| {
            let (fractions, kinds): (Vec<_>, Vec<_>) =
                given.into_iter().map(|(fraction, kind)| (fraction, kind as c_int)).unzip();
            i.copy(&kinds, qualifiers, n);
            i.split(fractions, [counters, resolutions], n)
        })
    }
}

unsafe extern "C" fn fmi3GetShiftDecimal(this: Pointer, vr: *const u32, n: usize, to: *mut f64) -> c_int {
    // SAFETY: as above.
    unsafe { read(this, |i| call!(i, call_get_shift_decimal, list(vr, n)), |i, given| i.copy(&given, to, n)) }
}

unsafe extern "C" fn fmi3GetShiftFraction(
    this: Pointer,
    vr: *const u32,
    n: usize,
    counters: *mut u64,
    resolutions: *mut u64,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        read(this, |i| call!(i, call_get_shift_fraction, list(vr, n)), |i, given| {
            i.split(given, [counters, resolutions], n)
        })
    }
}

unsafe extern "C" fn fmi3GetNumberOfVariableDependencies(
    this: Pointer,
    vr: u32,
    to: *mut usize,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        read(this, |i| call!(i, call_get_number_of_variable_dependencies, vr), |i, count| {
            i.copy(&[count as usize], to, 1)
        })
    }
}

unsafe extern "C" fn fmi3GetVariableDependencies(
    this: Pointer,
    vr: u32,
    dependent: *mut usize,
    independents: *mut u32,
    elements: *mut usize,
    kinds: *mut c_int,
    count: usize,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        read(this, |i| call!(i, call_get_variable_dependencies, vr), |i, given| {
            // Elements count from 0 there, and from 1 here.
            let number = |index: u32| index as usize + 1;
            let kind = |kind: DependencyKind| match kind {
                DependencyKind::Dependent => 5,
                other => other as c_int,
            };
            let all = given.iter();
            i.copy(&Vec::from_iter(all.clone().map(|d| number(d.element_index_of_dependent))), dependent, count);
            i.copy(&Vec::from_iter(all.clone().map(|d| d.independent_value_reference)), independents, count);
            i.copy(&Vec::from_iter(all.clone().map(|d| number(d.element_index_of_independent))), elements, count);
            i.copy(&Vec::from_iter(all.map(|d| kind(d.kind))), kinds, count)
        })
    }
}

/// A saved state is its bytes.
type State = Vec<u8>;

unsafe fn keep(state: &[u8], to: *mut Pointer) -> Status {
    // SAFETY: by FMI there is room for it.
    unsafe { to.write(Box::into_raw(Box::<State>::new(state.to_vec())).cast()) };
    Status::Ok
}

unsafe extern "C" fn fmi3GetFMUState(this: Pointer, to: *mut Pointer) -> c_int {
    // SAFETY: as above.
    unsafe { read(this, |i| call!(i, call_get_fmu_state), |_, given| keep(&given, to)) }
}

unsafe extern "C" fn fmi3SetFMUState(this: Pointer, state: Pointer) -> c_int {
    // SAFETY: a state that was kept, and as above.
    unsafe { with(this, |i| call!(i, call_set_fmu_state, &*state.cast::<State>())) }
}

unsafe extern "C" fn fmi3FreeFMUState(_: Pointer, state: *mut Pointer) -> c_int {
    // SAFETY: NULL or a state that was kept, which is not used any more.
    unsafe {
        let state = state.replace(ptr::null_mut());
        if !state.is_null() {
            drop(Box::from_raw(state.cast::<State>()));
        }
    }
    Status::Ok as c_int
}

unsafe extern "C" fn fmi3SerializedFMUStateSize(_: Pointer, state: Pointer, to: *mut usize) -> c_int {
    // SAFETY: a state that was kept, and room for its size.
    unsafe { to.write((*state.cast::<State>()).len()) };
    Status::Ok as c_int
}

unsafe extern "C" fn fmi3SerializeFMUState(this: Pointer, state: Pointer, to: *mut u8, size: usize) -> c_int {
    // SAFETY: a state that was kept, and room for so many bytes.
    unsafe { with(this, |i| Ok(i.copy(&*state.cast::<State>(), to, size))) }
}

unsafe extern "C" fn fmi3DeserializeFMUState(
    _: Pointer,
    bytes: *const u8,
    size: usize,
    to: *mut Pointer,
) -> c_int {
    // SAFETY: so many bytes.
    unsafe { keep(list(bytes, size), to) as c_int }
}

unsafe extern "C" fn fmi3UpdateDiscreteStates(
    this: Pointer,
    again: *mut bool,
    terminates: *mut bool,
    nominals: *mut bool,
    values: *mut bool,
    has_next: *mut bool,
    next: *mut f64,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        read(this, |i| call!(i, call_update_discrete_states), |_, info| {
            again.write(info.new_discrete_states_needed);
            terminates.write(info.terminate_simulation);
            nominals.write(info.nominals_of_continuous_states_changed);
            values.write(info.values_of_continuous_states_changed);
            has_next.write(info.next_event_time_defined);
            next.write(info.next_event_time);
            Status::Ok
        })
    }
}

unsafe extern "C" fn fmi3GetOutputDerivatives(
    this: Pointer,
    vr: *const u32,
    n: usize,
    orders: *const c_int,
    to: *mut f64,
    count: usize,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        let orders = list(orders, n).iter().map(|order| order.cast_unsigned());
        let wanted: Vec<_> = list(vr, n).iter().copied().zip(orders).collect();
        read(this, |i| call!(i, call_get_output_derivatives, &wanted), |i, given| {
            i.copy(&given, to, count)
        })
    }
}

unsafe extern "C" fn fmi3DoStep(
    this: Pointer,
    t: f64,
    h: f64,
    no_set_prior: bool,
    event_needed: *mut bool,
    terminates: *mut bool,
    early: *mut bool,
    last: *mut f64,
) -> c_int {
    let run = |i: &mut Instance| {
        let Instance { store, guest, this, .. } = i;
        let Guest::CoSimulation(guest) = guest else {
            wasmtime::bail!("the instance is not for Co-Simulation");
        };
        guest.co_simulation_instance().call_do_step(store, *this, t, h, no_set_prior)
    };
    // SAFETY: as above.
    unsafe {
        read(this, run, |_, end| {
            event_needed.write(end.event_handling_needed);
            terminates.write(end.terminate_simulation);
            early.write(end.early_return);
            last.write(end.last_successful_time);
            Status::Ok
        })
    }
}

unsafe extern "C" fn fmi3CompletedIntegratorStep(
    this: Pointer,
    no_set_prior: bool,
    enters_events: *mut bool,
    terminates: *mut bool,
) -> c_int {
    // SAFETY: as above.
    unsafe {
        let run = |i: &mut Instance| exchange!(i, call_completed_integrator_step, no_set_prior);
        read(this, run, |_, end| {
            enters_events.write(end.enter_event_mode);
            terminates.write(end.terminate_simulation);
            Status::Ok
        })
    }
}

unsafe extern "C" fn fmi3SetTime(this: Pointer, time: f64) -> c_int {
    // SAFETY: as above.
    unsafe { with(this, |i| exchange!(i, call_set_time, time)) }
}

unsafe extern "C" fn fmi3SetContinuousStates(this: Pointer, states: *const f64, n: usize) -> c_int {
    // SAFETY: as above.
    unsafe { with(this, |i| exchange!(i, call_set_continuous_states, list(states, n))) }
}
