//! The functions of FMI 3.0, one to one, and their call order; [`export_fmu!`](crate::export_fmu)
//! gives them their C names for one model. Those that get and set variables are in `values`, those
//! of what these FMUs do not have in `absent`.
//!
//! All of them may be called with an instance that is NULL or of this library and in use by no other thread, and with pointers that are NULL or
//! valid for the number of elements given beside them; that is what FMI asks of the importer.

pub use super::absent::*;
pub use super::instantiate::{CoSimulation, free_instance, instantiate, refuse_instantiation};
pub use super::values::*;
pub use crate::border::export::Exported;
pub use crate::border::library::Library;

use super::ffi::*;
use super::instance::Fmi3;
use super::order::{A, ANY};
use super::values::VR;
use crate::Model;
use crate::border::arguments::{array, array_mut, place};
use crate::border::body::enter;
use crate::border::call::{C, CS, Call, E, G, I, L, M, ME, N, S, T, U};
use crate::border::files;
use crate::border::functions::functions;
use crate::core::exchange::Happened;
use crate::core::fault::{OF_VARIABLES, check_number, refuse};

// Discrete states change in fmi3UpdateDiscreteStates only, so there are none to evaluate.
functions! { ($) Fmi3 export_fmi3_functions;
    fmi3SetDebugLogging [ANY] (on: Boolean, n: usize, categories: *const Str)
        |b| b.set_logging(on != 0, n, categories);
    /// The tolerance is for models that control their own error; the others do not use it.
    fmi3EnterInitializationMode [I] (tolerance_defined: Boolean, tolerance: f64, start: f64, stop_defined: Boolean, stop: f64)
        |b| {
            let tolerance = (tolerance_defined != 0).then_some(tolerance);
            b.instance.set_experiment(tolerance, start, (stop_defined != 0).then_some(stop))?;
            b.instance.enter_initialization();
            Ok(())
        };
    fmi3EnterConfigurationMode [I | S | A] ()
        |b| b.enter_configuration();
    fmi3ExitConfigurationMode [ANY] ()
        |b| b.exit_configuration();
    fmi3ExitInitializationMode [N] ()
        |b| b.exit_initialization();
    fmi3EnterEventMode [S | A | C] ()
        |b| b.enter_event_mode();
    fmi3EnterStepMode [CS | E] ()
        |b| b.enter_step_mode();
    fmi3EvaluateDiscreteStates [E | M] ()
        |_| Ok(());
    /// In Co-Simulation the values are what they are, and no event is known in advance.
    fmi3UpdateDiscreteStates [E | M] (
        need_update: *mut Boolean, terminate: *mut Boolean, nominals_changed: *mut Boolean, values_changed: *mut Boolean,
        next_event_time_defined: *mut Boolean, next_event_time: *mut f64
    ) |b| {
        let flags = [
            place("discreteStatesNeedUpdate", need_update)?,
            place("terminateSimulation", terminate)?,
            place("nominalsOfContinuousStatesChanged", nominals_changed)?,
            place("valuesOfContinuousStatesChanged", values_changed)?,
            place("nextEventTimeDefined", next_event_time_defined)?,
        ];
        let next_event_time = place("nextEventTime", next_event_time)?;
        let Happened { event, is_moved } = b.update_discrete_states()?;
        let values = [event.again, event.terminate, false, is_moved, event.next.is_some()];
        for (flag, value) in flags.into_iter().zip(values) {
            flag.put(0, value.into());
        }
        if let Some(next) = event.next {
            next_event_time.put(0, next);
        }
        Ok(())
    };
    fmi3EnterContinuousTimeMode [ME | M] ()
        |b| { b.instance.enter_continuous_time(); Ok(()) };
    fmi3CompletedIntegratorStep [ME | C] (no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean)
        |b| {
            let (enter, terminate) = (place("enterEventMode", enter_event_mode)?, place("terminateSimulation", terminate)?);
            enter.put(0, b.instance.completed_step()?.into());
            terminate.put(0, 0);
            Ok(())
        };
    fmi3SetTime [ME | M | C] (time: f64)
        |b| b.instance.set_time(time);
    fmi3SetContinuousStates [ME | C] (states: *const f64, n: usize)
        |b| { let x = array("continuousStates", states, n)?; b.instance.set_continuous_states(STATES, n, |k| x.get(k)) };
    fmi3GetContinuousStateDerivatives [ME | N | M | C | T] (derivatives: *mut f64, n: usize)
        |b| { let to = array_mut("derivatives", derivatives, n)?; to.put_all(0, b.instance.derivatives(STATES, n)?, |x| x); Ok(()) };
    fmi3GetEventIndicators [ME | N | M | C | T] (indicators: *mut f64, n: usize)
        |b| {
            let to = array_mut("eventIndicators", indicators, n)?;
            to.put_all(0, b.instance.event_indicators("nEventIndicators", n)?, |x| x);
            Ok(())
        };
    fmi3GetContinuousStates [ME | N | M | C | T] (states: *mut f64, n: usize)
        |b| { let to = array_mut("continuousStates", states, n)?; to.put_all(0, b.instance.continuous_states(STATES, n)?, |x| x); Ok(()) };
    fmi3GetNominalsOfContinuousStates [ME | N | M | C | T] (nominals: *mut f64, n: usize)
        |b| { let to = array_mut("nominals", nominals, n)?; to.put_all(0, &b.instance.nominals(STATES, n)?, |x| x); Ok(()) };
    fmi3GetNumberOfEventIndicators [ME | I | N | M | C | T] (n: *mut usize)
        |b| { place("nEventIndicators", n)?.put(0, b.instance.layout.indicators); Ok(()) };
    fmi3GetNumberOfContinuousStates [ME | I | N | M | C | T] (n: *mut usize)
        |b| { place(STATES, n)?.put(0, b.instance.layout.states); Ok(()) };
    fmi3Terminate [E | S | A | M | C | L] ()
        |b| { b.instance.terminate(); Ok(()) };
    fmi3Reset [ANY] ()
        |b| b.reset();

    fmi3GetFMUState [I | G | N | E | S | A | M | C | T] (state: *mut FmuState)
        |b| b.save("FMUState", state);
    fmi3SetFMUState [ANY] (state: FmuState)
        |b| b.restore(state.addr());
    fmi3FreeFMUState [ANY] (state: *mut FmuState)
        |b| b.free("FMUState", state);
    fmi3SerializedFMUStateSize [ANY] (state: FmuState, size: *mut usize)
        |b| b.serialized_size(state, size);
    /// Room beyond the end of the state is left alone.
    fmi3SerializeFMUState [ANY] (state: FmuState, bytes: *mut Byte, size: usize)
        |b| b.serialize(state, bytes, size);
    fmi3DeserializeFMUState [ANY] (bytes: *const Byte, size: usize, state: *mut FmuState)
        |b| b.deserialize(bytes, size, "FMUState", state);

    fmi3GetDirectionalDerivative [N | E | S | A | M | C | T] (
        unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize,
        seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
    ) |b| {
        b.instance.has_derivatives("providesDirectionalDerivatives")?;
        let (unknowns, knowns) = (array("unknowns", unknowns, n_unknowns)?, array("knowns", knowns, n_knowns)?);
        let (seed, result) = (array("seed", seed, n_seed)?, array_mut("sensitivity", sensitivity, n_sensitivity)?);
        let unknowns = b.elements(n_unknowns, |k| unknowns.get(k))?;
        let knowns = b.elements(n_knowns, |k| knowns.get(k))?;
        check_number("nSeed", n_seed, knowns.len(), OF_VARIABLES)?;
        check_number("nSensitivity", n_sensitivity, unknowns.len(), OF_VARIABLES)?;
        b.instance.directional_derivative(
            n_sensitivity,
            |k| unknowns[k],
            n_seed,
            |k| knowns[k],
            |k| seed.get(k),
            |k, value| result.put(k, value),
        )
    };
    fmi3GetAdjointDerivative [N | E | S | A | M | C | T] (
        unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize,
        seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
    ) |b| {
        b.instance.has_derivatives("providesAdjointDerivatives")?;
        let (unknowns, knowns) = (array("unknowns", unknowns, n_unknowns)?, array("knowns", knowns, n_knowns)?);
        let (seed, result) = (array("seed", seed, n_seed)?, array_mut("sensitivity", sensitivity, n_sensitivity)?);
        let unknowns = b.elements(n_unknowns, |k| unknowns.get(k))?;
        let knowns = b.elements(n_knowns, |k| knowns.get(k))?;
        check_number("nSeed", n_seed, unknowns.len(), OF_VARIABLES)?;
        check_number("nSensitivity", n_sensitivity, knowns.len(), OF_VARIABLES)?;
        let seed: Vec<_> = (0..n_seed).map(|k| seed.get(k)).collect();
        let adjoint = b.instance.adjoint_derivative(&unknowns, &seed, &knowns)?;
        result.put_all(0, &adjoint, |x| x);
        Ok(())
    };
    fmi3GetOutputDerivatives [CS | S | U | T] (
        vr: *const ValueReference, n: usize, orders: *const i32, values: *mut f64, n_values: usize
    ) |b| {
        let (vr, orders) = (array(VR, vr, n)?, array("orders", orders, n)?);
        let values = array_mut("values", values, n_values)?;
        b.check_update(|k| vr.at(k))?;
        b.instance.has_output_derivatives()?;
        let elements = b.elements(n, |k| vr.get(k))?;
        b.instance.check_first_order(n, |k| vr.get(k), |k| orders.get(k))?;
        check_number("nValues", n_values, elements.len(), OF_VARIABLES)?;
        b.instance.output_derivatives(n_values, |k| elements[k], |k, value| values.put(k, value))
    };

    fmi3GetNumberOfVariableDependencies [I | N | E | S | A | M | C | T] (dependent: ValueReference, n: *mut usize)
        |b| {
            let to = place("nDependencies", n)?;
            to.put(0, b.dependencies(dependent)?.len());
            Ok(())
        };
    fmi3GetVariableDependencies [I | N | E | S | A | M | C | T] (
        dependent: ValueReference, elements: *mut usize, independents: *mut ValueReference, independent_elements: *mut usize,
        kinds: *mut c_int, n: usize
    ) |b| {
        let elements = array_mut("elementIndicesOfDependent", elements, n)?;
        let independents = array_mut("independents", independents, n)?;
        let independent_elements = array_mut("elementIndicesOfIndependents", independent_elements, n)?;
        let kinds = array_mut("dependencyKinds", kinds, n)?;
        let dependencies = b.dependencies(dependent)?;
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

/// What FMI calls the number of states.
const STATES: &str = "nContinuousStates";

const DO_STEP: Call = Call::new("fmi3DoStep", S | A);
const LEAVE_UPDATE: Call = Call::new("fmi3DoStep", U | L);

/// fmi3DoStep, and at its end the intermediate update, if the importer wants any.
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
        enter::<X::Model, Fmi3>(c, DO_STEP, |b| {
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
        return unsafe { show::<X::Model>(c) };
    }
    status
}

/// Intermediate Update Mode: no reference to the instance lives while the importer looks at it.
#[cold]
unsafe fn show<M: Model>(c: Instance) -> Status {
    let mut update = None;
    // SAFETY: forwarded.
    let status = unsafe {
        enter::<M, Fmi3>(c, LEAVE_UPDATE, |b| {
            update = b.own.update.clone().map(|u| (u, b.instance.state.time));
            Ok(())
        })
    };
    let Some((update, time)) = update else {
        return status;
    };
    let (mut early_return_requested, mut early_return_time) = (0, 0.0);
    // SAFETY: the importer's callback, with places for its answers; nothing is returned early, so
    // they are not looked at.
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
        enter::<M, Fmi3>(c, LEAVE_UPDATE, |b| {
            b.own.stepping = S;
            Ok(())
        })
    }
}

/// fmi3ExportFiles: hands every file of the FMU beside the binaries to `receive`; 0 if all is well.
///
/// # Safety
/// `receive` may be called with `context`.
pub unsafe fn export_files<X: Exported>(
    library: &Library,
    context: *mut c_void,
    receive: Option<ReceiveFile>,
) -> c_int {
    // SAFETY: forwarded.
    unsafe { files::export(library, context, receive, super::files::files::<X::Model>) }
}
