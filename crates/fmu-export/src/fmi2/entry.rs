//! The functions of FMI 2.0, one to one; [`export_fmu!`](crate::export_fmu) gives them their C names for one model.
//!
//! All of them may be called with `c` = NULL or an instance of this library that is in use by no other thread, and with
//! pointers that are NULL or valid for the number of elements given beside them; that is what FMI asks of the importer.

pub use super::instantiate::{free_instance, instantiate};
pub use crate::border::library::Library;

use super::calls;
use super::component::{Body, Fmi2, enter};
use super::ffi::*;
use crate::Model;
use crate::border::arguments::{array, array_mut, place, texts};
use crate::border::files;
use crate::border::log::c_string;
use crate::core::fault::{Fault, refuse};
use libc::{c_int, c_void};

/// fmi2SetDebugLogging.
///
/// # Safety
/// See the module.
pub unsafe fn set_debug_logging<M: Model>(
    c: Component,
    on: Boolean,
    n: usize,
    categories: *const Str,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::SET_DEBUG_LOGGING, |b| {
            b.log.set(on != 0, &texts("categories", categories, n)?);
            b.instance.wanted = b.log.wanted_of_model();
            Ok(())
        })
    }
}

/// fmi2SetupExperiment. The tolerance is for models that control their own error: not used, whatever it is.
///
/// # Safety
/// See the module.
pub unsafe fn setup_experiment<M: Model>(
    c: Component,
    _tolerance_defined: Boolean,
    _tolerance: Real,
    start: Real,
    stop_defined: Boolean,
    stop: Real,
) -> Status {
    let stop = (stop_defined != 0).then_some(stop);
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::SETUP_EXPERIMENT, |b| {
            b.instance.set_times(start, stop)
        })
    }
}

macro_rules! without_arguments {
    ($($function:ident $c_name:literal $call:ident $run:expr;)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $function<M: Model>(c: Component) -> Status {
            let run: fn(&mut Body<M>) -> Result<(), Fault> = $run;
            // SAFETY: forwarded.
            unsafe { enter::<M, Fmi2>(c, calls::$call, run) }
        }
    )*};
}

without_arguments! {
    enter_initialization_mode "fmi2EnterInitializationMode" ENTER_INITIALIZATION_MODE |b| { b.instance.enter_initialization(); Ok(()) };
    exit_initialization_mode "fmi2ExitInitializationMode" EXIT_INITIALIZATION_MODE |b| b.instance.exit_initialization();
    terminate "fmi2Terminate" TERMINATE |b| { b.instance.terminate(); Ok(()) };
    reset "fmi2Reset" RESET |b| b.reset();
    cancel_step "fmi2CancelStep" CANCEL_STEP Body::cancel_step;
}

macro_rules! set_and_get {
    ($($set:ident $set_name:literal $set_call:ident $get:ident $get_name:literal $get_call:ident $c_type:ty, $from_c:expr, $to_c:expr;)*) => {$(
        #[doc = concat!($set_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $set<M: Model>(
            c: Component,
            vr: *const ValueReference,
            n: usize,
            values: *const $c_type,
        ) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi2>(c, calls::$set_call, |b| {
                    let (vr, values) = (array("vr", vr, n)?, array("value", values, n)?);
                    b.instance.set(|k| Some((vr.at(k)?, $from_c(values.at(k)?))))
                })
            }
        }

        #[doc = concat!($get_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $get<M: Model>(
            c: Component,
            vr: *const ValueReference,
            n: usize,
            values: *mut $c_type,
        ) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi2>(c, calls::$get_call, |b| {
                    let (vr, values) = (array("vr", vr, n)?, array_mut("value", values, n)?);
                    b.instance.get(|k| vr.at(k), |k, value| values.put(k, $to_c(value)))
                })
            }
        }
    )*};
}

set_and_get! {
    set_real "fmi2SetReal" SET_REAL get_real "fmi2GetReal" GET_REAL Real, |x: f64| x, |x: f64| x;
    set_integer "fmi2SetInteger" SET_INTEGER get_integer "fmi2GetInteger" GET_INTEGER Integer, |x: Integer| x, |x: i32| x;
    set_boolean "fmi2SetBoolean" SET_BOOLEAN get_boolean "fmi2GetBoolean" GET_BOOLEAN Boolean, |c: Boolean| c != 0, |value: bool| Boolean::from(value);
}

/// fmi2SetString.
///
/// # Safety
/// See the module.
pub unsafe fn set_string<M: Model>(
    c: Component,
    vr: *const ValueReference,
    n: usize,
    values: *const Str,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::SET_STRING, |b| {
            let (vr, values) = (array("vr", vr, n)?, texts("value", values, n)?);
            let pairs: Vec<_> = (values.iter().enumerate())
                .map(|(k, text)| (vr.get(k), *text))
                .collect();
            b.instance.set_texts(&pairs)
        })
    }
}

/// fmi2GetString; the texts stay valid until the next call of it.
///
/// # Safety
/// See the module.
pub unsafe fn get_string<M: Model>(
    c: Component,
    vr: *const ValueReference,
    n: usize,
    values: *mut Str,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::GET_STRING, |b| {
            let (vr, values) = (array("vr", vr, n)?, array_mut("value", values, n)?);
            let text = |k| Ok(c_string(b.instance.text(vr.get(k))?));
            b.strings = (0..n).map(text).collect::<Result<_, Fault>>()?;
            for (k, text) in b.strings.iter().enumerate() {
                values.put(k, text.as_ptr());
            }
            Ok(())
        })
    }
}

/// fmi2GetFMUstate.
///
/// # Safety
/// See the module.
pub unsafe fn get_fmu_state<M: Model>(c: Component, state: *mut FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M, Fmi2>(c, calls::GET_FMU_STATE, |b| b.save("FMUstate", state)) }
}

/// fmi2SetFMUstate.
///
/// # Safety
/// See the module.
pub unsafe fn set_fmu_state<M: Model>(c: Component, state: FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M, Fmi2>(c, calls::SET_FMU_STATE, |b| b.restore(state.addr())) }
}

/// fmi2FreeFMUstate.
///
/// # Safety
/// See the module.
pub unsafe fn free_fmu_state<M: Model>(c: Component, state: *mut FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M, Fmi2>(c, calls::FREE_FMU_STATE, |b| b.free("FMUstate", state)) }
}

/// fmi2SerializedFMUstateSize.
///
/// # Safety
/// See the module.
pub unsafe fn serialized_fmu_state_size<M: Model>(
    c: Component,
    state: FmuState,
    size: *mut usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::SERIALIZED_FMU_STATE_SIZE, |b| {
            b.serialized_size(state, size)
        })
    }
}

/// fmi2SerializeFMUstate; room beyond the end of the state is left alone.
///
/// # Safety
/// See the module.
pub unsafe fn serialize_fmu_state<M: Model>(
    c: Component,
    state: FmuState,
    bytes: *mut Byte,
    size: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::SERIALIZE_FMU_STATE, |b| {
            b.serialize(state, bytes.cast::<u8>(), size)
        })
    }
}

/// fmi2DeSerializeFMUstate.
///
/// # Safety
/// See the module.
pub unsafe fn deserialize_fmu_state<M: Model>(
    c: Component,
    serialized: *const Byte,
    size: usize,
    state: *mut FmuState,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::DESERIALIZE_FMU_STATE, |b| {
            b.deserialize(serialized.cast::<u8>(), size, "FMUstate", state)
        })
    }
}

/// fmi2GetDirectionalDerivative.
///
/// # Safety
/// See the module.
pub unsafe fn get_directional_derivative<M: Model>(
    c: Component,
    unknown: *const ValueReference,
    n_unknown: usize,
    known: *const ValueReference,
    n_known: usize,
    seed: *const Real,
    result: *mut Real,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::GET_DIRECTIONAL_DERIVATIVE, |b| {
            if !M::INFO.directional_derivatives {
                return refuse!(
                    "this FMU has no directional derivatives (providesDirectionalDerivative = false)"
                );
            }
            let unknown = array("vUnknown_ref", unknown, n_unknown)?;
            let known = array("vKnown_ref", known, n_known)?;
            let seed = array("dvKnown", seed, n_known)?;
            let result = array_mut("dvUnknown", result, n_unknown)?;
            b.instance.directional_derivative(
                n_unknown,
                |k| unknown.get(k),
                n_known,
                |k| known.get(k),
                |k| seed.get(k),
                |k, value| result.put(k, value),
            )
        })
    }
}

/// fmi2SetRealInputDerivatives.
///
/// # Safety
/// See the module.
pub unsafe fn set_real_input_derivatives<M: Model>(
    c: Component,
    vr: *const ValueReference,
    n: usize,
    order: *const Integer,
    values: *const Real,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::SET_INPUT_DERIVATIVES, |b| {
            let (vr, order) = (array("vr", vr, n)?, array("order", order, n)?);
            let values = array("value", values, n)?;
            b.instance
                .set_input_derivatives(n, |k| vr.get(k), |k| order.get(k), |k| values.get(k))
        })
    }
}

/// fmi2GetRealOutputDerivatives.
///
/// # Safety
/// See the module.
pub unsafe fn get_real_output_derivatives<M: Model>(
    c: Component,
    vr: *const ValueReference,
    n: usize,
    order: *const Integer,
    values: *mut Real,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi2>(c, calls::GET_OUTPUT_DERIVATIVES, |b| {
            let (vr, order) = (array("vr", vr, n)?, array("order", order, n)?);
            let values = array_mut("value", values, n)?;
            if !M::INFO.output_derivatives {
                return refuse!(
                    "this FMU has no output derivatives (maxOutputDerivativeOrder = 0)"
                );
            }
            if let Some(k) = (0..n).find(|&k| order.get(k) != 1) {
                let (i, row) = b.instance.layout.find(vr.get(k))?;
                let (name, order) = (row.element_name(i), order.get(k));
                return refuse!("`{name}`: order of derivative = {order} must be 1");
            }
            b.instance
                .output_derivatives(n, |k| vr.get(k), |k, value| values.put(k, value))
        })
    }
}

/// fmi2DoStep.
///
/// # Safety
/// See the module.
pub unsafe fn do_step<M: Model>(c: Component, t: Real, h: Real) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M, Fmi2>(c, calls::DO_STEP, |b| b.do_step(t, h)) }
}

macro_rules! inquiries {
    ($($function:ident $c_name:literal $call:ident $method:ident $type:ty;)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $function<M: Model>(c: Component, kind: c_int, value: *mut $type) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M, Fmi2>(c, calls::$call, |b| {
                    let to = place("value", value)?;
                    to.put(0, b.$method(kind)?);
                    Ok(())
                })
            }
        }
    )*};
}

inquiries! {
    get_status "fmi2GetStatus" GET_STATUS status Status;
    get_real_status "fmi2GetRealStatus" GET_REAL_STATUS real_status Real;
    get_integer_status "fmi2GetIntegerStatus" GET_INTEGER_STATUS integer_status Integer;
    get_boolean_status "fmi2GetBooleanStatus" GET_BOOLEAN_STATUS boolean_status Boolean;
    get_string_status "fmi2GetStringStatus" GET_STRING_STATUS string_status Str;
}

/// fmi2ExportFiles: hands every file of the FMU beside the binaries to `receive`; 0 if all is well.
///
/// # Safety
/// `receive` may be called with `context`.
pub unsafe fn export_files<M: Model>(
    library: &Library,
    context: *mut c_void,
    receive: Option<ReceiveFile>,
) -> c_int {
    // SAFETY: forwarded.
    unsafe { files::export(library, context, receive, super::files::files::<M>) }
}
