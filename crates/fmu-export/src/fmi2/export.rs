//! The macro that gives the functions their C names.

/// Exports the C functions of FMI 2.0 for one model. Use it once, in the crate that becomes the shared library.
///
/// Beside the 34 functions of FMI it exports `fmi2ExportFiles`, through which a packer reads `modelDescription.xml`,
/// documentation, icon and resources from the built library.
#[macro_export]
macro_rules! export_fmu {
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
macro_rules! export_functions {
    ($model:ty; $($c_name:ident $function:ident($($argument:ident: $type:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C-unwind" fn $c_name(c: Component $(, $argument: $type)*) -> Status {
            // SAFETY: FMI asks of the importer what the called function asks for.
            unsafe { e::$function::<$model>(c $(, $argument)*) }
        }
    )*};
}
