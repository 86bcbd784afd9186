//! The macro that gives the functions their C names.

/// Exports the C functions of FMI 2.0 and FMI 3.0 for one model. Use it once, in the crate that becomes the shared library.
///
/// Beside the functions of FMI it exports `fmi2ExportFiles` and `fmi3ExportFiles`, through which a packer reads `modelDescription.xml`,
/// documentation, icon and resources from the built library.
#[macro_export]
macro_rules! export_fmu {
    ($model:ty) => {
        $crate::export_fmi2!($model);
        $crate::export_fmi3!($model);
    };
}

/// Part of [`export_fmu!`].
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi2 {
    ($model:ty) => {
        const _: () = {
            use $crate::entry as e;
            use $crate::ffi::*;

            static LIBRARY: e::Library = e::Library::new(cfg!(test));

            #[unsafe(no_mangle)]
            extern "C-unwind" fn fmi2GetTypesPlatform() -> Str {
                c"default".as_ptr()
            }

            #[unsafe(no_mangle)]
            extern "C-unwind" fn fmi2GetVersion() -> Str {
                c"2.0".as_ptr()
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi2Instantiate(
                name: Str,
                kind: c_int,
                guid: Str,
                resources: Str,
                functions: *const CallbackFunctions,
                _visible: Boolean,
                logging_on: Boolean,
            ) -> Component {
                // SAFETY: FMI asks of the importer what the called function asks for.
                unsafe { e::instantiate::<$model>(&LIBRARY, name, kind, guid, resources, functions, logging_on) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi2FreeInstance(c: Component) {
                // SAFETY: as above.
                unsafe { e::free_instance::<$model>(c) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi2ExportFiles(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int {
                // SAFETY: asked of the packer.
                unsafe { e::export_files::<$model>(&LIBRARY, context, receive) }
            }

            $crate::export_functions! { $model;
                fmi2SetDebugLogging set_debug_logging(on: Boolean, n: usize, categories: *const Str);
                fmi2SetupExperiment setup_experiment(tolerance_defined: Boolean, tolerance: Real, start: Real, stop_defined: Boolean, stop: Real);
                fmi2EnterInitializationMode enter_initialization_mode();
                fmi2ExitInitializationMode exit_initialization_mode();
                fmi2Terminate terminate();
                fmi2Reset reset();
                fmi2GetReal get_real(vr: *const ValueReference, n: usize, value: *mut Real);
                fmi2GetInteger get_integer(vr: *const ValueReference, n: usize, value: *mut Integer);
                fmi2GetBoolean get_boolean(vr: *const ValueReference, n: usize, value: *mut Boolean);
                fmi2GetString get_string(vr: *const ValueReference, n: usize, value: *mut Str);
                fmi2SetReal set_real(vr: *const ValueReference, n: usize, value: *const Real);
                fmi2SetInteger set_integer(vr: *const ValueReference, n: usize, value: *const Integer);
                fmi2SetBoolean set_boolean(vr: *const ValueReference, n: usize, value: *const Boolean);
                fmi2SetString set_string(vr: *const ValueReference, n: usize, value: *const Str);
                fmi2GetFMUstate get_fmu_state(state: *mut FmuState);
                fmi2SetFMUstate set_fmu_state(state: FmuState);
                fmi2FreeFMUstate free_fmu_state(state: *mut FmuState);
                fmi2SerializedFMUstateSize serialized_fmu_state_size(state: FmuState, size: *mut usize);
                fmi2SerializeFMUstate serialize_fmu_state(state: FmuState, bytes: *mut Byte, size: usize);
                fmi2DeSerializeFMUstate deserialize_fmu_state(bytes: *const Byte, size: usize, state: *mut FmuState);
                fmi2GetDirectionalDerivative get_directional_derivative(
                    unknown: *const ValueReference, n_unknown: usize, known: *const ValueReference, n_known: usize,
                    seed: *const Real, result: *mut Real
                );
                fmi2SetRealInputDerivatives set_real_input_derivatives(vr: *const ValueReference, n: usize, order: *const Integer, value: *const Real);
                fmi2GetRealOutputDerivatives get_real_output_derivatives(vr: *const ValueReference, n: usize, order: *const Integer, value: *mut Real);
                fmi2CancelStep cancel_step();
                fmi2GetStatus get_status(kind: c_int, value: *mut Status);
                fmi2GetRealStatus get_real_status(kind: c_int, value: *mut Real);
                fmi2GetIntegerStatus get_integer_status(kind: c_int, value: *mut Integer);
                fmi2GetBooleanStatus get_boolean_status(kind: c_int, value: *mut Boolean);
                fmi2GetStringStatus get_string_status(kind: c_int, value: *mut Str);
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi2DoStep(c: Component, t: Real, h: Real, _no_set_prior: Boolean) -> Status {
                // SAFETY: as above.
                unsafe { e::do_step::<$model>(c, t, h) }
            }
        };
    };
}

/// Part of [`export_fmu!`].
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3 {
    ($model:ty) => {
        const _: () = {
            use $crate::entry3 as e;
            use $crate::ffi3::*;

            static LIBRARY: e::Library = e::Library::new(cfg!(test));

            #[unsafe(no_mangle)]
            extern "C-unwind" fn fmi3GetVersion() -> Str {
                c"3.0".as_ptr()
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3InstantiateCoSimulation(
                name: Str,
                token: Str,
                resources: Str,
                _visible: Boolean,
                logging_on: Boolean,
                event_mode_used: Boolean,
                early_return_allowed: Boolean,
                required: *const ValueReference,
                n_required: usize,
                environment: InstanceEnvironment,
                log_message: Option<LogMessage>,
                update: Option<IntermediateUpdate>,
            ) -> Instance {
                // SAFETY: FMI asks of the importer what the called function asks for.
                unsafe {
                    e::instantiate_co_simulation::<$model>(
                        &LIBRARY, name, token, resources, logging_on, event_mode_used, early_return_allowed, required, n_required,
                        environment, log_message, update,
                    )
                }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3InstantiateModelExchange(
                _name: Str,
                _token: Str,
                _resources: Str,
                _visible: Boolean,
                logging_on: Boolean,
                environment: InstanceEnvironment,
                log_message: Option<LogMessage>,
            ) -> Instance {
                // SAFETY: as above.
                unsafe { e::refuse_instantiation::<$model>("fmi3InstantiateModelExchange", logging_on, environment, log_message) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3InstantiateScheduledExecution(
                _name: Str,
                _token: Str,
                _resources: Str,
                _visible: Boolean,
                logging_on: Boolean,
                environment: InstanceEnvironment,
                log_message: Option<LogMessage>,
                _clock_update: Option<ClockUpdate>,
                _lock: Option<Preemption>,
                _unlock: Option<Preemption>,
            ) -> Instance {
                // SAFETY: as above.
                unsafe { e::refuse_instantiation::<$model>("fmi3InstantiateScheduledExecution", logging_on, environment, log_message) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3FreeInstance(c: Instance) {
                // SAFETY: as above.
                unsafe { e::free_instance::<$model>(c) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3DoStep(
                c: Instance, t: f64, h: f64, _no_set_prior: Boolean, event: *mut Boolean, terminate: *mut Boolean,
                early_return: *mut Boolean, last_time: *mut f64,
            ) -> Status {
                // SAFETY: as above.
                unsafe { e::do_step::<$model>(c, t, h, event, terminate, early_return, last_time) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3ExportFiles(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int {
                // SAFETY: asked of the packer.
                unsafe { e::export_files::<$model>(&LIBRARY, context, receive) }
            }

            $crate::export_functions! { $model;
                fmi3SetDebugLogging set_debug_logging(on: Boolean, n: usize, categories: *const Str);
                fmi3EnterInitializationMode enter_initialization_mode(tolerance_defined: Boolean, tolerance: f64, start: f64, stop_defined: Boolean, stop: f64);
                fmi3ExitInitializationMode exit_initialization_mode();
                fmi3EnterEventMode enter_event_mode();
                fmi3EnterStepMode enter_step_mode();
                fmi3EvaluateDiscreteStates evaluate_discrete_states();
                fmi3UpdateDiscreteStates update_discrete_states(
                    need_update: *mut Boolean, terminate: *mut Boolean, nominals_changed: *mut Boolean, values_changed: *mut Boolean,
                    next_event_time_defined: *mut Boolean, next_event_time: *mut f64
                );
                fmi3Terminate terminate();
                fmi3Reset reset();
                fmi3GetFloat32 get_float32(vr: *const ValueReference, n: usize, values: *mut f32, n_values: usize);
                fmi3GetFloat64 get_float64(vr: *const ValueReference, n: usize, values: *mut f64, n_values: usize);
                fmi3GetInt8 get_int8(vr: *const ValueReference, n: usize, values: *mut i8, n_values: usize);
                fmi3GetUInt8 get_uint8(vr: *const ValueReference, n: usize, values: *mut u8, n_values: usize);
                fmi3GetInt16 get_int16(vr: *const ValueReference, n: usize, values: *mut i16, n_values: usize);
                fmi3GetUInt16 get_uint16(vr: *const ValueReference, n: usize, values: *mut u16, n_values: usize);
                fmi3GetInt32 get_int32(vr: *const ValueReference, n: usize, values: *mut i32, n_values: usize);
                fmi3GetUInt32 get_uint32(vr: *const ValueReference, n: usize, values: *mut u32, n_values: usize);
                fmi3GetInt64 get_int64(vr: *const ValueReference, n: usize, values: *mut i64, n_values: usize);
                fmi3GetUInt64 get_uint64(vr: *const ValueReference, n: usize, values: *mut u64, n_values: usize);
                fmi3GetBoolean get_boolean(vr: *const ValueReference, n: usize, values: *mut Boolean, n_values: usize);
                fmi3GetString get_string(vr: *const ValueReference, n: usize, values: *mut Str, n_values: usize);
                fmi3GetBinary get_binary(vr: *const ValueReference, n: usize, sizes: *mut usize, values: *mut Binary, n_values: usize);
                fmi3GetClock get_clock(vr: *const ValueReference, n: usize, values: *mut Boolean);
                fmi3SetFloat32 set_float32(vr: *const ValueReference, n: usize, values: *const f32, n_values: usize);
                fmi3SetFloat64 set_float64(vr: *const ValueReference, n: usize, values: *const f64, n_values: usize);
                fmi3SetInt8 set_int8(vr: *const ValueReference, n: usize, values: *const i8, n_values: usize);
                fmi3SetUInt8 set_uint8(vr: *const ValueReference, n: usize, values: *const u8, n_values: usize);
                fmi3SetInt16 set_int16(vr: *const ValueReference, n: usize, values: *const i16, n_values: usize);
                fmi3SetUInt16 set_uint16(vr: *const ValueReference, n: usize, values: *const u16, n_values: usize);
                fmi3SetInt32 set_int32(vr: *const ValueReference, n: usize, values: *const i32, n_values: usize);
                fmi3SetUInt32 set_uint32(vr: *const ValueReference, n: usize, values: *const u32, n_values: usize);
                fmi3SetInt64 set_int64(vr: *const ValueReference, n: usize, values: *const i64, n_values: usize);
                fmi3SetUInt64 set_uint64(vr: *const ValueReference, n: usize, values: *const u64, n_values: usize);
                fmi3SetBoolean set_boolean(vr: *const ValueReference, n: usize, values: *const Boolean, n_values: usize);
                fmi3SetString set_string(vr: *const ValueReference, n: usize, values: *const Str, n_values: usize);
                fmi3SetBinary set_binary(vr: *const ValueReference, n: usize, sizes: *const usize, values: *const Binary, n_values: usize);
                fmi3SetClock set_clock(vr: *const ValueReference, n: usize, values: *const Boolean);
                fmi3GetNumberOfVariableDependencies get_number_of_variable_dependencies(dependent: ValueReference, n: *mut usize);
                fmi3GetVariableDependencies get_variable_dependencies(
                    dependent: ValueReference, elements: *mut usize, independents: *mut ValueReference, independent_elements: *mut usize,
                    kinds: *mut c_int, n: usize
                );
                fmi3GetFMUState get_fmu_state(state: *mut FmuState);
                fmi3SetFMUState set_fmu_state(state: FmuState);
                fmi3FreeFMUState free_fmu_state(state: *mut FmuState);
                fmi3SerializedFMUStateSize serialized_fmu_state_size(state: FmuState, size: *mut usize);
                fmi3SerializeFMUState serialize_fmu_state(state: FmuState, bytes: *mut Byte, size: usize);
                fmi3DeserializeFMUState deserialize_fmu_state(bytes: *const Byte, size: usize, state: *mut FmuState);
                fmi3GetDirectionalDerivative get_directional_derivative(
                    unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize,
                    seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
                );
                fmi3GetAdjointDerivative get_adjoint_derivative(
                    unknowns: *const ValueReference, n_unknowns: usize, knowns: *const ValueReference, n_knowns: usize,
                    seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
                );
                fmi3GetOutputDerivatives get_output_derivatives(vr: *const ValueReference, n: usize, orders: *const i32, values: *mut f64, n_values: usize);
                fmi3EnterConfigurationMode enter_configuration_mode();
                fmi3ExitConfigurationMode exit_configuration_mode();
                fmi3GetIntervalDecimal get_interval_decimal(vr: *const ValueReference, n: usize, intervals: *mut f64, qualifiers: *mut c_int);
                fmi3GetIntervalFraction get_interval_fraction(vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int);
                fmi3GetShiftDecimal get_shift_decimal(vr: *const ValueReference, n: usize, shifts: *mut f64);
                fmi3GetShiftFraction get_shift_fraction(vr: *const ValueReference, n: usize, counters: *mut u64, resolutions: *mut u64);
                fmi3SetIntervalDecimal set_interval_decimal(vr: *const ValueReference, n: usize, intervals: *const f64);
                fmi3SetIntervalFraction set_interval_fraction(vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64);
                fmi3SetShiftDecimal set_shift_decimal(vr: *const ValueReference, n: usize, shifts: *const f64);
                fmi3SetShiftFraction set_shift_fraction(vr: *const ValueReference, n: usize, counters: *const u64, resolutions: *const u64);
                fmi3EnterContinuousTimeMode enter_continuous_time_mode();
                fmi3CompletedIntegratorStep completed_integrator_step(no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean);
                fmi3SetTime set_time(time: f64);
                fmi3SetContinuousStates set_continuous_states(states: *const f64, n: usize);
                fmi3GetContinuousStateDerivatives get_continuous_state_derivatives(derivatives: *mut f64, n: usize);
                fmi3GetEventIndicators get_event_indicators(indicators: *mut f64, n: usize);
                fmi3GetContinuousStates get_continuous_states(states: *mut f64, n: usize);
                fmi3GetNominalsOfContinuousStates get_nominals_of_continuous_states(nominals: *mut f64, n: usize);
                fmi3GetNumberOfEventIndicators get_number_of_event_indicators(n: *mut usize);
                fmi3GetNumberOfContinuousStates get_number_of_continuous_states(n: *mut usize);
                fmi3ActivateModelPartition activate_model_partition(clock: ValueReference, time: f64);
            }
        };
    };
}

/// Part of [`export_fmu!`].
#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    ($model:ty; $($c_name:ident $function:ident($($argument:ident: $type:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C-unwind" fn $c_name(c: *mut c_void $(, $argument: $type)*) -> Status {
            // SAFETY: FMI asks of the importer what the called function asks for.
            unsafe { e::$function::<$model>(c $(, $argument)*) }
        }
    )*};
}
