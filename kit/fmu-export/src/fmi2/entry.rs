//! The functions of FMI 2.0 for importers and the states in which each may be called, for any
//! model; [`export_fmu!`](crate::export_fmu) exports them under their C names for one model.
//!
//! # Safety
//! As FMI requires of the importer: `c` is NULL or an instance of this library that no other thread
//! is using, and each pointer is NULL or valid for the number of elements passed with it.

pub use super::instantiate::{free_instance, instantiate};
pub use crate::c_api::export::Exported;
pub use crate::c_api::library::Library;

use super::description::{self, unsupported_type};
use super::ffi::{self, *};
use super::instance::{Fmi2, Fmi2Instance};
use crate::Model;
use crate::c_api::arguments::{Array, ArrayMut, array, array_mut, output_argument, texts};
use crate::c_api::call_order::TERMINATED; // not the status kind of `ffi`
use crate::c_api::call_order::*;
use crate::c_api::files;
use crate::c_api::functions::functions;
use crate::core::fault::{Fault, discard, refuse};
use crate::core::model_exchange::EventOutcome;
use crate::core::phase::Phase;
use crate::core::value::Value;

// The states in which a function is allowed are those of FMI 2.0.4, section 4.2.4. Departures:
// fmi2SetupExperiment may be left out (start time 0), and what is set at a communication point can
// be read back there before the next step.
functions! { ($) Fmi2 export_fmi2_functions;
    fmi2SetDebugLogging [ANY] (on: Boolean, n: usize, categories: *const Str)
        |fmi| fmi.set_logging(on != 0, n, categories);
    /// Only models that choose their steps by a tolerance use it.
    fmi2SetupExperiment [INSTANTIATED] (tolerance_defined: Boolean, tolerance: Real, start: Real, stop_defined: Boolean, stop: Real)
        |fmi| {
            let tolerance = (tolerance_defined != 0).then_some(tolerance);
            fmi.instance.set_experiment(tolerance, start, (stop_defined != 0).then_some(stop))
        };
    fmi2EnterInitializationMode [INSTANTIATED] ()
        |fmi| fmi.instance.enter(Phase::Initialization);
    fmi2ExitInitializationMode [INITIALIZATION_MODE] ()
        |fmi| fmi.exit_initialization();
    fmi2Terminate [STEP_MODE | ME_STATES | LOST] ()
        |fmi| { fmi.instance.terminate(); Ok(()) };
    fmi2Reset [ANY] ()
        |fmi| fmi.reset();

    fmi2GetReal [GET] (vr: *const ValueReference, n: usize, value: *mut Real)
        |fmi| get(fmi, array("vr", vr, n)?, array_mut("value", value, n)?, |x: f64| x);
    fmi2GetInteger [GET] (vr: *const ValueReference, n: usize, value: *mut Integer)
        |fmi| get(fmi, array("vr", vr, n)?, array_mut("value", value, n)?, |x: i32| x);
    fmi2GetBoolean [GET] (vr: *const ValueReference, n: usize, value: *mut Boolean)
        |fmi| get(fmi, array("vr", vr, n)?, array_mut("value", value, n)?, |x: bool| Boolean::from(x));
    /// The texts stay valid until its next call.
    fmi2GetString [GET] (vr: *const ValueReference, n: usize, value: *mut Str)
        |fmi| {
            let (vr, value) = (array("vr", vr, n)?, array_mut("value", value, n)?);
            fmi.get_texts((0..n).map(|k| vr.get(k)), value)
        };
    fmi2SetReal [SET | CONTINUOUS_TIME_MODE] (vr: *const ValueReference, n: usize, value: *const Real)
        |fmi| { let vr = array("vr", vr, n)?; fmi.instance.check_between_events(|k| vr.at(k))?; set(fmi, vr, array("value", value, n)?, |x: Real| x) };
    fmi2SetInteger [SET] (vr: *const ValueReference, n: usize, value: *const Integer)
        |fmi| set(fmi, array("vr", vr, n)?, array("value", value, n)?, |x: Integer| x);
    fmi2SetBoolean [SET] (vr: *const ValueReference, n: usize, value: *const Boolean)
        |fmi| set(fmi, array("vr", vr, n)?, array("value", value, n)?, |x: Boolean| x != 0);
    fmi2SetString [SET] (vr: *const ValueReference, n: usize, value: *const Str)
        |fmi| {
            let (vr, value) = (array("vr", vr, n)?, texts("value", value, n)?);
            fmi.set_texts(vr.iter(), &value)
        };

    fmi2GetFMUstate [INSTANTIATED | GET] (state: *mut FmuState)
        |fmi| fmi.save("FMUstate", state);
    fmi2SetFMUstate [ANY] (state: FmuState)
        |fmi| fmi.restore(state.addr());
    fmi2FreeFMUstate [ANY] (state: *mut FmuState)
        |fmi| fmi.free("FMUstate", state);
    fmi2SerializedFMUstateSize [ANY] (state: FmuState, size: *mut usize)
        |fmi| fmi.serialized_size(state, size);
    /// The buffer beyond the end of the state is not changed.
    fmi2SerializeFMUstate [ANY] (state: FmuState, bytes: *mut Byte, size: usize)
        |fmi| fmi.serialize(state, bytes.cast::<u8>(), size);
    fmi2DeSerializeFMUstate [ANY] (bytes: *const Byte, size: usize, state: *mut FmuState)
        |fmi| fmi.deserialize(bytes.cast::<u8>(), size, "FMUstate", state);

    fmi2GetDirectionalDerivative [GET] (
        unknown: *const ValueReference, n_unknown: usize, known: *const ValueReference, n_known: usize,
        seed: *const Real, result: *mut Real
    ) |fmi| {
        fmi.instance.has_derivatives("providesDirectionalDerivative")?;
        let (unknown, known) = (array("vUnknown_ref", unknown, n_unknown)?, array("vKnown_ref", known, n_known)?);
        let (seed, result) = (array("dvKnown", seed, n_known)?, array_mut("dvUnknown", result, n_unknown)?);
        fmi.instance.directional_derivative(
            n_unknown,
            |k| unknown.get(k),
            n_known,
            |k| known.get(k),
            |k| seed.get(k),
            |k, value| result.put(k, value),
        )
    };
    fmi2SetRealInputDerivatives [CS | INSTANTIATED | INITIALIZATION_MODE | STEP_MODE] (vr: *const ValueReference, n: usize, order: *const Integer, value: *const Real)
        |fmi| {
            let (vr, order, value) = (array("vr", vr, n)?, array("order", order, n)?, array("value", value, n)?);
            fmi.instance.set_input_derivatives(n, |k| vr.get(k), |k| order.get(k), |k| value.get(k))
        };
    fmi2GetRealOutputDerivatives [CS | STEP_MODE | TERMINATED] (vr: *const ValueReference, n: usize, order: *const Integer, value: *mut Real)
        |fmi| {
            let (vr, order, value) = (array("vr", vr, n)?, array("order", order, n)?, array_mut("value", value, n)?);
            fmi.instance.has_output_derivatives()?;
            fmi.instance.check_first_order(n, |k| vr.get(k), |k| order.get(k))?;
            fmi.instance.output_derivatives(n, |k| vr.get(k), |k, x| value.put(k, x))
        };

    fmi2EnterEventMode [ME | ME_STATES] ()
        |fmi| fmi.instance.enter(Phase::Event);
    fmi2NewDiscreteStates [ME | ME_EVENT_MODE] (info: *mut EventInfo)
        |fmi| {
            let to = output_argument("eventInfo", info)?;
            let EventOutcome { event, is_moved } = fmi.instance.update_discrete_states()?;
            to.put(0, EventInfo {
                new_discrete_states_needed: event.again.into(),
                terminate_simulation: event.terminate.into(),
                nominals_of_continuous_states_changed: 0,
                values_of_continuous_states_changed: is_moved.into(),
                next_event_time_defined: event.next.is_some().into(),
                next_event_time: event.next.unwrap_or_default(),
            });
            Ok(())
        };
    fmi2EnterContinuousTimeMode [ME | ME_EVENT_MODE] ()
        |fmi| fmi.instance.enter(Phase::Continuous);
    fmi2CompletedIntegratorStep [ME | CONTINUOUS_TIME_MODE] (no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean)
        |fmi| {
            let (enter, terminate) = (output_argument("enterEventMode", enter_event_mode)?, output_argument("terminateSimulation", terminate)?);
            enter.put(0, fmi.instance.completed_step()?.into());
            terminate.put(0, 0);
            Ok(())
        };
    fmi2SetTime [ME | ME_STATES] (time: Real)
        |fmi| fmi.instance.set_time(time);
    fmi2SetContinuousStates [ME | CONTINUOUS_TIME_MODE] (x: *const Real, n: usize)
        |fmi| { let x = array("x", x, n)?; fmi.instance.set_continuous_states("nx", n, |k| x.get(k)) };
    fmi2GetDerivatives [ME | ME_STATES | TERMINATED] (derivatives: *mut Real, n: usize)
        |fmi| { let to = array_mut("derivatives", derivatives, n)?; to.put_all(0, fmi.instance.derivatives("nx", n)?, |x| x); Ok(()) };
    fmi2GetEventIndicators [ME | INITIALIZATION_MODE | ME_STATES | TERMINATED] (indicators: *mut Real, n: usize)
        |fmi| { let to = array_mut("eventIndicators", indicators, n)?; to.put_all(0, fmi.instance.event_indicators("ni", n)?, |x| x); Ok(()) };
    fmi2GetContinuousStates [ME | INITIALIZATION_MODE | ME_STATES | TERMINATED] (x: *mut Real, n: usize)
        |fmi| { let to = array_mut("x", x, n)?; to.put_all(0, fmi.instance.continuous_states("nx", n)?, |x| x); Ok(()) };
    fmi2GetNominalsOfContinuousStates [ME | INSTANTIATED | ME_STATES | TERMINATED] (x: *mut Real, n: usize)
        |fmi| { let to = array_mut("x_nominal", x, n)?; to.put_all(0, &fmi.instance.nominals("nx", n)?, |x| x); Ok(()) };

    fmi2DoStep [STEP_MODE] (t: Real, h: Real, no_set_prior: Boolean)
        |fmi| fmi.do_step(t, h);
    /// FMI allows it during a step only, and a synchronous step is over when fmi2DoStep returns.
    fmi2CancelStep [CS | INSTANTIATED | INITIALIZATION_MODE | STEP_MODE | TERMINATED] ()
        |_| refuse!("no step is in progress: steps are synchronous");
    fmi2GetStatus [STATUS] (kind: c_int, value: *mut Status)
        |fmi| status(kind, (DO_STEP_STATUS, "fmi2DoStepStatus"), value, fmi.version.last_step);
    fmi2GetRealStatus [STATUS] (kind: c_int, value: *mut Real)
        |fmi| {
            let reached = fmi.instance.state.time;
            status(kind, (LAST_SUCCESSFUL_TIME, "fmi2LastSuccessfulTime"), value, reached)
        };
    fmi2GetIntegerStatus [STATUS] (kind: c_int, value: *mut Integer)
        |_| {
            output_argument("value", value)?;
            discard!("status kind = {kind}: FMI 2.0 has no Integer status")
        };
    /// Whether the model asked to end the simulation.
    fmi2GetBooleanStatus [STATUS] (kind: c_int, value: *mut Boolean)
        |fmi| {
            let ends = fmi.version.terminated.into();
            status(kind, (ffi::TERMINATED, "fmi2Terminated"), value, ends)
        };
    fmi2GetStringStatus [STATUS] (kind: c_int, value: *mut Str)
        |_| {
            output_argument("value", value)?;
            match kind {
                PENDING_STATUS => discard!("no step is pending: steps are synchronous"),
                _ => discard!("status kind = {kind} must be {PENDING_STATUS} (fmi2PendingStatus)"),
            }
        };
}

/// The states in which variables can be read.
const GET: u16 = INITIALIZATION_MODE | STEP_MODE | ME_STATES | TERMINATED;
/// The states in which variables can be set; continuous ones in Continuous-Time Mode too.
const SET: u16 = INSTANTIATED | INITIALIZATION_MODE | STEP_MODE | ME_EVENT_MODE;
/// The states in which the status of the last step can be read.
const STATUS: u16 = CS | STEP_MODE | TERMINATED | LOST;
/// Every state.
const ANY: u16 = INSTANTIATED | GET | LOST;

/// Sets elements.
#[inline(always)]
fn set<M: Model, C: Copy, T: Value>(
    fmi: &mut Fmi2Instance<M>,
    vr: Array<ValueReference>,
    values: Array<C>,
    from_c: impl Fn(C) -> T + Copy,
) -> Result<(), Fault> {
    // References keep the closure at two words, so that it is passed in registers.
    let (vr, values) = (&vr, &values);
    (fmi.instance).set(move |k| Some((vr.at(k)?, from_c(values.at(k)?))))
}

/// Gets elements.
#[inline(always)]
fn get<M: Model, C: Copy, T: Value>(
    fmi: &mut Fmi2Instance<M>,
    vr: Array<ValueReference>,
    values: ArrayMut<C>,
    to_c: impl Fn(T) -> C,
) -> Result<(), Fault> {
    (fmi.instance).get(|k| vr.at(k), |k, value| values.put(k, to_c(value)))
}

/// Returns the status of the last step if it is of the one kind that has a value: its number and
/// name. FMI 2.0 demands fmi2Discard for all others.
unsafe fn status<T: Copy>(
    kind: c_int,
    (known, name): (c_int, &str),
    value: *mut T,
    found: T,
) -> Result<(), Fault> {
    // SAFETY: an argument of this call.
    let to = unsafe { output_argument("value", value) }?;
    if kind != known {
        return discard!("status kind = {kind} must be {known} ({name})");
    }
    to.put(0, found);
    Ok(())
}

/// fmi2ExportFiles: passes every file of the FMU except the binaries to `receive`. Returns 0 on
/// success, and 2 if a variable has a type that FMI 2.0 does not have.
///
/// # Safety
/// `receive` may be called with `context`.
pub unsafe fn export_files<X: Exported>(
    library: &Library,
    context: *mut c_void,
    receive: Option<ReceiveFile>,
) -> c_int {
    // SAFETY: forwarded.
    let status =
        unsafe { files::export(library, context, receive, description::files::<X::Model>) };
    match unsupported_type::<X::Model>() {
        Some(_) => 2,
        None => status,
    }
}
