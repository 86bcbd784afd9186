//! The functions of FMI 2.0, one to one; [`export_fmu!`](crate::export_fmu) gives them their C names for one model.
//!
//! All of them may be called with `c` = NULL or an instance of this library that is in use by no other thread, and with
//! pointers that are NULL or valid for the number of elements given beside them; that is what FMI asks of the importer.

pub use crate::birth::{Guid, free_instance, instantiate};

use crate::border::{array, array_mut, enter, place, texts};
use crate::calls;
use crate::failure::refuse;
use crate::ffi::*;
use crate::instance::Instance;
use crate::log::c_string;
use crate::{Model, panic};
use libc::{c_int, c_void};
use std::ptr;

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
        enter::<M>(c, calls::SET_DEBUG_LOGGING, |i| {
            i.log.set(on != 0, &texts("categories", categories, n)?)
        })
    }
}

/// fmi2SetupExperiment.
///
/// # Safety
/// See the module.
pub unsafe fn setup_experiment<M: Model>(
    c: Component,
    tolerance_defined: Boolean,
    tolerance: Real,
    start: Real,
    stop_defined: Boolean,
    stop: Real,
) -> Status {
    let tolerance = (tolerance_defined != 0).then_some(tolerance);
    let stop = (stop_defined != 0).then_some(stop);
    // SAFETY: forwarded.
    unsafe {
        enter::<M>(c, calls::SETUP_EXPERIMENT, |i| {
            i.setup_experiment(tolerance, start, stop)
        })
    }
}

macro_rules! without_arguments {
    ($($function:ident $c_name:literal $call:ident $method:ident;)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $function<M: Model>(c: Component) -> Status {
            // SAFETY: forwarded.
            unsafe { enter::<M>(c, calls::$call, Instance::$method) }
        }
    )*};
}

without_arguments! {
    enter_initialization_mode "fmi2EnterInitializationMode" ENTER_INITIALIZATION_MODE enter_initialization;
    exit_initialization_mode "fmi2ExitInitializationMode" EXIT_INITIALIZATION_MODE exit_initialization;
    reset "fmi2Reset" RESET reset;
    cancel_step "fmi2CancelStep" CANCEL_STEP cancel_step;
}

/// fmi2Terminate; an instance lost by a panic can still be terminated.
///
/// # Safety
/// See the module.
pub unsafe fn terminate<M: Model>(c: Component) -> Status {
    // SAFETY: forwarded.
    let status = unsafe { enter::<M>(c, calls::TERMINATE, Instance::terminate) };
    if status == Status::Fatal {
        Status::Ok
    } else {
        status
    }
}

macro_rules! set_and_get {
    ($($set:ident $set_name:literal $set_call:ident $get:ident $get_name:literal $get_call:ident $type:ty, $c_type:ty;)*) => {$(
        #[doc = concat!($set_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $set<M: Model>(
            c: Component,
            vr: *const ValueReference,
            n: usize,
            values: *const $c_type,
        ) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M>(c, calls::$set_call, |i| {
                    i.set::<$type>(array("vr", vr, n)?, array("value", values, n)?)
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
                enter::<M>(c, calls::$get_call, |i| {
                    i.get::<$type>(array("vr", vr, n)?, array_mut("value", values, n)?)
                })
            }
        }
    )*};
}

set_and_get! {
    set_real "fmi2SetReal" SET_REAL get_real "fmi2GetReal" GET_REAL f64, Real;
    set_integer "fmi2SetInteger" SET_INTEGER get_integer "fmi2GetInteger" GET_INTEGER i32, Integer;
    set_boolean "fmi2SetBoolean" SET_BOOLEAN get_boolean "fmi2GetBoolean" GET_BOOLEAN bool, Boolean;
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
        enter::<M>(c, calls::SET_STRING, |i| {
            i.set_string(array("vr", vr, n)?, &texts("value", values, n)?)
        })
    }
}

/// fmi2GetString.
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
        enter::<M>(c, calls::GET_STRING, |i| {
            let (vr, values) = (array("vr", vr, n)?, array_mut("value", values, n)?);
            for (to, text) in values.iter_mut().zip(i.get_string(vr)?) {
                *to = text.as_ptr();
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
    unsafe {
        enter::<M>(c, calls::GET_FMU_STATE, |i| {
            let state = place("FMUstate", state)?;
            *state = i.save(*state)?;
            Ok(())
        })
    }
}

/// fmi2SetFMUstate.
///
/// # Safety
/// See the module.
pub unsafe fn set_fmu_state<M: Model>(c: Component, state: FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M>(c, calls::SET_FMU_STATE, |i| i.restore(state)) }
}

/// fmi2FreeFMUstate.
///
/// # Safety
/// See the module.
pub unsafe fn free_fmu_state<M: Model>(c: Component, state: *mut FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M>(c, calls::FREE_FMU_STATE, |i| {
            if state.is_null() {
                return Ok(());
            }
            let state = place("FMUstate", state)?;
            i.free(*state)?;
            *state = ptr::null_mut();
            Ok(())
        })
    }
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
        enter::<M>(c, calls::SERIALIZED_FMU_STATE_SIZE, |i| {
            *place("size", size)? = i.serialize(state)?.len();
            Ok(())
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
        enter::<M>(c, calls::SERIALIZE_FMU_STATE, |i| {
            let state = i.serialize(state)?;
            let needed = state.len();
            match array_mut("serializedState", bytes.cast::<u8>(), size)?.get_mut(..needed) {
                Some(to) => to.copy_from_slice(&state),
                None => return refuse!("size = {size}; allowed are at least {needed} bytes"),
            }
            Ok(())
        })
    }
}

/// fmi2DeSerializeFMUstate.
///
/// # Safety
/// See the module.
pub unsafe fn deserialize_fmu_state<M: Model>(
    c: Component,
    bytes: *const Byte,
    size: usize,
    state: *mut FmuState,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M>(c, calls::DESERIALIZE_FMU_STATE, |i| {
            let bytes = array("serializedState", bytes.cast::<u8>(), size)?;
            let state = place("FMUstate", state)?;
            *state = i.deserialize(bytes, *state)?;
            Ok(())
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
        enter::<M>(c, calls::GET_DIRECTIONAL_DERIVATIVE, |i| {
            i.directional_derivative(
                array("vUnknown_ref", unknown, n_unknown)?,
                array("vKnown_ref", known, n_known)?,
                array("dvKnown", seed, n_known)?,
                array_mut("dvUnknown", result, n_unknown)?,
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
        enter::<M>(c, calls::SET_INPUT_DERIVATIVES, |i| {
            let (vr, order) = (array("vr", vr, n)?, array("order", order, n)?);
            i.set_input_derivatives(vr, order, array("value", values, n)?)
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
        enter::<M>(c, calls::GET_OUTPUT_DERIVATIVES, |i| {
            let (vr, order) = (array("vr", vr, n)?, array("order", order, n)?);
            i.output_derivatives(vr, order, array_mut("value", values, n)?)
        })
    }
}

/// fmi2DoStep.
///
/// # Safety
/// See the module.
pub unsafe fn do_step<M: Model>(c: Component, t: Real, h: Real) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M>(c, calls::DO_STEP, |i| i.do_step(t, h)) }
}

macro_rules! inquiries {
    ($($function:ident $c_name:literal $call:ident $method:ident $type:ty;)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $function<M: Model>(c: Component, kind: c_int, value: *mut $type) -> Status {
            // SAFETY: forwarded.
            unsafe {
                enter::<M>(c, calls::$call, |i| {
                    let value = place("value", value)?;
                    *value = i.$method(kind)?;
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
pub unsafe fn export_files<M: Model>(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int {
    let Some(receive) = receive else { return 1 };
    panic::silence();
    let made = panic::catch(|| crate::files::files::<M>()).unwrap_or_else(Err);
    match made {
        Ok(files) => {
            for (path, bytes) in files {
                // SAFETY: forwarded; path and bytes live until `receive` returns.
                unsafe {
                    receive(
                        context,
                        c_string(&path).as_ptr(),
                        bytes.as_ptr(),
                        bytes.len(),
                    )
                };
            }
            0
        }
        Err(reason) => {
            // SAFETY: as above.
            unsafe { receive(context, ptr::null(), reason.as_ptr(), reason.len()) };
            1
        }
    }
}
