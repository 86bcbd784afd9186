//! The functions of FMI 3.0, one to one; [`export_fmu!`](crate::export_fmu) gives them their C names for one model.
//!
//! All of them may be called with an instance that is NULL or of this library, made by fmi3InstantiateCoSimulation, and in use by no
//! other thread, and with pointers that are NULL or valid for the number of elements given beside them; that is what FMI asks of the importer.

pub use super::absent::*;
pub use super::instantiate::{free_instance, instantiate_co_simulation, refuse_instantiation};
pub use super::values::{
    get_boolean, get_float64, get_int32, get_int64, get_string, set_boolean, set_float64,
    set_int32, set_int64, set_string,
};
pub use crate::border::library::Library;

use super::calls;
use super::ffi::*;
use super::instance::{Body, Fmi3, enter};
use crate::Model;
use crate::border::arguments::{array, array_mut, place, texts};
use crate::border::call::{S, U};
use crate::border::files;
use crate::core::fault::{Fault, refuse};

/// fmi3SetDebugLogging.
///
/// # Safety
/// See the module.
pub unsafe fn set_debug_logging<M: Model>(
    c: Instance,
    on: Boolean,
    n: usize,
    categories: *const Str,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::SET_DEBUG_LOGGING, |b| {
            let names = texts("categories", categories, n)?;
            b.log.switch(on != 0, &names, M::INFO.log_categories)?;
            b.instance.wanted = b.log.wanted_of_model();
            Ok(())
        })
    }
}

/// fmi3EnterInitializationMode. The tolerance is for models that control their own error: not used, whatever it is.
///
/// # Safety
/// See the module.
pub unsafe fn enter_initialization_mode<M: Model>(
    c: Instance,
    _tolerance_defined: Boolean,
    _tolerance: f64,
    start: f64,
    stop_defined: Boolean,
    stop: f64,
) -> Status {
    let stop = (stop_defined != 0).then_some(stop);
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::ENTER_INITIALIZATION_MODE, |b| {
            b.instance.set_times(start, stop)?;
            b.instance.enter_initialization();
            Ok(())
        })
    }
}

macro_rules! without_arguments {
    ($($function:ident $c_name:literal $call:ident $run:expr;)*) => {$(
        #[doc = concat!($c_name, ".\n\n# Safety\nSee the module.")]
        pub unsafe fn $function<M: Model>(c: Instance) -> Status {
            let run: fn(&mut Body<M>) -> Result<(), Fault> = $run;
            // SAFETY: forwarded.
            unsafe { enter::<M, Fmi3>(c, calls::$call, run) }
        }
    )*};
}

// Nothing in these FMUs happens in Event Mode but the exchange of values, so there are no discrete states to evaluate.
without_arguments! {
    exit_initialization_mode "fmi3ExitInitializationMode" EXIT_INITIALIZATION_MODE |b| b.exit_initialization();
    enter_event_mode "fmi3EnterEventMode" ENTER_EVENT_MODE |b| b.enter_event_mode();
    enter_step_mode "fmi3EnterStepMode" ENTER_STEP_MODE |b| b.enter_step_mode();
    evaluate_discrete_states "fmi3EvaluateDiscreteStates" EVALUATE_DISCRETE_STATES |_| Ok(());
    terminate "fmi3Terminate" TERMINATE |b| { b.instance.terminate(); Ok(()) };
    reset "fmi3Reset" RESET |b| b.reset();
}

/// fmi3UpdateDiscreteStates: the values are what they are, and no event is known in advance.
///
/// # Safety
/// See the module.
pub unsafe fn update_discrete_states<M: Model>(
    c: Instance,
    need_update: *mut Boolean,
    terminate: *mut Boolean,
    nominals_changed: *mut Boolean,
    values_changed: *mut Boolean,
    next_event_time_defined: *mut Boolean,
    next_event_time: *mut f64,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::UPDATE_DISCRETE_STATES, |_| {
            let flags = [
                place("discreteStatesNeedUpdate", need_update)?,
                place("terminateSimulation", terminate)?,
                place("nominalsOfContinuousStatesChanged", nominals_changed)?,
                place("valuesOfContinuousStatesChanged", values_changed)?,
                place("nextEventTimeDefined", next_event_time_defined)?,
            ];
            place("nextEventTime", next_event_time)?;
            for flag in flags {
                flag.put(0, 0);
            }
            Ok(())
        })
    }
}

/// fmi3DoStep, and at its end the intermediate update, if the importer wants any.
///
/// # Safety
/// See the module.
#[inline]
pub unsafe fn do_step<M: Model>(
    c: Instance,
    t: f64,
    h: f64,
    event: *mut Boolean,
    terminate: *mut Boolean,
    early_return: *mut Boolean,
    last_time: *mut f64,
) -> Status {
    let mut is_shown = false;
    // SAFETY: forwarded.
    let status = unsafe {
        enter::<M, Fmi3>(c, calls::DO_STEP, |b| {
            let event = place("eventHandlingNeeded", event)?;
            let terminate = place("terminateSimulation", terminate)?;
            let early_return = place("earlyReturn", early_return)?;
            let last_time = place("lastSuccessfulTime", last_time)?;
            let step = b.do_step(t, h)?;
            event.put(0, step.event.into());
            terminate.put(0, step.terminate.into());
            early_return.put(0, step.is_early.into());
            last_time.put(0, step.time);
            if b.own.update.is_some() {
                b.own.stepping = U;
                is_shown = true;
            }
            Ok(())
        })
    };
    if is_shown {
        // SAFETY: forwarded.
        return unsafe { show::<M>(c) };
    }
    status
}

/// Intermediate Update Mode: no reference to the instance lives while the importer looks at it.
#[cold]
unsafe fn show<M: Model>(c: Instance) -> Status {
    let mut update = None;
    // SAFETY: forwarded.
    let status = unsafe {
        enter::<M, Fmi3>(c, calls::LEAVE_UPDATE, |b| {
            update = b.own.update.clone().map(|u| (u, b.instance.state.time));
            Ok(())
        })
    };
    let Some((update, time)) = update else {
        return status;
    };
    let (mut early_return_requested, mut early_return_time) = (0, 0.0);
    // SAFETY: the importer's callback, with places for its answers; nothing is returned early, so they are not looked at.
    unsafe {
        (update.callback)(
            update.environment,
            time,
            0,
            1,
            1,
            0,
            &mut early_return_requested,
            &mut early_return_time,
        );
        enter::<M, Fmi3>(c, calls::LEAVE_UPDATE, |b| {
            b.own.stepping = S;
            Ok(())
        })
    }
}

/// fmi3GetFMUState.
///
/// # Safety
/// See the module.
pub unsafe fn get_fmu_state<M: Model>(c: Instance, state: *mut FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M, Fmi3>(c, calls::GET_FMU_STATE, |b| b.save("FMUState", state)) }
}

/// fmi3SetFMUState.
///
/// # Safety
/// See the module.
pub unsafe fn set_fmu_state<M: Model>(c: Instance, state: FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M, Fmi3>(c, calls::SET_FMU_STATE, |b| b.restore(state.addr())) }
}

/// fmi3FreeFMUState.
///
/// # Safety
/// See the module.
pub unsafe fn free_fmu_state<M: Model>(c: Instance, state: *mut FmuState) -> Status {
    // SAFETY: forwarded.
    unsafe { enter::<M, Fmi3>(c, calls::FREE_FMU_STATE, |b| b.free("FMUState", state)) }
}

/// fmi3SerializedFMUStateSize.
///
/// # Safety
/// See the module.
pub unsafe fn serialized_fmu_state_size<M: Model>(
    c: Instance,
    state: FmuState,
    size: *mut usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::SERIALIZED_FMU_STATE_SIZE, |b| {
            b.serialized_size(state, size)
        })
    }
}

/// fmi3SerializeFMUState; room beyond the end of the state is left alone.
///
/// # Safety
/// See the module.
pub unsafe fn serialize_fmu_state<M: Model>(
    c: Instance,
    state: FmuState,
    bytes: *mut Byte,
    size: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::SERIALIZE_FMU_STATE, |b| {
            b.serialize(state, bytes, size)
        })
    }
}

/// fmi3DeserializeFMUState.
///
/// # Safety
/// See the module.
pub unsafe fn deserialize_fmu_state<M: Model>(
    c: Instance,
    serialized: *const Byte,
    size: usize,
    state: *mut FmuState,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::DESERIALIZE_FMU_STATE, |b| {
            b.deserialize(serialized, size, "FMUState", state)
        })
    }
}

/// Refuses a number of values that is not that of the elements of the variables.
fn check_number(name: &str, given: usize, needed: usize) -> Result<(), Fault> {
    if given == needed {
        return Ok(());
    }
    refuse!("{name} = {given} must be {needed}, the number of elements of these variables")
}

fn check_provided<M: Model>(flag: &str) -> Result<(), Fault> {
    if M::INFO.directional_derivatives {
        return Ok(());
    }
    refuse!("this FMU has no derivatives ({flag} = false)")
}

/// fmi3GetDirectionalDerivative.
///
/// # Safety
/// See the module.
#[expect(clippy::too_many_arguments, reason = "those of FMI")]
pub unsafe fn get_directional_derivative<M: Model>(
    c: Instance,
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    seed: *const f64,
    n_seed: usize,
    sensitivity: *mut f64,
    n_sensitivity: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::GET_DIRECTIONAL_DERIVATIVE, |b| {
            check_provided::<M>("providesDirectionalDerivatives")?;
            let unknowns = array("unknowns", unknowns, n_unknowns)?;
            let knowns = array("knowns", knowns, n_knowns)?;
            let seed = array("seed", seed, n_seed)?;
            let result = array_mut("sensitivity", sensitivity, n_sensitivity)?;
            let unknowns = b.elements(n_unknowns, |k| unknowns.get(k))?;
            let knowns = b.elements(n_knowns, |k| knowns.get(k))?;
            check_number("nSeed", n_seed, knowns.len())?;
            check_number("nSensitivity", n_sensitivity, unknowns.len())?;
            b.instance.directional_derivative(
                n_sensitivity,
                |k| unknowns[k],
                n_seed,
                |k| knowns[k],
                |k| seed.get(k),
                |k, value| result.put(k, value),
            )
        })
    }
}

/// fmi3GetAdjointDerivative.
///
/// # Safety
/// See the module.
#[expect(clippy::too_many_arguments, reason = "those of FMI")]
pub unsafe fn get_adjoint_derivative<M: Model>(
    c: Instance,
    unknowns: *const ValueReference,
    n_unknowns: usize,
    knowns: *const ValueReference,
    n_knowns: usize,
    seed: *const f64,
    n_seed: usize,
    sensitivity: *mut f64,
    n_sensitivity: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::GET_ADJOINT_DERIVATIVE, |b| {
            check_provided::<M>("providesAdjointDerivatives")?;
            let unknowns = array("unknowns", unknowns, n_unknowns)?;
            let knowns = array("knowns", knowns, n_knowns)?;
            let seed = array("seed", seed, n_seed)?;
            let result = array_mut("sensitivity", sensitivity, n_sensitivity)?;
            let unknowns = b.elements(n_unknowns, |k| unknowns.get(k))?;
            let knowns = b.elements(n_knowns, |k| knowns.get(k))?;
            check_number("nSeed", n_seed, unknowns.len())?;
            check_number("nSensitivity", n_sensitivity, knowns.len())?;
            let seed: Vec<_> = (0..n_seed).map(|k| seed.get(k)).collect();
            let adjoint = (b.instance).adjoint_derivative(&unknowns, &seed, &knowns)?;
            for (k, value) in adjoint.into_iter().enumerate() {
                result.put(k, value);
            }
            Ok(())
        })
    }
}

/// fmi3GetOutputDerivatives.
///
/// # Safety
/// See the module.
pub unsafe fn get_output_derivatives<M: Model>(
    c: Instance,
    vr: *const ValueReference,
    n: usize,
    orders: *const i32,
    values: *mut f64,
    n_values: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::GET_OUTPUT_DERIVATIVES, |b| {
            let (vr, orders) = (
                array("valueReferences", vr, n)?,
                array("orders", orders, n)?,
            );
            let values = array_mut("values", values, n_values)?;
            b.check_update(|k| vr.at(k))?;
            if !M::INFO.output_derivatives {
                return refuse!(
                    "this FMU has no output derivatives (maxOutputDerivativeOrder = 0)"
                );
            }
            let elements = b.elements(n, |k| vr.get(k))?;
            if let Some(k) = (0..n).find(|&k| orders.get(k) != 1) {
                let (i, row) = b.instance.layout.find(vr.get(k))?;
                let (name, order) = (row.element_name(i), orders.get(k));
                return refuse!("`{name}`: order of derivative = {order} must be 1");
            }
            check_number("nValues", n_values, elements.len())?;
            b.instance.output_derivatives(
                n_values,
                |k| elements[k],
                |k, value| values.put(k, value),
            )
        })
    }
}

/// fmi3GetNumberOfVariableDependencies.
///
/// # Safety
/// See the module.
pub unsafe fn get_number_of_variable_dependencies<M: Model>(
    c: Instance,
    dependent: ValueReference,
    n: *mut usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::GET_NUMBER_OF_DEPENDENCIES, |b| {
            let to = place("nDependencies", n)?;
            to.put(0, b.dependencies(dependent)?.len());
            Ok(())
        })
    }
}

/// fmi3GetVariableDependencies.
///
/// # Safety
/// See the module.
pub unsafe fn get_variable_dependencies<M: Model>(
    c: Instance,
    dependent: ValueReference,
    elements: *mut usize,
    independents: *mut ValueReference,
    independent_elements: *mut usize,
    kinds: *mut c_int,
    n: usize,
) -> Status {
    // SAFETY: forwarded.
    unsafe {
        enter::<M, Fmi3>(c, calls::GET_DEPENDENCIES, |b| {
            let elements = array_mut("elementIndicesOfDependent", elements, n)?;
            let independents = array_mut("independents", independents, n)?;
            let independent_elements =
                array_mut("elementIndicesOfIndependents", independent_elements, n)?;
            let kinds = array_mut("dependencyKinds", kinds, n)?;
            let dependencies = b.dependencies(dependent)?;
            let needed = dependencies.len();
            if n != needed {
                return refuse!(
                    "nDependencies = {n} must be {needed}, as fmi3GetNumberOfVariableDependencies says"
                );
            }
            for (k, found) in dependencies.into_iter().enumerate() {
                elements.put(k, found.element);
                independents.put(k, found.independent);
                independent_elements.put(k, found.independent_element);
                kinds.put(k, found.kind);
            }
            Ok(())
        })
    }
}

/// fmi3ExportFiles: hands every file of the FMU beside the binaries to `receive`; 0 if all is well.
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
