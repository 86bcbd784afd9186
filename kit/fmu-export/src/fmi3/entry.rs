//! The functions of FMI 3.0 for importers and the states in which each may be called, for any
//! model; [`export_fmu!`](crate::export_fmu) exports them under their C names for one model. Access
//! to variables is in `values`, clocks and Scheduled Execution in `clocks`.
//!
//! # Safety
//! As FMI requires of the importer: the instance is NULL or one of this library that no other
//! thread is using, and each pointer is NULL or valid for the number of elements passed with it.

pub use super::clocks::*;
pub use super::instantiate::{CoSimulation, Interface, free_instance, instantiate};
pub use super::values::*;
pub use crate::c_api::export::Exported;
pub use crate::c_api::library::Library;

use super::ffi::*;
use super::instance::Fmi3;
use super::states::{ANY, EVENT_MODE, INITIALIZED, STEP_MODE_AFTER_SET};
use super::values::VR;
use crate::Model;
use crate::c_api::arguments::{array, array_mut, output_argument};
use crate::c_api::call_order::*;
use crate::c_api::files;
use crate::c_api::fmi_instance::enter;
use crate::c_api::functions::functions;
use crate::core::fault::{OF_VARIABLES, check_number, refuse};
use crate::core::model_exchange::EventOutcome;
use crate::core::phase::Phase;

// fmi3EvaluateDiscreteStates has nothing to do: discrete states change in fmi3UpdateDiscreteStates.
functions! { ($) Fmi3 export_fmi3_functions;
    fmi3SetDebugLogging [ANY] (on: Boolean, n: usize, categories: *const Str)
        |fmi| fmi.set_logging(on != 0, n, categories);
    /// Only models that choose their steps by a tolerance use it.
    fmi3EnterInitializationMode [INSTANTIATED] (tolerance_defined: Boolean, tolerance: f64, start: f64, stop_defined: Boolean, stop: f64)
        |fmi| {
            let tolerance = (tolerance_defined != 0).then_some(tolerance);
            fmi.instance.set_experiment(tolerance, start, (stop_defined != 0).then_some(stop))?;
            fmi.instance.enter(Phase::Initialization)
        };
    fmi3EnterConfigurationMode [INSTANTIATED | STEP_MODE | STEP_MODE_AFTER_SET] ()
        |fmi| fmi.enter_configuration();
    fmi3ExitConfigurationMode [ANY] ()
        |fmi| fmi.exit_configuration();
    fmi3ExitInitializationMode [INITIALIZATION_MODE] ()
        |fmi| fmi.exit_initialization();
    fmi3EnterEventMode [STEP_MODE | STEP_MODE_AFTER_SET | CONTINUOUS_TIME_MODE] ()
        |fmi| fmi.enter_event_mode();
    fmi3EnterStepMode [CS | CS_EVENT_MODE] ()
        |fmi| fmi.enter_step_mode();
    fmi3EvaluateDiscreteStates [EVENT_MODE] ()
        |_| Ok(());
    /// In Co-Simulation only models whose events the crate handles change here.
    fmi3UpdateDiscreteStates [EVENT_MODE] (
        need_update: *mut Boolean, terminate: *mut Boolean, nominals_changed: *mut Boolean, values_changed: *mut Boolean,
        next_event_time_defined: *mut Boolean, next_event_time: *mut f64
    ) |fmi| {
        let flags = [
            output_argument("discreteStatesNeedUpdate", need_update)?,
            output_argument("terminateSimulation", terminate)?,
            output_argument("nominalsOfContinuousStatesChanged", nominals_changed)?,
            output_argument("valuesOfContinuousStatesChanged", values_changed)?,
            output_argument("nextEventTimeDefined", next_event_time_defined)?,
        ];
        let next_event_time = output_argument("nextEventTime", next_event_time)?;
        let EventOutcome { event, is_moved } = fmi.update_discrete_states()?;
        let values = [event.again, event.terminate, false, is_moved, event.next.is_some()];
        for (flag, value) in flags.into_iter().zip(values) {
            flag.put(0, value.into());
        }
        if let Some(next) = event.next {
            next_event_time.put(0, next);
        }
        Ok(())
    };
    fmi3EnterContinuousTimeMode [ME | ME_EVENT_MODE] ()
        |fmi| fmi.instance.leave_events(Phase::Continuous);
    fmi3CompletedIntegratorStep [ME | CONTINUOUS_TIME_MODE] (no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean)
        |fmi| {
            let (enter, terminate) = (output_argument("enterEventMode", enter_event_mode)?, output_argument("terminateSimulation", terminate)?);
            enter.put(0, fmi.instance.completed_step()?.into());
            terminate.put(0, 0);
            Ok(())
        };
    fmi3SetTime [ME | ME_STATES] (time: f64)
        |fmi| fmi.instance.set_time(time);
    fmi3SetContinuousStates [ME | CONTINUOUS_TIME_MODE] (states: *const f64, n: usize)
        |fmi| { let x = array("continuousStates", states, n)?; fmi.instance.set_continuous_states(STATES, n, |k| x.get(k)) };
    fmi3GetContinuousStateDerivatives [ME | INITIALIZATION_MODE | ME_STATES | TERMINATED] (derivatives: *mut f64, n: usize)
        |fmi| { let to = array_mut("derivatives", derivatives, n)?; to.put_all(0, fmi.instance.derivatives(STATES, n)?, |x| x); Ok(()) };
    fmi3GetEventIndicators [ME | INITIALIZATION_MODE | ME_STATES | TERMINATED] (indicators: *mut f64, n: usize)
        |fmi| {
            let to = array_mut("eventIndicators", indicators, n)?;
            to.put_all(0, fmi.instance.event_indicators("nEventIndicators", n)?, |x| x);
            Ok(())
        };
    fmi3GetContinuousStates [ME | INITIALIZATION_MODE | ME_STATES | TERMINATED] (states: *mut f64, n: usize)
        |fmi| { let to = array_mut("continuousStates", states, n)?; to.put_all(0, fmi.instance.continuous_states(STATES, n)?, |x| x); Ok(()) };
    fmi3GetNominalsOfContinuousStates [ME | INITIALIZATION_MODE | ME_STATES | TERMINATED] (nominals: *mut f64, n: usize)
        |fmi| { let to = array_mut("nominals", nominals, n)?; to.put_all(0, &fmi.instance.nominals(STATES, n)?, |x| x); Ok(()) };
    fmi3GetNumberOfEventIndicators [ME | INSTANTIATED | INITIALIZATION_MODE | ME_STATES | TERMINATED] (n: *mut usize)
        |fmi| { output_argument("nEventIndicators", n)?.put(0, fmi.instance.layout.indicators); Ok(()) };
    fmi3GetNumberOfContinuousStates [ME | INSTANTIATED | INITIALIZATION_MODE | ME_STATES | TERMINATED] (n: *mut usize)
        |fmi| { output_argument(STATES, n)?.put(0, fmi.instance.layout.states); Ok(()) };
    fmi3Terminate [CS_EVENT_MODE | STEP_MODE | STEP_MODE_AFTER_SET | ME_STATES | CLOCK_ACTIVATION | LOST] ()
        |fmi| { fmi.instance.terminate(); Ok(()) };
    fmi3Reset [ANY] ()
        |fmi| fmi.reset();

    fmi3GetFMUState [INSTANTIATED | CONFIGURATION_MODE | INITIALIZED] (state: *mut FmuState)
        |fmi| fmi.save("FMUState", state);
    fmi3SetFMUState [ANY] (state: FmuState)
        |fmi| fmi.restore(state.addr());
    fmi3FreeFMUState [ANY] (state: *mut FmuState)
        |fmi| fmi.free("FMUState", state);
    fmi3SerializedFMUStateSize [ANY] (state: FmuState, size: *mut usize)
        |fmi| fmi.serialized_size(state, size);
    /// The buffer beyond the end of the state is not changed.
    fmi3SerializeFMUState [ANY] (state: FmuState, bytes: *mut Byte, size: usize)
        |fmi| fmi.serialize(state, bytes, size);
    fmi3DeserializeFMUState [ANY] (bytes: *const Byte, size: usize, state: *mut FmuState)
        |fmi| fmi.deserialize(bytes, size, "FMUState", state);

    fmi3GetDirectionalDerivative [INITIALIZED] (
        unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize,
        seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
    ) |fmi| {
        fmi.instance.has_derivatives("providesDirectionalDerivatives")?;
        let (unknowns, knowns) = (array("unknowns", unknowns, n_unknowns)?, array("knowns", knowns, n_knowns)?);
        let (seed, result) = (array("seed", seed, n_seed)?, array_mut("sensitivity", sensitivity, n_sensitivity)?);
        let unknowns = fmi.elements(n_unknowns, |k| unknowns.get(k))?;
        let knowns = fmi.elements(n_knowns, |k| knowns.get(k))?;
        check_number("nSeed", n_seed, knowns.len(), OF_VARIABLES)?;
        check_number("nSensitivity", n_sensitivity, unknowns.len(), OF_VARIABLES)?;
        fmi.instance.directional_derivative(
            n_sensitivity,
            |k| unknowns[k],
            n_seed,
            |k| knowns[k],
            |k| seed.get(k),
            |k, value| result.put(k, value),
        )
    };
    fmi3GetAdjointDerivative [INITIALIZED] (
        unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize,
        seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
    ) |fmi| {
        fmi.instance.has_derivatives("providesAdjointDerivatives")?;
        let (unknowns, knowns) = (array("unknowns", unknowns, n_unknowns)?, array("knowns", knowns, n_knowns)?);
        let (seed, result) = (array("seed", seed, n_seed)?, array_mut("sensitivity", sensitivity, n_sensitivity)?);
        let unknowns = fmi.elements(n_unknowns, |k| unknowns.get(k))?;
        let knowns = fmi.elements(n_knowns, |k| knowns.get(k))?;
        check_number("nSeed", n_seed, unknowns.len(), OF_VARIABLES)?;
        check_number("nSensitivity", n_sensitivity, knowns.len(), OF_VARIABLES)?;
        let seed: Vec<_> = (0..n_seed).map(|k| seed.get(k)).collect();
        let adjoint = fmi.instance.adjoint_derivative(&unknowns, &seed, &knowns)?;
        result.put_all(0, &adjoint, |x| x);
        Ok(())
    };
    fmi3GetOutputDerivatives [CS | STEP_MODE | INTERMEDIATE_UPDATE | TERMINATED] (
        vr: *const ValueReference, n: usize, orders: *const i32, values: *mut f64, n_values: usize
    ) |fmi| {
        let (vr, orders) = (array(VR, vr, n)?, array("orders", orders, n)?);
        let values = array_mut("values", values, n_values)?;
        fmi.check_update(|k| vr.at(k))?;
        fmi.instance.has_output_derivatives()?;
        let elements = fmi.elements(n, |k| vr.get(k))?;
        fmi.instance.check_first_order(n, |k| vr.get(k), |k| orders.get(k))?;
        check_number("nValues", n_values, elements.len(), OF_VARIABLES)?;
        fmi.instance.output_derivatives(n_values, |k| elements[k], |k, value| values.put(k, value))
    };

    fmi3GetNumberOfVariableDependencies [INSTANTIATED | INITIALIZED] (dependent: ValueReference, n: *mut usize)
        |fmi| {
            let to = output_argument("nDependencies", n)?;
            to.put(0, fmi.dependencies(dependent)?.len());
            Ok(())
        };
    fmi3GetVariableDependencies [INSTANTIATED | INITIALIZED] (
        dependent: ValueReference, elements: *mut usize, independents: *mut ValueReference, independent_elements: *mut usize,
        kinds: *mut c_int, n: usize
    ) |fmi| {
        let elements = array_mut("elementIndicesOfDependent", elements, n)?;
        let independents = array_mut("independents", independents, n)?;
        let independent_elements = array_mut("elementIndicesOfIndependents", independent_elements, n)?;
        let kinds = array_mut("dependencyKinds", kinds, n)?;
        let dependencies = fmi.dependencies(dependent)?;
        let needed = dependencies.len();
        if n != needed {
            return refuse!("nDependencies = {n} must be {needed}, as fmi3GetNumberOfVariableDependencies says");
        }
        for (k, found) in dependencies.into_iter().enumerate() {
            elements.put(k, found.element);
            independents.put(k, found.independent);
            independent_elements.put(k, found.independent_element);
            kinds.put(k, found.kind);
        }
        Ok(())
    };
}

/// Name of the argument with the number of states.
const STATES: &str = "nContinuousStates";

const DO_STEP: Call = Call::new("fmi3DoStep", CS | STEP_MODE | STEP_MODE_AFTER_SET);
const LEAVE_UPDATE: Call = Call::new("fmi3DoStep", INTERMEDIATE_UPDATE | LOST);

/// fmi3DoStep; at its end it calls the importer's intermediate update callback, if there is one.
///
/// # Safety
/// See the module.
#[inline]
pub unsafe fn do_step<X: Exported>(
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
        enter::<X::Model, Fmi3>(c, DO_STEP, |fmi| {
            let event = output_argument("eventHandlingNeeded", event)?;
            let terminate = output_argument("terminateSimulation", terminate)?;
            let early_return = output_argument("earlyReturn", early_return)?;
            let last_time = output_argument("lastSuccessfulTime", last_time)?;
            let step = fmi.do_step(t, h)?;
            event.put(0, step.event.into());
            terminate.put(0, step.terminate.into());
            early_return.put(0, (!step.is_whole).into());
            last_time.put(0, step.time);
            if fmi.version.update.is_some() {
                fmi.version.step_state = INTERMEDIATE_UPDATE;
                is_shown = true;
            }
            Ok(())
        })
    };
    if is_shown {
        // SAFETY: forwarded.
        return unsafe { show::<X::Model>(c) };
    }
    status
}

/// Intermediate Update Mode: calls the importer's callback, while no reference to the instance
/// exists, because the callback reads variables.
#[cold]
unsafe fn show<M: Model>(c: Instance) -> Status {
    let mut update = None;
    // SAFETY: forwarded.
    let status = unsafe {
        enter::<M, Fmi3>(c, LEAVE_UPDATE, |fmi| {
            let time = fmi.instance.state.time;
            update = (fmi.version.update.clone()).map(|update| (update, time));
            Ok(())
        })
    };
    let Some((update, time)) = update else {
        return status;
    };
    let (mut early_return_requested, mut early_return_time) = (0, 0.0);
    // SAFETY: the importer's callback, with pointers to its results. They are not used, because
    // steps do not return early after an intermediate update.
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
        enter::<M, Fmi3>(c, LEAVE_UPDATE, |fmi| {
            fmi.version.step_state = STEP_MODE;
            Ok(())
        })
    }
}

/// fmi3ExportFiles: passes the FMU's files except the binaries to `receive`; 0 on success.
///
/// # Safety
/// `receive` may be called with `context`.
pub unsafe fn export_files<X: Exported>(
    library: &Library,
    context: *mut c_void,
    receive: Option<ReceiveFile>,
) -> c_int {
    // SAFETY: forwarded.
    unsafe {
        files::export(
            library,
            context,
            receive,
            super::description::files::<X::Model>,
        )
    }
}
