//! The macro that gives the functions their C names.

use crate::Model;

/// The model that a library exports. That it is one is asked for once, here, and not by each
/// function.
pub trait Exported {
    /// The model.
    type Model: Model;
}

/// Exports the C functions of FMI 2.0 and FMI 3.0 for one model. Use it once, in the crate that
/// becomes the shared library.
///
/// Beside the functions of FMI it exports `fmi2ExportFiles` and `fmi3ExportFiles`, through which a
/// packer reads `modelDescription.xml`, documentation, icon and resources from the built library.
#[macro_export]
macro_rules! export_fmu {
    ($model:ty) => {
        const _: () = {
            /// The model of this library.
            struct Library;

            impl $crate::entry::Exported for Library {
                type Model = $model;
            }

            $crate::export_fmi2!(Library);
            $crate::export_fmi3!(Library);
        };
    };
}

/// Part of [`export_fmu!`].
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi2 {
    ($exported:ty) => {
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
                unsafe {
                    e::instantiate::<$exported>(
                        &LIBRARY, name, kind, guid, resources, functions, logging_on,
                    )
                }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi2FreeInstance(c: Component) {
                // SAFETY: as above.
                unsafe { e::free_instance::<$exported>(c) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi2ExportFiles(
                context: *mut c_void,
                receive: Option<ReceiveFile>,
            ) -> c_int {
                // SAFETY: asked of the packer.
                unsafe { e::export_files::<$exported>(&LIBRARY, context, receive) }
            }

            $crate::export_fmi2_functions!($exported);
        };
    };
}

/// Part of [`export_fmu!`].
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi3 {
    ($exported:ty) => {
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
                    e::instantiate_co_simulation::<$exported>(
                        &LIBRARY,
                        name,
                        token,
                        resources,
                        logging_on,
                        event_mode_used,
                        early_return_allowed,
                        required,
                        n_required,
                        environment,
                        log_message,
                        update,
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
                unsafe {
                    e::refuse_instantiation::<$exported>(
                        "fmi3InstantiateModelExchange",
                        logging_on,
                        environment,
                        log_message,
                    )
                }
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
                unsafe {
                    e::refuse_instantiation::<$exported>(
                        "fmi3InstantiateScheduledExecution",
                        logging_on,
                        environment,
                        log_message,
                    )
                }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3FreeInstance(c: Instance) {
                // SAFETY: as above.
                unsafe { e::free_instance::<$exported>(c) }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3DoStep(
                c: Instance,
                t: f64,
                h: f64,
                _no_set_prior: Boolean,
                event: *mut Boolean,
                terminate: *mut Boolean,
                early_return: *mut Boolean,
                last_time: *mut f64,
            ) -> Status {
                // SAFETY: as above.
                unsafe {
                    e::do_step::<$exported>(c, t, h, event, terminate, early_return, last_time)
                }
            }

            #[unsafe(no_mangle)]
            unsafe extern "C-unwind" fn fmi3ExportFiles(
                context: *mut c_void,
                receive: Option<ReceiveFile>,
            ) -> c_int {
                // SAFETY: asked of the packer.
                unsafe { e::export_files::<$exported>(&LIBRARY, context, receive) }
            }

            $crate::export_fmi3_functions!($exported);
            $crate::export_fmi3_values!($exported);
            $crate::export_fmi3_absent!($exported);
        };
    };
}
