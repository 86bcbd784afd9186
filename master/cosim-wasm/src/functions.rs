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
    if count == 0 {
        &[]
    } else {
        unsafe { slice::from_raw_parts(at, count) }
    }
}

/// Lets an instance do something; returns its status.
unsafe fn with(this: Pointer, run: impl FnOnce(&mut Instance) -> Result<Status>) -> c_int {
    // SAFETY: an instance that was made below, which one thread uses at a time.
    let Some(instance) = (unsafe { this.cast::<Instance>().as_mut() }) else {
        return Status::Error as c_int;
    };
    let status = run(instance).unwrap_or_else(|error| {
        let text = format!("{:#}", error.root_cause());
        instance
            .store
            .data()
            .log(Status::Fatal, "logStatusFatal", &text);
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
            let text = format!(
                "the component gave {} values instead of {count}",
                given.len()
            );
            self.store
                .data()
                .log(Status::Error, "logStatusError", &text);
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
        match guest {
            Guest::ModelExchange(guest) => {
                guest.model_exchange_instance().$method(store, *this $(, $argument)*)
            }
            Guest::CoSimulation(_) => wasmtime::bail!("the instance is for Co-Simulation"),
        }
    }};
}

/// Defines functions that return a status: name, arguments, what the instance does, and for what it
/// gives then, how that is taken. Those of the same arguments are listed with the method and the
/// type.
macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),*) = $run:expr $(, $take:expr)?;)*) => {$(
        unsafe extern "C" fn $name(this: Pointer $(, $argument: $type)*) -> c_int {
            // SAFETY: what FMI promises of the instance and of all arguments.
            unsafe { functions!(@do this, $run $(, $take)?) }
        }
    )*};
    (@do $this:ident, $run:expr) => { with($this, $run) };
    (@do $this:ident, $run:expr, $take:expr) => { read($this, $run, $take) };
    (get $($name:ident $method:ident $type:ty;)*) => { functions! {
        $($name(vr: *const u32, n: usize, to: *mut $type, count: usize)
            = |i| call!(i, $method, list(vr, n)), |i, given| i.copy(&given, to, count);)*
    } };
    (set $($name:ident $method:ident $type:ty;)*) => { functions! {
        $($name(vr: *const u32, n: usize, values: *const $type, count: usize)
            = |i| call!(i, $method, list(vr, n), list(values, count));)*
    } };
    (vector $($name:ident $method:ident;)*) => { functions! {
        $($name(to: *mut f64, count: usize)
            = |i| exchange!(i, $method), |i, given| i.copy(&given, to, count);)*
    } };
    (derivative $($name:ident $method:ident;)*) => { functions! {
        $($name(
            of: *const u32, n_of: usize, along: *const u32, n_along: usize, seeds: *const f64,
            n_seeds: usize, to: *mut f64, count: usize
        ) = |i| call!(i, $method, list(of, n_of), list(along, n_along), list(seeds, n_seeds)),
            |i, given| i.copy(&given, to, count);)*
    } };
}

functions! {
    fmi3SetDebugLogging(on: bool, n: usize, categories: *const Text)
        = |i| call!(i, call_set_debug_logging, on, &texts(list(categories, n)));
    fmi3EnterInitializationMode(has_tolerance: bool, tolerance: f64, start: f64, has_stop: bool, stop: f64)
        = |i| {
            let (tolerance, stop) = (has_tolerance.then_some(tolerance), has_stop.then_some(stop));
            call!(i, call_enter_initialization_mode, tolerance, start, stop)
        };
    fmi3ExitInitializationMode() = |i| call!(i, call_exit_initialization_mode);
    fmi3EnterEventMode() = |i| call!(i, call_enter_event_mode);
    fmi3Terminate() = |i| call!(i, call_terminate);
    fmi3Reset() = |i| call!(i, call_reset);
    fmi3EnterConfigurationMode() = |i| call!(i, call_enter_configuration_mode);
    fmi3ExitConfigurationMode() = |i| call!(i, call_exit_configuration_mode);
    fmi3EvaluateDiscreteStates() = |i| call!(i, call_evaluate_discrete_states);
    fmi3EnterStepMode() = |i| call!(i, call_enter_step_mode);
    fmi3UpdateDiscreteStates(
        again: *mut bool, terminates: *mut bool, nominals: *mut bool, values: *mut bool,
        has_next: *mut bool, next: *mut f64
    ) = |i| call!(i, call_update_discrete_states), |_, info| {
        again.write(info.new_discrete_states_needed);
        terminates.write(info.terminate_simulation);
        nominals.write(info.nominals_of_continuous_states_changed);
        values.write(info.values_of_continuous_states_changed);
        has_next.write(info.next_event_time_defined);
        next.write(info.next_event_time);
        Status::Ok
    };
    fmi3DoStep(
        t: f64, h: f64, no_set_prior: bool, event_needed: *mut bool, terminates: *mut bool,
        early: *mut bool, last: *mut f64
    ) = |i| match &i.guest {
        Guest::CoSimulation(guest) => {
            let methods = guest.co_simulation_instance();
            methods.call_do_step(&mut i.store, i.this, t, h, no_set_prior)
        }
        Guest::ModelExchange(_) => wasmtime::bail!("the instance is for Model Exchange"),
    }, |_, end| {
        event_needed.write(end.event_handling_needed);
        terminates.write(end.terminate_simulation);
        early.write(end.early_return);
        last.write(end.last_successful_time);
        Status::Ok
    };
    fmi3GetOutputDerivatives(vr: *const u32, n: usize, orders: *const c_int, to: *mut f64, count: usize)
        = |i| {
            let orders = list(orders, n).iter().map(|order| order.cast_unsigned());
            let wanted: Vec<_> = list(vr, n).iter().copied().zip(orders).collect();
            call!(i, call_get_output_derivatives, &wanted)
        }, |i, given| i.copy(&given, to, count);
    fmi3EnterContinuousTimeMode() = |i| exchange!(i, call_enter_continuous_time_mode);
    fmi3CompletedIntegratorStep(no_set_prior: bool, enters_events: *mut bool, terminates: *mut bool)
        = |i| exchange!(i, call_completed_integrator_step, no_set_prior), |_, end| {
            enters_events.write(end.enter_event_mode);
            terminates.write(end.terminate_simulation);
            Status::Ok
        };
    fmi3SetTime(time: f64) = |i| exchange!(i, call_set_time, time);
    fmi3SetContinuousStates(states: *const f64, n: usize)
        = |i| exchange!(i, call_set_continuous_states, list(states, n));
    fmi3GetNumberOfEventIndicators(to: *mut usize)
        = |i| exchange!(i, call_get_number_of_event_indicators), |i, n| i.copy(&[n as usize], to, 1);
    fmi3GetNumberOfContinuousStates(to: *mut usize)
        = |i| exchange!(i, call_get_number_of_continuous_states), |i, n| i.copy(&[n as usize], to, 1);
    fmi3GetNumberOfVariableDependencies(vr: u32, to: *mut usize)
        = |i| call!(i, call_get_number_of_variable_dependencies, vr), |i, n| i.copy(&[n as usize], to, 1);
    fmi3GetVariableDependencies(
        vr: u32, dependent: *mut usize, independents: *mut u32, elements: *mut usize,
        kinds: *mut c_int, count: usize
    ) = |i| call!(i, call_get_variable_dependencies, vr), |i, given| {
        // Elements count from 0 there, and from 1 here.
        let number = |index: u32| index as usize + 1;
        let kind = |kind: DependencyKind| match kind {
            DependencyKind::Dependent => 5,
            other => other as c_int,
        };
        let all = given.iter();
        let [of, along]: [Vec<usize>; 2] = [
            all.clone().map(|d| number(d.element_index_of_dependent)).collect(),
            all.clone().map(|d| number(d.element_index_of_independent)).collect(),
        ];
        i.copy(&of, dependent, count);
        i.copy(&along, elements, count);
        i.copy(&Vec::from_iter(all.clone().map(|d| d.independent_value_reference)), independents, count);
        i.copy(&Vec::from_iter(all.map(|d| kind(d.kind))), kinds, count)
    };
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
functions! { vector
    fmi3GetContinuousStates call_get_continuous_states;
    fmi3GetContinuousStateDerivatives call_get_continuous_state_derivatives;
    fmi3GetEventIndicators call_get_event_indicators;
    fmi3GetNominalsOfContinuousStates call_get_nominals_of_continuous_states;
}
functions! { derivative
    fmi3GetDirectionalDerivative call_get_directional_derivative;
    fmi3GetAdjointDerivative call_get_adjoint_derivative;
}

// Texts, bytes and clocks.
functions! {
    fmi3GetString(vr: *const u32, n: usize, to: *mut Text, count: usize)
        = |i| call!(i, call_get_string, list(vr, n)), |i, given| {
            let texts = given.into_iter().map(|text| CString::new(text).unwrap_or_default());
            i.texts = texts.collect();
            let at: Vec<Text> = i.texts.iter().map(|text| text.as_ptr()).collect();
            i.copy(&at, to, count)
        };
    fmi3SetString(vr: *const u32, n: usize, values: *const Text, count: usize)
        = |i| call!(i, call_set_string, list(vr, n), &texts(list(values, count)));
    fmi3GetBinary(vr: *const u32, n: usize, sizes: *mut usize, to: *mut *const u8, count: usize)
        = |i| call!(i, call_get_binary, list(vr, n)), |i, given| {
            i.bytes = given;
            let all = i.bytes.iter().map(|bytes| (bytes.len(), bytes.as_ptr()));
            let (lengths, at): (Vec<usize>, Vec<*const u8>) = all.unzip();
            i.copy(&lengths, sizes, count);
            i.copy(&at, to, count)
        };
    fmi3SetBinary(vr: *const u32, n: usize, sizes: *const usize, values: *const *const u8, count: usize)
        = |i| {
            let values = list(values, count).iter().zip(list(sizes, count));
            let values: Vec<_> = values.map(|(at, size)| list(*at, *size).to_vec()).collect();
            call!(i, call_set_binary, list(vr, n), &values)
        };
    fmi3GetClock(vr: *const u32, n: usize, to: *mut bool)
        = |i| call!(i, call_get_clock, list(vr, n)), |i, given| i.copy(&given, to, n);
    fmi3SetClock(vr: *const u32, n: usize, values: *const bool)
        = |i| call!(i, call_set_clock, list(vr, n), list(values, n));
    fmi3GetIntervalDecimal(vr: *const u32, n: usize, to: *mut f64, qualifiers: *mut c_int)
        = |i| call!(i, call_get_interval_decimal, list(vr, n)), |i, given| {
            i.copy(&Vec::from_iter(given.iter().map(|one| one.1 as c_int)), qualifiers, n);
            i.copy(&Vec::from_iter(given.iter().map(|one| one.0)), to, n)
        };
    fmi3SetIntervalDecimal(vr: *const u32, n: usize, values: *const f64)
        = |i| call!(i, call_set_interval_decimal, list(vr, n), list(values, n));
    fmi3GetShiftDecimal(vr: *const u32, n: usize, to: *mut f64)
        = |i| call!(i, call_get_shift_decimal, list(vr, n)), |i, given| i.copy(&given, to, n);
    fmi3SetShiftDecimal(vr: *const u32, n: usize, values: *const f64)
        = |i| call!(i, call_set_shift_decimal, list(vr, n), list(values, n));
    fmi3GetIntervalFraction(
        vr: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int
    ) = |i| call!(i, call_get_interval_fraction, list(vr, n)), |i, given| {
        i.copy(&Vec::from_iter(given.iter().map(|one| one.1 as c_int)), qualifiers, n);
        i.split(given.iter().map(|one| one.0), [counters, resolutions], n)
    };
    fmi3SetIntervalFraction(vr: *const u32, n: usize, counters: *const u64, resolutions: *const u64)
        = |i| call!(i, call_set_interval_fraction, list(vr, n), &fractions([counters, resolutions], n));
    fmi3GetShiftFraction(vr: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64)
        = |i| call!(i, call_get_shift_fraction, list(vr, n)),
        |i, given| i.split(given.into_iter(), [counters, resolutions], n);
    fmi3SetShiftFraction(vr: *const u32, n: usize, counters: *const u64, resolutions: *const u64)
        = |i| call!(i, call_set_shift_fraction, list(vr, n), &fractions([counters, resolutions], n));
}

/// C strings as texts.
unsafe fn texts(all: &[Text]) -> Vec<String> {
    // SAFETY: C strings.
    let text = |text: &Text| unsafe { CStr::from_ptr(*text) }.to_string_lossy();
    all.iter().map(|one| text(one).into_owned()).collect()
}

/// Fractions of two arrays.
unsafe fn fractions(of: [*const u64; 2], n: usize) -> Vec<IntervalFraction> {
    // SAFETY: by FMI there are so many.
    let [counters, resolutions] = unsafe { of.map(|at| list(at, n)) };
    let fraction = |(&counter, &resolution)| IntervalFraction {
        counter,
        resolution,
    };
    counters.iter().zip(resolutions).map(fraction).collect()
}

impl Instance {
    /// Copies fractions to two arrays of so many.
    unsafe fn split(
        &mut self,
        given: impl Iterator<Item = IntervalFraction>,
        to: [*mut u64; 2],
        n: usize,
    ) -> Status {
        let parts: (Vec<_>, Vec<_>) = given.map(|one| (one.counter, one.resolution)).unzip();
        // SAFETY: forwarded.
        unsafe {
            self.copy(&parts.0, to[0], n);
            self.copy(&parts.1, to[1], n)
        }
    }
}

/// A saved state is its bytes.
type State = Vec<u8>;

/// A pointer to a saved state.
fn kept(state: &[u8]) -> Pointer {
    Box::into_raw(Box::<State>::new(state.to_vec())).cast()
}

functions! {
    fmi3GetFMUState(to: *mut Pointer) = |i| call!(i, call_get_fmu_state), |_, given| {
        to.write(kept(&given));
        Status::Ok
    };
    fmi3SetFMUState(state: Pointer)
        = |i| call!(i, call_set_fmu_state, &*state.cast::<State>());
    fmi3FreeFMUState(state: *mut Pointer) = |_| {
        let state = state.replace(ptr::null_mut());
        drop((!state.is_null()).then(|| Box::from_raw(state.cast::<State>())));
        Ok(Status::Ok)
    };
    fmi3SerializedFMUStateSize(state: Pointer, to: *mut usize) = |_| {
        to.write((*state.cast::<State>()).len());
        Ok(Status::Ok)
    };
    fmi3SerializeFMUState(state: Pointer, to: *mut u8, size: usize)
        = |i| Ok(i.copy(&*state.cast::<State>(), to, size));
    fmi3DeserializeFMUState(bytes: *const u8, size: usize, to: *mut Pointer) = |_| {
        to.write(kept(list(bytes, size)));
        Ok(Status::Ok)
    };
    fmi3ActivateModelPartition(_clock: u32, _time: f64) = |_| Ok(Status::Error);
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
    let arguments = Arguments {
        texts,
        is_logging,
        environment,
        logger,
    };
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

unsafe extern "C" fn fmi3FreeInstance(this: Pointer) {
    if this.is_null() {
        return;
    }
    // SAFETY: an instance that was made above, which is not used any more.
    let mut instance = unsafe { Box::from_raw(this.cast::<Instance>()) };
    let Instance { store, this, .. } = &mut *instance;
    let _ = this.resource_drop(store); // after a trap nothing can be done with it
}
