//! The functions of FMI 2.0, one to one, and their call order; [`export_fmu!`](crate::export_fmu)
//! gives them their C names for one model.
//!
//! All of them may be called with `c` = NULL or an instance of this library that is in use by no
//! other thread, and with pointers that are NULL or valid for the number of elements given beside
//! them; that is what FMI asks of the importer.

pub use super::instantiate::{free_instance, instantiate};
pub use crate::border::export::Exported;
pub use crate::border::library::Library;

use super::component::{Body, Fmi2};
use super::description::lacking;
use super::ffi::*;
use crate::Model;
use crate::border::arguments::{Array, ArrayMut, array, array_mut, place, texts};
use crate::border::call::{C, CS, I, L, M, ME, N, S, T};
use crate::border::files;
use crate::border::functions::functions;
use crate::core::exchange::Happened;
use crate::core::fault::Fault;
use crate::core::value::Value;

// The states in which a function is allowed are those of FMI 2.0.4, section 4.2.4. Departures:
// fmi2SetupExperiment may be left out (start time 0), and what is set at a communication point can
// be read back there before the next step.
functions! { ($) Fmi2 export_fmi2_functions;
    fmi2SetDebugLogging [ANY] (on: Boolean, n: usize, categories: *const Str)
        |b| b.set_logging(on != 0, n, categories);
    /// The tolerance is for models that control their own error; the others do not use it.
    fmi2SetupExperiment [I] (tolerance_defined: Boolean, tolerance: Real, start: Real, stop_defined: Boolean, stop: Real)
        |b| {
            let tolerance = (tolerance_defined != 0).then_some(tolerance);
            b.instance.set_experiment(tolerance, start, (stop_defined != 0).then_some(stop))
        };
    fmi2EnterInitializationMode [I] ()
        |b| { b.instance.enter_initialization(); Ok(()) };
    fmi2ExitInitializationMode [N] ()
        |b| b.exit_initialization();
    fmi2Terminate [S | M | C | L] ()
        |b| { b.instance.terminate(); Ok(()) };
    fmi2Reset [ANY] ()
        |b| b.reset();

    fmi2GetReal [GET] (vr: *const ValueReference, n: usize, value: *mut Real)
        |b| get(b, array("vr", vr, n)?, array_mut("value", value, n)?, |x: f64| x);
    fmi2GetInteger [GET] (vr: *const ValueReference, n: usize, value: *mut Integer)
        |b| get(b, array("vr", vr, n)?, array_mut("value", value, n)?, |x: i32| x);
    fmi2GetBoolean [GET] (vr: *const ValueReference, n: usize, value: *mut Boolean)
        |b| get(b, array("vr", vr, n)?, array_mut("value", value, n)?, |x: bool| Boolean::from(x));
    /// The texts stay valid until the next call of it.
    fmi2GetString [GET] (vr: *const ValueReference, n: usize, value: *mut Str)
        |b| {
            let (vr, value) = (array("vr", vr, n)?, array_mut("value", value, n)?);
            b.get_texts((0..n).map(|k| vr.get(k)), value)
        };
    fmi2SetReal [I | N | S | M | C] (vr: *const ValueReference, n: usize, value: *const Real)
        |b| { let vr = array("vr", vr, n)?; b.instance.check_between_events(|k| vr.at(k))?; set(b, vr, array("value", value, n)?, |x: Real| x) };
    fmi2SetInteger [I | N | S | M] (vr: *const ValueReference, n: usize, value: *const Integer)
        |b| set(b, array("vr", vr, n)?, array("value", value, n)?, |x: Integer| x);
    fmi2SetBoolean [I | N | S | M] (vr: *const ValueReference, n: usize, value: *const Boolean)
        |b| set(b, array("vr", vr, n)?, array("value", value, n)?, |x: Boolean| x != 0);
    fmi2SetString [I | N | S | M] (vr: *const ValueReference, n: usize, value: *const Str)
        |b| {
            let (vr, value) = (array("vr", vr, n)?, texts("value", value, n)?);
            b.set_texts(vr.iter(), &value)
        };

    fmi2GetFMUstate [I | N | S | M | C | T] (state: *mut FmuState)
        |b| b.save("FMUstate", state);
    fmi2SetFMUstate [ANY] (state: FmuState)
        |b| b.restore(state.addr());
    fmi2FreeFMUstate [ANY] (state: *mut FmuState)
        |b| b.free("FMUstate", state);
    fmi2SerializedFMUstateSize [ANY] (state: FmuState, size: *mut usize)
        |b| b.serialized_size(state, size);
    /// Room beyond the end of the state is left alone.
    fmi2SerializeFMUstate [ANY] (state: FmuState, bytes: *mut Byte, size: usize)
        |b| b.serialize(state, bytes.cast::<u8>(), size);
    fmi2DeSerializeFMUstate [ANY] (bytes: *const Byte, size: usize, state: *mut FmuState)
        |b| b.deserialize(bytes.cast::<u8>(), size, "FMUstate", state);

    fmi2GetDirectionalDerivative [GET] (
        unknown: *const ValueReference, n_unknown: usize, known: *const ValueReference, n_known: usize,
        seed: *const Real, result: *mut Real
    ) |b| {
        b.instance.has_derivatives("providesDirectionalDerivative")?;
        let (unknown, known) = (array("vUnknown_ref", unknown, n_unknown)?, array("vKnown_ref", known, n_known)?);
        let (seed, result) = (array("dvKnown", seed, n_known)?, array_mut("dvUnknown", result, n_unknown)?);
        b.instance.directional_derivative(
            n_unknown,
            |k| unknown.get(k),
            n_known,
            |k| known.get(k),
            |k| seed.get(k),
            |k, value| result.put(k, value),
        )
    };
    fmi2SetRealInputDerivatives [CS | I | N | S] (vr: *const ValueReference, n: usize, order: *const Integer, value: *const Real)
        |b| {
            let (vr, order, value) = (array("vr", vr, n)?, array("order", order, n)?, array("value", value, n)?);
            b.instance.set_input_derivatives(n, |k| vr.get(k), |k| order.get(k), |k| value.get(k))
        };
    fmi2GetRealOutputDerivatives [CS | S | T] (vr: *const ValueReference, n: usize, order: *const Integer, value: *mut Real)
        |b| {
            let (vr, order, value) = (array("vr", vr, n)?, array("order", order, n)?, array_mut("value", value, n)?);
            b.instance.has_output_derivatives()?;
            b.instance.check_first_order(n, |k| vr.get(k), |k| order.get(k))?;
            b.instance.output_derivatives(n, |k| vr.get(k), |k, x| value.put(k, x))
        };

    fmi2EnterEventMode [ME | M | C] ()
        |b| { b.instance.enter_events(); Ok(()) };
    fmi2NewDiscreteStates [ME | M] (info: *mut EventInfo)
        |b| {
            let to = place("eventInfo", info)?;
            let Happened { event, is_moved } = b.instance.update_discrete_states()?;
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
    fmi2EnterContinuousTimeMode [ME | M] ()
        |b| { b.instance.enter_continuous_time(); Ok(()) };
    fmi2CompletedIntegratorStep [ME | C] (no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean)
        |b| {
            let (enter, terminate) = (place("enterEventMode", enter_event_mode)?, place("terminateSimulation", terminate)?);
            enter.put(0, b.instance.completed_step()?.into());
            terminate.put(0, 0);
            Ok(())
        };
    fmi2SetTime [ME | M | C] (time: Real)
        |b| b.instance.set_time(time);
    fmi2SetContinuousStates [ME | C] (x: *const Real, n: usize)
        |b| { let x = array("x", x, n)?; b.instance.set_continuous_states("nx", n, |k| x.get(k)) };
    fmi2GetDerivatives [ME | M | C | T] (derivatives: *mut Real, n: usize)
        |b| { let to = array_mut("derivatives", derivatives, n)?; to.put_all(0, b.instance.derivatives("nx", n)?, |x| x); Ok(()) };
    fmi2GetEventIndicators [ME | N | M | C | T] (indicators: *mut Real, n: usize)
        |b| { let to = array_mut("eventIndicators", indicators, n)?; to.put_all(0, b.instance.event_indicators("ni", n)?, |x| x); Ok(()) };
    fmi2GetContinuousStates [ME | N | M | C | T] (x: *mut Real, n: usize)
        |b| { let to = array_mut("x", x, n)?; to.put_all(0, b.instance.continuous_states("nx", n)?, |x| x); Ok(()) };
    fmi2GetNominalsOfContinuousStates [ME | I | M | C | T] (x: *mut Real, n: usize)
        |b| { let to = array_mut("x_nominal", x, n)?; to.put_all(0, &b.instance.nominals("nx", n)?, |x| x); Ok(()) };

    fmi2DoStep [S] (t: Real, h: Real, no_set_prior: Boolean)
        |b| b.do_step(t, h);
    fmi2CancelStep [CS | I | N | S | T] ()
        Body::cancel_step;
    fmi2GetStatus [CS | S | T | L] (kind: c_int, value: *mut Status)
        |b| { let to = place("value", value)?; to.put(0, b.status(kind)?); Ok(()) };
    fmi2GetRealStatus [CS | S | T | L] (kind: c_int, value: *mut Real)
        |b| { let to = place("value", value)?; to.put(0, b.real_status(kind)?); Ok(()) };
    fmi2GetIntegerStatus [CS | S | T | L] (kind: c_int, value: *mut Integer)
        |b| { let to = place("value", value)?; to.put(0, b.integer_status(kind)?); Ok(()) };
    fmi2GetBooleanStatus [CS | S | T | L] (kind: c_int, value: *mut Boolean)
        |b| { let to = place("value", value)?; to.put(0, b.boolean_status(kind)?); Ok(()) };
    fmi2GetStringStatus [CS | S | T | L] (kind: c_int, value: *mut Str)
        |b| { let to = place("value", value)?; to.put(0, b.string_status(kind)?); Ok(()) };
}

/// The states of a living instance in which variables can be read.
const GET: u16 = N | S | M | C | T;
/// Every state.
const ANY: u16 = I | GET | L;

/// Sets elements.
#[inline(always)]
fn set<M: Model, C: Copy, T: Value>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    values: Array<C>,
    from_c: impl Fn(C) -> T + Copy,
) -> Result<(), Fault> {
    // Of two words, so that it is handed on in registers.
    let (vr, values) = (&vr, &values);
    (b.instance).set(move |k| Some((vr.at(k)?, from_c(values.at(k)?))))
}

/// Gets elements.
#[inline(always)]
fn get<M: Model, C: Copy, T: Value>(
    b: &mut Body<M>,
    vr: Array<ValueReference>,
    values: ArrayMut<C>,
    to_c: impl Fn(T) -> C,
) -> Result<(), Fault> {
    (b.instance).get(|k| vr.at(k), |k, value| values.put(k, to_c(value)))
}

/// fmi2ExportFiles: hands every file of the FMU beside the binaries to `receive`; 0 if all is well, 2
/// if a variable is of a type that FMI 2.0 does not have.
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
        unsafe { files::export(library, context, receive, super::files::files::<X::Model>) };
    match lacking::<X::Model>() {
        Some(_) => 2,
        None => status,
    }
}
