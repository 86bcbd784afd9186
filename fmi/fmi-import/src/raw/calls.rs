//! The calls of an instance: a row for each, with the function of FMI 2.0 and that of FMI 3.0.

use std::ffi::c_int;
use std::ptr;

use fmi_description::Access;

use super::{Array, ContinuousValues, Experiment, RawInstance, StateHandle, StepEnd, room};
use crate::functions::OwnFunctions::{Fmi2, Fmi3};
use crate::status::{ABSENT, DISCARD};

/// Calls by rows: arguments, what must hold of them, and what is called of either version; `c` is the
/// instance, `f` its functions.
macro_rules! calls {
    ($self:ident, $c:ident, $f:ident: $(
        $(#[$about:meta])*
        fn $name:ident($($argument:ident: $type:ty),*) $([$holds:expr])?
            = $two:expr, $three:expr;
    )*) => {
        impl RawInstance {
            $($(#[$about])*
            #[inline]
            #[allow(unused_variables)] // some versions have no function
            pub fn $name(&$self $(, $argument: $type)*) -> c_int {
                let $c = $self.c;
                $(assert!($holds);)?
                // SAFETY: a live instance or NULL; what is passed is NULL, or lives as long as the
                // call, with as many elements as are said.
                unsafe {
                    match &$self.functions.own {
                        Fmi2($f) => $two,
                        Fmi3($f) => $three,
                    }
                }
            })*
        }
    };
}

/// Where an array that is written to begins, and NULL without one.
fn start<T>(values: Option<&mut [T]>) -> *mut T {
    values.map_or(ptr::null_mut(), <[T]>::as_mut_ptr)
}

// Modes and steps.
calls! { self, c, f:
    /// fmi2SetupExperiment, or fmi3EnterInitializationMode with the same arguments.
    fn begin(e: Experiment) = {
        let [has_tolerance, has_stop] = [e.has_tolerance, e.has_stop].map(c_int::from);
        (f.fmi2SetupExperiment)(c, has_tolerance, e.tolerance, e.start, has_stop, e.stop)
    }, (f.fmi3EnterInitializationMode)(
        c, e.has_tolerance, e.tolerance, e.start, e.has_stop, e.stop
    );
    /// In FMI 3.0 with the experiment, which FMI 2.0 is told by fmi2SetupExperiment.
    fn enter_initialization_mode(experiment: Experiment)
        = (f.fmi2EnterInitializationMode)(c), self.begin(experiment);
    /// From Initialization Mode to where steps or events are.
    fn exit_initialization_mode()
        = (f.fmi2ExitInitializationMode)(c), (f.fmi3ExitInitializationMode)(c);
    /// The end of a run.
    fn terminate() = (f.fmi2Terminate)(c), (f.fmi3Terminate)(c);
    /// Back to where it was when it was made.
    fn reset() = (f.fmi2Reset)(c), (f.fmi3Reset)(c);
    /// A step; how it ended is told by FMI 3.0 only.
    fn do_step(t: f64, h: f64, no_set_prior: c_int, end: &mut StepEnd)
        = (f.fmi2DoStep)(c, t, h, no_set_prior), {
            let StepEnd { event_needed, terminates, early, time } = end;
            (f.fmi3DoStep)(c, t, h, no_set_prior != 0, event_needed, terminates, early, time)
        };
    /// Of FMI 2.0.
    fn cancel_step() = (f.fmi2CancelStep)(c), ABSENT;
    /// Time of the last communication point: fmi2GetRealStatus, or the independent variable.
    fn last_time(time: &mut f64) = (f.fmi2GetRealStatus)(c, 2, time), match self.functions.time {
        Some(vr) => (f.fmi3GetFloat64)(c, &vr, 1, time, 1),
        None => DISCARD,
    };
    /// Event Mode of Model Exchange, and of FMI 3.0.
    fn enter_event_mode() = (f.fmi2EnterEventMode)(c), (f.fmi3EnterEventMode)(c);
    /// Of FMI 3.0, in Event Mode.
    fn evaluate_discrete_states() = ABSENT, (f.fmi3EvaluateDiscreteStates)(c);
    /// Of FMI 3.0.
    fn enter_step_mode() = ABSENT, (f.fmi3EnterStepMode)(c);
    /// Of FMI 3.0.
    fn enter_configuration_mode() = ABSENT, (f.fmi3EnterConfigurationMode)(c);
    /// Of FMI 3.0.
    fn exit_configuration_mode() = ABSENT, (f.fmi3ExitConfigurationMode)(c);
}

// Values.
calls! { self, c, f:
    /// Real variables, one number for each of their elements.
    fn get_reals(vr: Array<u32>, values: Option<&mut [f64]>)
        [values.as_ref().is_none_or(|values| values.len() >= vr.len())]
        = (f.fmi2GetReal)(c, vr.pointer(), vr.len(), start(values)), {
            let n = values.as_ref().map_or(vr.len(), |values| values.len());
            (f.fmi3GetFloat64)(c, vr.pointer(), vr.len(), start(values), n)
        };
    /// Sets Real variables likewise.
    fn set_reals(vr: Array<u32>, values: Array<f64>) [values.len() >= vr.len()]
        = (f.fmi2SetReal)(c, vr.pointer(), vr.len(), values.pointer()),
        (f.fmi3SetFloat64)(c, vr.pointer(), vr.len(), values.pointer(), values.len());
    /// Numbers of variables of one type, `n` of them, each with the size of its C type. Without room
    /// it is given NULL.
    fn get_numbers(access: Access, vr: Array<u32>, values: Option<&mut [u64]>, n: usize)
        [values.as_ref().is_none_or(|room| room.len() >= n.max(vr.len()))]
        = f.get_numbers(access, c, vr.pointer(), vr.len(), start(values), n),
        f.get_numbers(access, c, vr.pointer(), vr.len(), start(values), n);
    /// Sets numbers likewise.
    fn set_numbers(access: Access, vr: Array<u32>, values: Array<u64>, n: usize)
        [values.len() >= n.max(vr.len())]
        = f.set_numbers(access, c, vr.pointer(), vr.len(), values.pointer(), n),
        f.set_numbers(access, c, vr.pointer(), vr.len(), values.pointer(), n);
    /// Derivatives of outputs, of these orders.
    fn get_output_derivatives(vr: &[u32], orders: &[c_int], values: &mut [f64])
        [orders.len() == vr.len() && values.len() >= vr.len()]
        = (f.fmi2GetRealOutputDerivatives)(
            c, vr.as_ptr(), vr.len(), orders.as_ptr(), values.as_mut_ptr()
        ), (f.fmi3GetOutputDerivatives)(
            c, vr.as_ptr(), vr.len(), orders.as_ptr(), values.as_mut_ptr(), values.len()
        );
    /// Sets derivatives of inputs, of these orders. Not in FMI 3.0, where nothing is called.
    fn set_input_derivatives(vr: &[u32], orders: &[c_int], values: &[f64])
        [[orders.len(), values.len()] == [vr.len(); 2]]
        = (f.fmi2SetRealInputDerivatives)(
            c, vr.as_ptr(), vr.len(), orders.as_ptr(), values.as_ptr()
        ), DISCARD;
    /// Directional derivatives of the unknowns `y` for a change of the knowns `u` by the seed.
    fn get_directional_derivative(y: &[u32], u: &[u32], seed: &[f64], result: &mut [f64])
        [seed.len() >= u.len() && result.len() >= y.len()]
        = (f.fmi2GetDirectionalDerivative)(
            c, y.as_ptr(), y.len(), u.as_ptr(), u.len(), seed.as_ptr(), result.as_mut_ptr()
        ), (f.fmi3GetDirectionalDerivative)(
            c, y.as_ptr(), y.len(), u.as_ptr(), u.len(),
            seed.as_ptr(), seed.len(), result.as_mut_ptr(), result.len()
        );
    /// Adjoint derivatives of FMI 3.0; of fewer seeds than there are elements of the unknowns, if
    /// that is tried.
    fn get_adjoint_derivative(y: &[u32], u: &[u32], seed: &[f64], result: &mut [f64])
        = ABSENT, (f.fmi3GetAdjointDerivative)(
            c, y.as_ptr(), y.len(), u.as_ptr(), u.len(),
            seed.as_ptr(), seed.len(), result.as_mut_ptr(), result.len()
        );
    /// Number of dependencies of a variable (FMI 3.0).
    fn count_dependencies(vr: u32, n: Option<&mut usize>)
        = ABSENT, (f.fmi3GetNumberOfVariableDependencies)(c, vr, room(n));
}

// Saved states.
calls! { self, c, f:
    /// Saves the state to a handle, which may be that of a saved state.
    fn get_state(state: Option<&mut StateHandle>)
        = (f.fmi2GetFMUstate)(c, room(state).cast()), (f.fmi3GetFMUState)(c, room(state).cast());
    /// Frees what a handle leads to.
    fn free_state(state: Option<&mut StateHandle>)
        = (f.fmi2FreeFMUstate)(c, room(state).cast()), (f.fmi3FreeFMUState)(c, room(state).cast());
    /// Back to a saved state.
    fn set_state(state: StateHandle)
        = (f.fmi2SetFMUstate)(c, state.0), (f.fmi3SetFMUState)(c, state.0);
    /// How many bytes a state takes.
    fn serialized_size(state: StateHandle, size: Option<&mut usize>)
        = (f.fmi2SerializedFMUstateSize)(c, state.0, room(size)),
        (f.fmi3SerializedFMUStateSize)(c, state.0, room(size));
    /// A state as bytes.
    fn serialize(state: StateHandle, bytes: &mut [u8])
        = (f.fmi2SerializeFMUstate)(c, state.0, bytes.as_mut_ptr(), bytes.len()),
        (f.fmi3SerializeFMUState)(c, state.0, bytes.as_mut_ptr(), bytes.len());
    /// A state of bytes.
    fn deserialize(bytes: Array<u8>, state: Option<&mut StateHandle>)
        = (f.fmi2DeSerializeFMUstate)(c, bytes.pointer(), bytes.len(), room(state).cast()),
        (f.fmi3DeserializeFMUState)(c, bytes.pointer(), bytes.len(), room(state).cast());
}

// Model Exchange.
calls! { self, c, f:
    /// From Event Mode to where states are integrated.
    fn enter_continuous_time_mode()
        = (f.fmi2EnterContinuousTimeMode)(c), (f.fmi3EnterContinuousTimeMode)(c);
    /// The time, s.
    fn set_time(t: f64) = (f.fmi2SetTime)(c, t), (f.fmi3SetTime)(c, t);
    /// Sets the states.
    fn set_continuous_states(x: Array<f64>)
        = (f.fmi2SetContinuousStates)(c, x.pointer(), x.len()),
        (f.fmi3SetContinuousStates)(c, x.pointer(), x.len());
    /// Numbers of one kind, or NULL in the place of room for `n` of them.
    fn get_continuous(which: ContinuousValues, values: Option<&mut [f64]>, n: usize)
        [values.as_ref().is_none_or(|room| room.len() >= n)]
        = match which {
            ContinuousValues::States => (f.fmi2GetContinuousStates)(c, start(values), n),
            ContinuousValues::Derivatives => (f.fmi2GetDerivatives)(c, start(values), n),
            ContinuousValues::Indicators => (f.fmi2GetEventIndicators)(c, start(values), n),
            ContinuousValues::Nominals => (f.fmi2GetNominalsOfContinuousStates)(c, start(values), n),
        }, match which {
            ContinuousValues::States => (f.fmi3GetContinuousStates)(c, start(values), n),
            ContinuousValues::Derivatives => (f.fmi3GetContinuousStateDerivatives)(c, start(values), n),
            ContinuousValues::Indicators => (f.fmi3GetEventIndicators)(c, start(values), n),
            ContinuousValues::Nominals => (f.fmi3GetNominalsOfContinuousStates)(c, start(values), n),
        };
    /// Whether an event must be handled, and whether the simulation ends.
    fn completed_integrator_step(told: &mut [bool; 2]) = {
        let mut flags: [c_int; 2] = [0; 2];
        let [event, ends] = flags.each_mut();
        let status = (f.fmi2CompletedIntegratorStep)(c, 1, event, ends);
        *told = flags.map(|flag| flag != 0);
        status
    }, {
        let [event, ends] = told;
        (f.fmi3CompletedIntegratorStep)(c, true, event, ends)
    };
}
