//! The calls of a [`RawInstance`] in tables, for every user of `raw`: each row has the function of
//! FMI 2.0 and that of FMI 3.0, or the status that is returned for a version without it.

use std::ffi::c_int;
use std::ptr;

use fmi_description::Access;

use super::{
    Array, ContinuousValues, Experiment, RawInstance, StateHandle, StepEnd, result_pointer,
};
use crate::functions::VersionFunctions::{Fmi2, Fmi3};
use crate::status::{ABSENT, DISCARD};

/// Makes a method of each row: its arguments, what must hold of them, and the call in either
/// version. In a row `c` is the instance and `f` are its functions.
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
                let _call = $self.call();
                // SAFETY: a live instance or NULL; what is passed is NULL, or lives as long as the
                // call, with as many elements as are said.
                unsafe {
                    match &$self.version {
                        Fmi2($f) => $two,
                        Fmi3($f) => $three,
                    }
                }
            })*
        }
    };
}

/// A pointer to an array that the call fills, or NULL.
fn array_pointer<T>(values: Option<&mut [T]>) -> *mut T {
    values.map_or(ptr::null_mut(), <[T]>::as_mut_ptr)
}

// Modes and steps.
calls! { self, c, f:
    /// fmi2SetupExperiment, or fmi3EnterInitializationMode with the same arguments.
    fn begin(e: Experiment) = {
        self.slot.at(e.start, 0.0);
        let [has_tolerance, has_stop] = [e.has_tolerance, e.has_stop].map(c_int::from);
        (f.fmi2SetupExperiment)(c, has_tolerance, e.tolerance, e.start, has_stop, e.stop)
    }, {
        self.slot.at(e.start, 0.0);
        (f.fmi3EnterInitializationMode)(
            c, e.has_tolerance, e.tolerance, e.start, e.has_stop, e.stop
        )
    };
    /// From Instantiated to Initialization Mode. FMI 2.0 ignores the experiment, which
    /// fmi2SetupExperiment has passed.
    fn enter_initialization_mode(experiment: Experiment)
        = (f.fmi2EnterInitializationMode)(c), self.begin(experiment);
    /// From Initialization Mode to the first communication point or event.
    fn exit_initialization_mode()
        = (f.fmi2ExitInitializationMode)(c), (f.fmi3ExitInitializationMode)(c);
    /// Ends the run.
    fn terminate() = (f.fmi2Terminate)(c), (f.fmi3Terminate)(c);
    /// Back to Instantiated, with start values.
    fn reset() = (f.fmi2Reset)(c), (f.fmi3Reset)(c);
    /// A communication step. Only FMI 3.0 fills in how it ended.
    fn do_step(t: f64, h: f64, no_set_prior: c_int, end: &mut StepEnd)
        = {
            self.slot.at(t, h);
            (f.fmi2DoStep)(c, t, h, no_set_prior)
        }, {
            self.slot.at(t, h);
            let StepEnd { event_needed, terminates, early, time } = end;
            (f.fmi3DoStep)(c, t, h, no_set_prior != 0, event_needed, terminates, early, time)
        };
    /// FMI 2.0 only.
    fn cancel_step() = (f.fmi2CancelStep)(c), ABSENT;
    /// Time that was reached, s, by fmi2GetRealStatus or the independent variable.
    fn last_time(time: &mut f64) = (f.fmi2GetRealStatus)(c, 2, time), match self.functions.time {
        Some(vr) => (f.fmi3GetFloat64)(c, &vr, 1, time, 1),
        None => DISCARD,
    };
    /// Whether the FMU has asked to end the simulation, by fmi2GetBooleanStatus. FMI 2.0 only.
    fn is_terminated(ends: &mut c_int) = (f.fmi2GetBooleanStatus)(c, 3, ends), ABSENT;
    /// To Event Mode: of Model Exchange, and in FMI 3.0 of Co-Simulation too.
    fn enter_event_mode() = (f.fmi2EnterEventMode)(c), (f.fmi3EnterEventMode)(c);
    /// FMI 3.0 only, in Event Mode.
    fn evaluate_discrete_states() = ABSENT, (f.fmi3EvaluateDiscreteStates)(c);
    /// FMI 3.0 only.
    fn enter_step_mode() = ABSENT, (f.fmi3EnterStepMode)(c);
    /// FMI 3.0 only.
    fn enter_configuration_mode() = ABSENT, (f.fmi3EnterConfigurationMode)(c);
    /// FMI 3.0 only.
    fn exit_configuration_mode() = ABSENT, (f.fmi3ExitConfigurationMode)(c);
}

// Values.
calls! { self, c, f:
    /// Gets Real variables: one number for each of their elements.
    fn get_reals(vr: Array<u32>, values: Option<&mut [f64]>)
        [values.as_ref().is_none_or(|values| values.len() >= vr.len())]
        = (f.fmi2GetReal)(c, vr.pointer(), vr.len(), array_pointer(values)), {
            let n = values.as_ref().map_or(vr.len(), |values| values.len());
            (f.fmi3GetFloat64)(c, vr.pointer(), vr.len(), array_pointer(values), n)
        };
    /// Sets Real variables: one number for each of their elements.
    fn set_reals(vr: Array<u32>, values: Array<f64>) [values.len() >= vr.len()]
        = (f.fmi2SetReal)(c, vr.pointer(), vr.len(), values.pointer()),
        (f.fmi3SetFloat64)(c, vr.pointer(), vr.len(), values.pointer(), values.len());
    /// Gets `n` numbers of variables of one type, each in the size of its C type. The library is
    /// passed NULL if there are no `values` to write to.
    fn get_numbers(access: Access, vr: Array<u32>, values: Option<&mut [u64]>, n: usize)
        [values.as_ref().is_none_or(|room| room.len() >= n.max(vr.len()))]
        = f.get_numbers(access, c, vr.pointer(), vr.len(), array_pointer(values), n),
        f.get_numbers(access, c, vr.pointer(), vr.len(), array_pointer(values), n);
    /// Sets `n` numbers of variables of one type, each in the size of its C type.
    fn set_numbers(access: Access, vr: Array<u32>, values: Array<u64>, n: usize)
        [values.len() >= n.max(vr.len())]
        = f.set_numbers(access, c, vr.pointer(), vr.len(), values.pointer(), n),
        f.set_numbers(access, c, vr.pointer(), vr.len(), values.pointer(), n);
    /// Gets time derivatives of outputs, of these orders.
    fn get_output_derivatives(vr: &[u32], orders: &[c_int], values: &mut [f64])
        [orders.len() == vr.len() && values.len() >= vr.len()]
        = (f.fmi2GetRealOutputDerivatives)(
            c, vr.as_ptr(), vr.len(), orders.as_ptr(), values.as_mut_ptr()
        ), (f.fmi3GetOutputDerivatives)(
            c, vr.as_ptr(), vr.len(), orders.as_ptr(), values.as_mut_ptr(), values.len()
        );
    /// Sets time derivatives of inputs, of these orders. FMI 2.0 only.
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
    /// Adjoint derivatives. FMI 3.0 only. A `seed` that is too short is passed as it is.
    fn get_adjoint_derivative(y: &[u32], u: &[u32], seed: &[f64], result: &mut [f64])
        = ABSENT, (f.fmi3GetAdjointDerivative)(
            c, y.as_ptr(), y.len(), u.as_ptr(), u.len(),
            seed.as_ptr(), seed.len(), result.as_mut_ptr(), result.len()
        );
    /// Gets the number of dependencies of a variable. FMI 3.0 only.
    fn count_dependencies(vr: u32, n: Option<&mut usize>)
        = ABSENT, (f.fmi3GetNumberOfVariableDependencies)(c, vr, result_pointer(n));
}

// Clocks, of FMI 3.0 only.
calls! { self, c, f:
    /// Gets whether a clock is active.
    fn get_clock(vr: u32, active: &mut bool) = ABSENT, (f.fmi3GetClock)(c, &vr, 1, active);
    /// Activates or deactivates a clock.
    fn set_clock(vr: u32, active: bool) = ABSENT, (f.fmi3SetClock)(c, &vr, 1, &active);
    /// Computes what belongs to a clock, at `t`, s. Scheduled Execution only.
    fn activate_model_partition(vr: u32, t: f64)
        = ABSENT, (f.fmi3ActivateModelPartition)(c, vr, t);
    /// Gets the interval of a clock, s, and its `fmi3IntervalQualifier`.
    fn get_interval(vr: u32, interval: &mut f64, qualifier: Option<&mut c_int>)
        = ABSENT, (f.fmi3GetIntervalDecimal)(c, &vr, 1, interval, result_pointer(qualifier));
    /// Sets the interval of a clock, s.
    fn set_interval(vr: u32, interval: f64)
        = ABSENT, (f.fmi3SetIntervalDecimal)(c, &vr, 1, &interval);
    /// Gets the delay of the first tick of a clock, s.
    fn get_shift(vr: u32, shift: &mut f64) = ABSENT, (f.fmi3GetShiftDecimal)(c, &vr, 1, shift);
    /// Sets the delay of the first tick of a clock, as counter and resolution.
    fn set_shift(vr: u32, counter: u64, resolution: u64)
        = ABSENT, (f.fmi3SetShiftFraction)(c, &vr, 1, &counter, &resolution);
}

// Saved states.
calls! { self, c, f:
    /// Saves the state. A handle that is not NULL is reused.
    fn get_state(state: Option<&mut StateHandle>)
        = (f.fmi2GetFMUstate)(c, result_pointer(state).cast()), (f.fmi3GetFMUState)(c, result_pointer(state).cast());
    /// Frees a saved state.
    fn free_state(state: Option<&mut StateHandle>)
        = (f.fmi2FreeFMUstate)(c, result_pointer(state).cast()), (f.fmi3FreeFMUState)(c, result_pointer(state).cast());
    /// Restores a saved state.
    fn set_state(state: StateHandle)
        = (f.fmi2SetFMUstate)(c, state.0), (f.fmi3SetFMUState)(c, state.0);
    /// Gets the number of bytes of a serialized state.
    fn serialized_size(state: StateHandle, size: Option<&mut usize>)
        = (f.fmi2SerializedFMUstateSize)(c, state.0, result_pointer(size)),
        (f.fmi3SerializedFMUStateSize)(c, state.0, result_pointer(size));
    /// Writes a saved state as bytes.
    fn serialize(state: StateHandle, bytes: &mut [u8])
        = (f.fmi2SerializeFMUstate)(c, state.0, bytes.as_mut_ptr(), bytes.len()),
        (f.fmi3SerializeFMUState)(c, state.0, bytes.as_mut_ptr(), bytes.len());
    /// Makes a saved state of bytes.
    fn deserialize(bytes: Array<u8>, state: Option<&mut StateHandle>)
        = (f.fmi2DeSerializeFMUstate)(c, bytes.pointer(), bytes.len(), result_pointer(state).cast()),
        (f.fmi3DeserializeFMUState)(c, bytes.pointer(), bytes.len(), result_pointer(state).cast());
}

// Model Exchange.
calls! { self, c, f:
    /// From Event Mode to Continuous-Time Mode.
    fn enter_continuous_time_mode()
        = (f.fmi2EnterContinuousTimeMode)(c), (f.fmi3EnterContinuousTimeMode)(c);
    /// Sets the time, s.
    fn set_time(t: f64) = {
        self.slot.at(t, 0.0);
        (f.fmi2SetTime)(c, t)
    }, {
        self.slot.at(t, 0.0);
        (f.fmi3SetTime)(c, t)
    };
    /// Sets the continuous states.
    fn set_continuous_states(x: Array<f64>)
        = (f.fmi2SetContinuousStates)(c, x.pointer(), x.len()),
        (f.fmi3SetContinuousStates)(c, x.pointer(), x.len());
    /// Gets one of the vectors, of length `n`. The library is passed NULL if there are no `values`.
    fn get_continuous(which: ContinuousValues, values: Option<&mut [f64]>, n: usize)
        [values.as_ref().is_none_or(|room| room.len() >= n)]
        = match which {
            ContinuousValues::States => (f.fmi2GetContinuousStates)(c, array_pointer(values), n),
            ContinuousValues::Derivatives => (f.fmi2GetDerivatives)(c, array_pointer(values), n),
            ContinuousValues::Indicators => (f.fmi2GetEventIndicators)(c, array_pointer(values), n),
            ContinuousValues::Nominals => (f.fmi2GetNominalsOfContinuousStates)(c, array_pointer(values), n),
        }, match which {
            ContinuousValues::States => (f.fmi3GetContinuousStates)(c, array_pointer(values), n),
            ContinuousValues::Derivatives => (f.fmi3GetContinuousStateDerivatives)(c, array_pointer(values), n),
            ContinuousValues::Indicators => (f.fmi3GetEventIndicators)(c, array_pointer(values), n),
            ContinuousValues::Nominals => (f.fmi3GetNominalsOfContinuousStates)(c, array_pointer(values), n),
        };
    /// Gets the number of continuous states or of event indicators. FMI 3.0 only.
    fn number_of(which: ContinuousValues, n: &mut usize) = ABSENT, match which {
        ContinuousValues::Indicators => (f.fmi3GetNumberOfEventIndicators)(c, n),
        _ => (f.fmi3GetNumberOfContinuousStates)(c, n),
    };
    /// Reports a completed step of the integrator. Returns in `told` whether Event Mode must be
    /// entered, and whether the FMU asks to end the simulation.
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
