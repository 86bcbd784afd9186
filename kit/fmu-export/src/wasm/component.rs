//! The functions of an FMI-LS-WASM component (`fmi:fmi3@3.0.0`, world `co-simulation-fmu`), which a
//! host calls and which call the C functions of FMI 3.0. `cargo fmu pack` makes the component from
//! the module; its file `fmi3.wit` holds the interface.

pub use super::answers::{Answer, List, call, result};
pub use crate::fmi3::ffi::{Status, ValueReference};
pub use std::ptr::{null, null_mut};

use super::answers::plain;
use super::callbacks::{fmu_intermediate_update, fmu_log_message, tell, tell_panic};
use crate::c_api::call_order::{Call, INTERMEDIATE_UPDATE};
use crate::c_api::export::Exported;
use crate::c_api::fmi_instance::enter;
use crate::c_api::library::Library;
use crate::core::fault::refuse;
use crate::fmi3::entry as e;
use crate::fmi3::ffi::*;
use crate::fmi3::instance::Fmi3;
use crate::fmi3::states::ANY;
use std::ffi::{CStr, CString};
use std::ptr;

/// What all instances of the module share, by whichever functions they are made.
pub static LIBRARY: Library =
    Library::new(false, option_env!("FMU_SIZES")).telling_panics(tell_panic);

/// An instance of the resource `co-simulation-instance`.
pub struct Component {
    instance: Instance,
    /// Its name, which its callbacks receive as environment.
    _name: CString,
}

/// The component instance that a method is called on.
pub type This = *const Component;

/// The instance for C functions of a component instance.
///
/// # Safety
/// `this` came from `instantiate` and has not been freed.
pub unsafe fn instance(this: This) -> Instance {
    // SAFETY: forwarded.
    unsafe { (*this).instance }
}

#[link(wasm_import_module = "[export]fmi:fmi3/co-simulation@3.0.0")]
unsafe extern "C" {
    #[link_name = "[resource-new]co-simulation-instance"]
    fn handle(this: usize) -> u32;
}

/// Exports the functions of the component under their names. Functions with the same arguments are
/// listed together: those of the instance alone, getters and setters.
#[doc(hidden)]
#[macro_export]
macro_rules! export_component {
    ($x:ty) => {
        const _: () = {
            use $crate::component::*;
            use $crate::entry3 as e;

            $crate::export_component! { @call $x;
                "exit-initialization-mode" fmi3ExitInitializationMode;
                "enter-event-mode" fmi3EnterEventMode;
                "enter-step-mode" fmi3EnterStepMode;
                "evaluate-discrete-states" fmi3EvaluateDiscreteStates;
                "terminate" fmi3Terminate;
                "reset" fmi3Reset;
                "enter-configuration-mode" fmi3EnterConfigurationMode;
                "exit-configuration-mode" fmi3ExitConfigurationMode;
            }
            $crate::export_component! { @get $x;
                "get-float32" fmi3GetFloat32;
                "get-float64" fmi3GetFloat64;
                "get-int8" fmi3GetInt8;
                "get-int16" fmi3GetInt16;
                "get-int32" fmi3GetInt32;
                "get-int64" fmi3GetInt64;
                "get-uint8" fmi3GetUInt8;
                "get-uint16" fmi3GetUInt16;
                "get-uint32" fmi3GetUInt32;
                "get-uint64" fmi3GetUInt64;
                "get-boolean" fmi3GetBoolean;
            }
            $crate::export_component! { @set $x;
                "set-float32" fmi3SetFloat32 f32;
                "set-float64" fmi3SetFloat64 f64;
                "set-int8" fmi3SetInt8 i8;
                "set-int16" fmi3SetInt16 i16;
                "set-int32" fmi3SetInt32 i32;
                "set-int64" fmi3SetInt64 i64;
                "set-uint8" fmi3SetUInt8 u8;
                "set-uint16" fmi3SetUInt16 u16;
                "set-uint32" fmi3SetUInt32 u32;
                "set-uint64" fmi3SetUInt64 u64;
                "set-boolean" fmi3SetBoolean u8;
            }
            // There are no clocks, so these read and write no values.
            $crate::export_component! { @get_clock $x;
                "get-interval-decimal" fmi3GetIntervalDecimal null_mut null_mut;
                "get-interval-fraction" fmi3GetIntervalFraction null_mut null_mut null_mut;
                "get-shift-decimal" fmi3GetShiftDecimal null_mut;
                "get-shift-fraction" fmi3GetShiftFraction null_mut null_mut;
            }
            $crate::export_component! { @set_clock $x;
                "set-clock" fmi3SetClock null;
                "set-interval-decimal" fmi3SetIntervalDecimal null;
                "set-interval-fraction" fmi3SetIntervalFraction null null;
                "set-shift-decimal" fmi3SetShiftDecimal null;
                "set-shift-fraction" fmi3SetShiftFraction null null;
            }
            $crate::export_component_types!($x);
            $crate::export_component_methods!($x);
        };
    };
    (@call $x:ty; $($name:literal $function:ident;)*) => {$(
        #[unsafe(export_name = concat!("fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.", $name))]
        unsafe extern "C" fn $function(this: This) -> Status {
            // SAFETY: the canonical ABI gives this instance.
            call(|| unsafe { e::$function::<$x>(instance(this)) })
        }
    )*};
    (@get $x:ty; $($name:literal $function:ident;)*) => {$(
        #[unsafe(export_name = concat!("fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.", $name))]
        unsafe extern "C" fn $function(this: This, vr: *const ValueReference, n: usize) -> Answer {
            // SAFETY: as above, and the list.
            call(|| unsafe { get::<$x, _>(this, (vr, n), e::$function::<$x>) })
        }
    )*};
    (@set $x:ty; $($name:literal $function:ident $type:ty;)*) => {$(
        #[unsafe(export_name = concat!("fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.", $name))]
        unsafe extern "C" fn $function(
            this: This, vr: *const ValueReference, n: usize, values: *const $type, n_values: usize
        ) -> Status {
            // SAFETY: as above, and the lists.
            call(|| unsafe { e::$function::<$x>(instance(this), vr, n, values, n_values) })
        }
    )*};
    (@get_clock $x:ty; $($name:literal $function:ident $($null:ident)*;)*) => {$(
        #[unsafe(export_name = concat!("fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.", $name))]
        unsafe extern "C" fn $function(this: This, vr: *const ValueReference, n: usize) -> Answer {
            // SAFETY: as above.
            call(|| result(unsafe { e::$function::<$x>(instance(this), vr, n $(, $null())*) }, List::EMPTY))
        }
    )*};
    (@set_clock $x:ty; $($name:literal $function:ident $($null:ident)*;)*) => {$(
        #[unsafe(export_name = concat!("fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.", $name))]
        unsafe extern "C" fn $function(
            this: This, vr: *const ValueReference, n: usize, _values: *const u8, _n_values: usize
        ) -> Status {
            // SAFETY: as above.
            call(|| unsafe { e::$function::<$x>(instance(this), vr, n $(, $null())*) })
        }
    )*};
    (@other $x:ty; $prefix:literal; $($name:literal $function:ident($($argument:ident: $type:ty),*) $result:ty;)*) => {$(
        #[unsafe(export_name = concat!($prefix, $name))]
        unsafe extern "C" fn $function($($argument: $type),*) -> $result {
            // SAFETY: the canonical ABI gives these arguments.
            call(|| unsafe { $crate::component::$function::<$x>($($argument),*) })
        }
    )*};
}

#[unsafe(export_name = "fmi:fmi3/common@3.0.0#get-version")]
extern "C" fn get_version() -> Answer {
    plain(List::from_slice(b"3.0"))
}

/// Gets variables, as many values as they have elements.
///
/// # Safety
/// The arguments are those that the canonical ABI gives.
pub unsafe fn get<X: Exported, T: Clone + Default + 'static>(
    this: This,
    (vr, n): (*const ValueReference, usize),
    function: unsafe fn(Instance, *const ValueReference, usize, *mut T, usize) -> Status,
) -> Answer {
    // SAFETY: forwarded.
    unsafe {
        let mut values = vec![T::default(); count::<X>(this, (vr, n))];
        let status = function(instance(this), vr, n, values.as_mut_ptr(), values.len());
        result(status, List::from_vec(values))
    }
}

/// The number of elements of these variables. An unknown reference counts as one element, so that
/// the function that receives it refuses it.
unsafe fn count<X: Exported>(this: This, (vr, n): (*const ValueReference, usize)) -> usize {
    let (mut count, name) = (n, "the number of elements");
    let allowed = ANY | INTERMEDIATE_UPDATE;
    // SAFETY: forwarded.
    unsafe {
        enter::<X::Model, Fmi3>(instance(this), Call::new(name, allowed), |fmi| {
            let len = |vr: &u32| fmi.instance.layout.block(*vr).map_or(1, |(_, _, len)| len);
            count = List::from_raw(vr, n).items::<u32>().iter().map(len).sum();
            Ok(())
        });
    }
    count
}

/// The text as a C string; None if it contains U+0000.
fn text(list: List) -> Option<CString> {
    // SAFETY: an argument of this call.
    CString::new(unsafe { list.items::<u8>() }).ok()
}

/// Calls a function with these texts.
unsafe fn with_texts(
    texts: *const List,
    n: usize,
    function: impl FnOnce(*const Str) -> Status,
) -> Status {
    // SAFETY: forwarded.
    let texts = unsafe { List::from_raw(texts, n).items::<List>() };
    let Some(texts) = texts
        .iter()
        .map(|list| text(*list))
        .collect::<Option<Vec<_>>>()
    else {
        tell(
            "",
            Status::Error,
            "logStatusError",
            "a text with U+0000 cannot be handed to the FMU",
        );
        return Status::Error;
    };
    let texts: Vec<Str> = texts.iter().map(|text| text.as_ptr()).collect();
    function(texts.as_ptr())
}

/// The record `discrete-states-info`.
#[repr(C)]
struct Events {
    flags: [Boolean; 5],
    time: f64,
}

/// The record `do-step-result`.
#[repr(C)]
struct Step {
    time: f64,
    event: Boolean,
    terminate: Boolean,
    early: Boolean,
}

/// Defines functions for any model, and a macro that exports them for one model.
macro_rules! functions {
    (($d:tt) $export:ident $prefix:literal; $(
        $name:literal $function:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $run:block
    )*) => {
        $(
            #[doc = concat!("`", $name, "`.")]
            ///
            /// # Safety
            /// The arguments are those that the canonical ABI gives.
            #[allow(clippy::too_many_arguments)]
            pub unsafe fn $function<X: Exported>($($argument: $type),*) -> $result {
                // SAFETY: forwarded.
                unsafe { $run }
            }
        )*

        #[doc(hidden)]
        #[macro_export]
        macro_rules! $export {
            ($d x:ty) => {
                $crate::export_component! { @other $d x; $prefix; $($name $function($($argument: $type),*) $result;)* }
            };
        }
    };
}

functions! { ($) export_component_types "fmi:fmi3/";
    "co-simulation@3.0.0#[static]co-simulation-instance.instantiate-co-simulation" instantiate(
        name: *const u8, name_len: usize, token: *const u8, token_len: usize, resources: *const u8,
        resources_len: usize, visible: u32, logging_on: u32, event_mode_used: u32,
        early_return_allowed: u32, required: *const ValueReference, n_required: usize,
    ) -> Answer {
        let texts = [(name, name_len), (token, token_len), (resources, resources_len)];
        let [Some(name), Some(token), Some(resources)] = texts.map(|(at, len)| text(List::from_raw(at, len))) else {
            tell("", Status::Error, "logStatusError", "instantiate-co-simulation: a text with U+0000");
            return plain([0_u32; 2]);
        };
        let _ = visible;
        let [logging_on, event_mode_used, early_return_allowed] =
            [logging_on, event_mode_used, early_return_allowed].map(|flag| flag as Boolean);
        let folder = if resources.is_empty() { null() } else { resources.as_ptr() };
        let update = Some(fmu_intermediate_update());
        let said = e::CoSimulation { event_mode_used, early_return_allowed, required, n_required, update };
        let instance = e::instantiate::<X>(
            &LIBRARY, name.as_ptr(), token.as_ptr(), folder, logging_on,
            name.as_ptr().cast_mut().cast(), Some(fmu_log_message()), e::Interface::CoSimulation(said),
        );
        if instance.is_null() {
            return plain([0_u32; 2]);
        }
        plain([1, handle(Box::into_raw(Box::new(Component { instance, _name: name })).addr())])
    }
    "co-simulation@3.0.0#[dtor]co-simulation-instance" free(this: This) -> () {
        let component = Box::from_raw(this.cast_mut());
        e::free_instance::<X>(component.instance);
    }
}

functions! { ($) export_component_methods "fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.";
    "set-debug-logging" set_debug_logging(this: This, on: u32, categories: *const List, n: usize) -> Status {
        with_texts(categories, n, |texts| e::fmi3SetDebugLogging::<X>(instance(this), on as Boolean, n, texts))
    }
    "enter-initialization-mode" enter_initialization_mode(
        this: This, has_tolerance: u32, tolerance: f64, start: f64, has_stop: u32, stop: f64,
    ) -> Status {
        let (has_tolerance, has_stop) = (has_tolerance as Boolean, has_stop as Boolean);
        e::fmi3EnterInitializationMode::<X>(instance(this), has_tolerance, tolerance, start, has_stop, stop)
    }
    "update-discrete-states" update_discrete_states(this: This) -> Answer {
        let (mut flags, mut time) = ([0; 5], 0.0);
        let [update, terminate, nominals, values, defined] = flags.each_mut().map(ptr::from_mut);
        let status = e::fmi3UpdateDiscreteStates::<X>(
            instance(this), update, terminate, nominals, values, defined, &mut time,
        );
        result(status, Events { flags, time })
    }
    "get-string" get_string(this: This, vr: *const ValueReference, n: usize) -> Answer {
        let count = count::<X>(this, (vr, n));
        let mut values = vec![ptr::null(); count];
        let status = e::fmi3GetString::<X>(instance(this), vr, n, values.as_mut_ptr(), count);
        let texts = match status {
            Status::Ok => values.into_iter().map(|text| List::from_slice(CStr::from_ptr(text).to_bytes())).collect(),
            _ => Vec::new(),
        };
        result(status, List::from_vec(texts))
    }
    "get-binary" get_binary(this: This, vr: *const ValueReference, n: usize) -> Answer {
        let count = count::<X>(this, (vr, n));
        let (mut sizes, mut values) = (vec![0; count], vec![ptr::null(); count]);
        let (sizes_at, values_at) = (sizes.as_mut_ptr(), values.as_mut_ptr());
        let status = e::fmi3GetBinary::<X>(instance(this), vr, n, sizes_at, values_at, count);
        let values = sizes.into_iter().zip(values).map(|(len, at)| List::from_raw(at, len)).collect();
        result(status, List::from_vec::<List>(values))
    }
    "get-clock" get_clock(this: This, vr: *const ValueReference, n: usize) -> Answer {
        let mut values = vec![0; n];
        result(e::fmi3GetClock::<X>(instance(this), vr, n, values.as_mut_ptr()), List::from_vec(values))
    }
    "set-string" set_string(
        this: This, vr: *const ValueReference, n: usize, values: *const List, n_values: usize,
    ) -> Status {
        with_texts(values, n_values, |texts| e::fmi3SetString::<X>(instance(this), vr, n, texts, n_values))
    }
    "set-binary" set_binary(
        this: This, vr: *const ValueReference, n: usize, values: *const List, n_values: usize,
    ) -> Status {
        let values = List::from_raw(values, n_values).items::<List>();
        let (values, sizes): (Vec<_>, Vec<_>) = values.iter().map(|value| value.parts()).unzip();
        e::fmi3SetBinary::<X>(instance(this), vr, n, sizes.as_ptr(), values.as_ptr(), n_values)
    }
    "get-number-of-variable-dependencies" number_of_dependencies(this: This, vr: ValueReference) -> Answer {
        let mut n = 0;
        let status = e::fmi3GetNumberOfVariableDependencies::<X>(instance(this), vr, &mut n);
        result(status, n as u64)
    }
    "get-variable-dependencies" dependencies(this: This, vr: ValueReference) -> Answer {
        let mut n = 0;
        let mut status = e::fmi3GetNumberOfVariableDependencies::<X>(instance(this), vr, &mut n);
        let (mut elements, mut of) = (vec![0; n], vec![0; n]);
        let (mut independents, mut kinds) = (vec![0; n], vec![0; n]);
        if status == Status::Ok {
            status = e::fmi3GetVariableDependencies::<X>(
                instance(this), vr, elements.as_mut_ptr(), independents.as_mut_ptr(), of.as_mut_ptr(),
                kinds.as_mut_ptr(), n,
            );
        }
        // Elements count from 1 in FMI and from 0 there; `dependent` comes first there.
        let index = |element: usize| element.saturating_sub(1) as u32;
        let kind = |kind: c_int| if kind == DEPENDENT { 0 } else { kind as u32 };
        let rows = (0..n).map(|k| [vr, index(elements[k]), independents[k], index(of[k]), kind(kinds[k])]);
        result(status, List::from_vec::<[u32; 5]>(rows.collect()))
    }
    "get-fmu-state" get_fmu_state(this: This) -> Answer {
        let (c, mut state, mut size) = (instance(this), ptr::null_mut(), 0);
        let mut status = e::fmi3GetFMUState::<X>(c, &mut state);
        let mut bytes = Vec::new();
        if status == Status::Ok {
            status = e::fmi3SerializedFMUStateSize::<X>(c, state, &mut size);
            bytes.resize(size, 0);
        }
        if status == Status::Ok {
            status = e::fmi3SerializeFMUState::<X>(c, state, bytes.as_mut_ptr(), size);
            e::fmi3FreeFMUState::<X>(c, &mut state);
        }
        result(status, List::from_vec(bytes))
    }
    "set-fmu-state" set_fmu_state(this: This, bytes: *const u8, size: usize) -> Status {
        let (c, mut state) = (instance(this), ptr::null_mut());
        let mut status = e::fmi3DeserializeFMUState::<X>(c, bytes, size, &mut state);
        if status == Status::Ok {
            status = e::fmi3SetFMUState::<X>(c, state);
            e::fmi3FreeFMUState::<X>(c, &mut state);
        }
        status
    }
    "get-directional-derivative" get_directional_derivative(
        this: This, unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference,
        n_knowns: usize, seed: *const f64, n_seed: usize,
    ) -> Answer {
        let mut values = vec![0.0; count::<X>(this, (unknowns, n_unknowns))];
        let (at, n) = (values.as_mut_ptr(), values.len());
        let status = e::fmi3GetDirectionalDerivative::<X>(
            instance(this), unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, at, n,
        );
        result(status, List::from_vec(values))
    }
    "get-adjoint-derivative" get_adjoint_derivative(
        this: This, unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference,
        n_knowns: usize, seed: *const f64, n_seed: usize,
    ) -> Answer {
        let mut values = vec![0.0; count::<X>(this, (knowns, n_knowns))];
        let (at, n) = (values.as_mut_ptr(), values.len());
        let status = e::fmi3GetAdjointDerivative::<X>(
            instance(this), unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, at, n,
        );
        result(status, List::from_vec(values))
    }
    "set-input-derivatives" set_input_derivatives(
        this: This, requests: *const [u32; 2], n: usize, values: *const f64, n_values: usize,
    ) -> Status {
        let _ = (requests, n, values, n_values);
        let name = "set-input-derivatives";
        enter::<X::Model, Fmi3>(instance(this), Call::new(name, ANY | INTERMEDIATE_UPDATE), |_| {
            refuse!("FMI 3.0 has no function that sets derivatives of inputs")
        })
    }
    "get-output-derivatives" get_output_derivatives(this: This, requests: *const [u32; 2], n: usize) -> Answer {
        let requests = List::from_raw(requests, n).items::<[u32; 2]>();
        let (vr, orders): (Vec<u32>, Vec<i32>) = requests.iter().map(|r| (r[0], r[1] as i32)).unzip();
        let mut values = vec![0.0; count::<X>(this, (vr.as_ptr(), n))];
        let (at, n_values) = (values.as_mut_ptr(), values.len());
        let status = e::fmi3GetOutputDerivatives::<X>(instance(this), vr.as_ptr(), n, orders.as_ptr(), at, n_values);
        result(status, List::from_vec(values))
    }
    "do-step" do_step(this: This, t: f64, h: f64, no_set_prior: u32) -> Answer {
        let _ = no_set_prior;
        let ([mut event, mut terminate, mut early], mut time) = ([0; 3], 0.0);
        let status = e::do_step::<X>(instance(this), t, h, &mut event, &mut terminate, &mut early, &mut time);
        result(status, Step { time, event, terminate, early })
    }
}
