//! The functions of an FMI-LS-WASM component (`fmi:fmi3@3.0.0`, worlds `co-simulation-fmu` and
//! `model-exchange-fmu`), which a host calls and which call the C functions of FMI 3.0. `cargo fmu pack` makes the component from
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

/// An instance of the resource `co-simulation-instance` or `model-exchange-instance`.
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

mod handles {
    #[link(wasm_import_module = "[export]fmi:fmi3/co-simulation@3.0.0")]
    unsafe extern "C" {
        #[link_name = "[resource-new]co-simulation-instance"]
        pub(super) safe fn co_simulation(this: usize) -> u32;
    }

    #[link(wasm_import_module = "[export]fmi:fmi3/model-exchange@3.0.0")]
    unsafe extern "C" {
        #[link_name = "[resource-new]model-exchange-instance"]
        pub(super) safe fn model_exchange(this: usize) -> u32;
    }
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
    (($d:tt) $export:ident @$kind:ident; $(
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
                $crate::export_component! { @$kind $d x; $($name $function($($argument: $type),*) $result;)* }
            };
        }
    };
}

/// Makes an instance for Co-Simulation or Model Exchange.
unsafe fn make<X: Exported>(
    texts: [(*const u8, usize); 3],
    logging_on: u32,
    with: e::Interface,
) -> Answer {
    let texts = texts.map(|(at, len)| text(List::from_raw(at, len)));
    let [Some(name), Some(token), Some(resources)] = texts else {
        tell(
            "",
            Status::Error,
            "logStatusError",
            "instantiate: a text with U+0000",
        );
        return plain([0_u32; 2]);
    };
    let folder = match resources.is_empty() {
        true => null(),
        false => resources.as_ptr(),
    };
    let handle = match with {
        e::Interface::CoSimulation(_) => handles::co_simulation,
        _ => handles::model_exchange,
    };
    // SAFETY: C strings; the name lives as long as the instance.
    let instance = unsafe {
        e::instantiate::<X>(
            &LIBRARY,
            name.as_ptr(),
            token.as_ptr(),
            folder,
            logging_on as Boolean,
            name.as_ptr().cast_mut().cast(),
            Some(fmu_log_message()),
            with,
        )
    };
    if instance.is_null() {
        return plain([0_u32; 2]);
    }
    let component = Component {
        instance,
        _name: name,
    };
    plain([1, handle(Box::into_raw(Box::new(component)).addr())])
}

functions! { ($) export_component_co_simulation @one;
    "co-simulation@3.0.0#[static]co-simulation-instance.instantiate-co-simulation" instantiate(
        name: *const u8, name_len: usize, token: *const u8, token_len: usize, resources: *const u8,
        resources_len: usize, visible: u32, logging_on: u32, event_mode_used: u32,
        early_return_allowed: u32, required: *const ValueReference, n_required: usize,
    ) -> Answer {
        let _ = visible;
        let [event_mode_used, early_return_allowed] =
            [event_mode_used, early_return_allowed].map(|flag| flag as Boolean);
        let update = Some(fmu_intermediate_update());
        let said = e::CoSimulation { event_mode_used, early_return_allowed, required, n_required, update };
        let texts = [(name, name_len), (token, token_len), (resources, resources_len)];
        make::<X>(texts, logging_on, e::Interface::CoSimulation(said))
    }
    "co-simulation@3.0.0#[dtor]co-simulation-instance" free(this: This) -> () {
        let component = Box::from_raw(this.cast_mut());
        e::free_instance::<X>(component.instance);
    }
    "co-simulation@3.0.0#[method]co-simulation-instance.set-input-derivatives" set_input_derivatives(
        this: This, requests: *const [u32; 2], n: usize, values: *const f64, n_values: usize,
    ) -> Status {
        let _ = (requests, n, values, n_values);
        let name = "set-input-derivatives";
        enter::<X::Model, Fmi3>(instance(this), Call::new(name, ANY | INTERMEDIATE_UPDATE), |_| {
            refuse!("FMI 3.0 has no function that sets derivatives of inputs")
        })
    }
    "co-simulation@3.0.0#[method]co-simulation-instance.do-step" do_step(
        this: This, t: f64, h: f64, no_set_prior: u32,
    ) -> Answer {
        let _ = no_set_prior;
        let ([mut event, mut terminate, mut early], mut time) = ([0; 3], 0.0);
        let status = e::do_step::<X>(instance(this), t, h, &mut event, &mut terminate, &mut early, &mut time);
        result(status, Step { time, event, terminate, early })
    }
}

/// Gets all numbers of a vector of Model Exchange.
unsafe fn vector(
    this: This,
    size: unsafe fn(Instance, *mut usize) -> Status,
    function: unsafe fn(Instance, *mut f64, usize) -> Status,
) -> Answer {
    let mut n = 0;
    // SAFETY: forwarded; there is room for as many values.
    unsafe {
        let mut status = size(instance(this), &mut n);
        let mut values = vec![0.0; n];
        if status == Status::Ok {
            status = function(instance(this), values.as_mut_ptr(), n);
        }
        result(status, List::from_vec(values))
    }
}

/// Gets the size of a vector of Model Exchange.
unsafe fn size(this: This, function: unsafe fn(Instance, *mut usize) -> Status) -> Answer {
    let mut n = 0;
    // SAFETY: forwarded.
    let status = unsafe { function(instance(this), &mut n) };
    result(status, n as u64)
}

functions! { ($) export_component_exchange @one;
    "model-exchange@3.0.0#[static]model-exchange-instance.instantiate-model-exchange" instantiate_exchange(
        name: *const u8, name_len: usize, token: *const u8, token_len: usize, resources: *const u8,
        resources_len: usize, visible: u32, logging_on: u32,
    ) -> Answer {
        let _ = visible;
        make::<X>([(name, name_len), (token, token_len), (resources, resources_len)], logging_on, e::Interface::ModelExchange)
    }
    "model-exchange@3.0.0#[dtor]model-exchange-instance" free_exchange(this: This) -> () {
        free::<X>(this);
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.enter-continuous-time-mode" enter_continuous_time(this: This) -> Status {
        e::fmi3EnterContinuousTimeMode::<X>(instance(this))
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.set-time" set_time(this: This, time: f64) -> Status {
        e::fmi3SetTime::<X>(instance(this), time)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.set-continuous-states" set_states(
        this: This, states: *const f64, n: usize,
    ) -> Status {
        e::fmi3SetContinuousStates::<X>(instance(this), states, n)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.get-continuous-state-derivatives" get_derivatives(this: This) -> Answer {
        vector(this, e::fmi3GetNumberOfContinuousStates::<X>, e::fmi3GetContinuousStateDerivatives::<X>)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.get-event-indicators" get_indicators(this: This) -> Answer {
        vector(this, e::fmi3GetNumberOfEventIndicators::<X>, e::fmi3GetEventIndicators::<X>)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.get-continuous-states" get_states(this: This) -> Answer {
        vector(this, e::fmi3GetNumberOfContinuousStates::<X>, e::fmi3GetContinuousStates::<X>)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.get-nominals-of-continuous-states" get_nominals(this: This) -> Answer {
        vector(this, e::fmi3GetNumberOfContinuousStates::<X>, e::fmi3GetNominalsOfContinuousStates::<X>)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.get-number-of-event-indicators" count_indicators(this: This) -> Answer {
        size(this, e::fmi3GetNumberOfEventIndicators::<X>)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.get-number-of-continuous-states" count_states(this: This) -> Answer {
        size(this, e::fmi3GetNumberOfContinuousStates::<X>)
    }
    "model-exchange@3.0.0#[method]model-exchange-instance.completed-integrator-step" complete_step(
        this: This, no_set_prior: u32,
    ) -> Answer {
        let [mut enters_events, mut terminates] = [0; 2];
        let status = e::fmi3CompletedIntegratorStep::<X>(
            instance(this), no_set_prior as Boolean, &mut enters_events, &mut terminates,
        );
        result(status, [enters_events, terminates])
    }
}

functions! { ($) export_component_methods @both;
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
    "get-output-derivatives" get_output_derivatives(this: This, requests: *const [u32; 2], n: usize) -> Answer {
        let requests = List::from_raw(requests, n).items::<[u32; 2]>();
        let (vr, orders): (Vec<u32>, Vec<i32>) = requests.iter().map(|r| (r[0], r[1] as i32)).unzip();
        let mut values = vec![0.0; count::<X>(this, (vr.as_ptr(), n))];
        let (at, n_values) = (values.as_mut_ptr(), values.len());
        let status = e::fmi3GetOutputDerivatives::<X>(instance(this), vr.as_ptr(), n, orders.as_ptr(), at, n_values);
        result(status, List::from_vec(values))
    }
}
