//! [`export_fmu!`](crate::export_fmu) for authors: exports a model's functions under their C names.

use crate::Model;

/// The model that a library exports. The bound `Model` stands once, here, and not on each function,
/// so that the compiler reports a missing `impl Model` once.
pub trait Exported {
    /// The model.
    type Model: Model;
}

/// Exports the C functions of FMI 2.0 and FMI 3.0 for one model. Use it once, in the crate that
/// becomes the shared library.
///
/// It also exports `fmi2ExportFiles` and `fmi3ExportFiles`, through which a packer reads
/// `modelDescription.xml`, documentation, icon and resources from the built library.
#[macro_export]
macro_rules! export_fmu {
    ($model:ty) => {
        const _: () = {
            /// Names the model of this library.
            struct __Exported;

            impl $crate::entry::Exported for __Exported {
                type Model = $model;
            }

            #[cfg(not(target_arch = "wasm32"))]
            $crate::export_fmi2!(__Exported);
            $crate::export_fmi3!(__Exported);
            #[cfg(target_arch = "wasm32")]
            $crate::export_component!(__Exported);
        };
    };
}

/// Part of [`export_fmu!`]: exports functions by their C names; each calls a function of the module
/// `e` for the exported model.
#[doc(hidden)]
#[macro_export]
macro_rules! export_entries {
    ($exported:ty; $($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)? = $function:ident($($given:expr),*);)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C-unwind" fn $name($($argument: $type),*) $(-> $result)? {
            // SAFETY: the importer (or packer) must keep the contract of the called function.
            unsafe { e::$function::<$exported>($($given),*) }
        }
    )*};
}

/// Part of [`export_fmu!`].
#[doc(hidden)]
#[macro_export]
macro_rules! export_fmi2 {
    ($exported:ty) => {
        const _: () = {
            use $crate::entry as e;
            use $crate::ffi::*;

            static LIBRARY: e::Library = e::Library::new(cfg!(test), option_env!("FMU_SIZES"));

            #[unsafe(no_mangle)]
            extern "C-unwind" fn fmi2GetTypesPlatform() -> Str {
                c"default".as_ptr()
            }

            #[unsafe(no_mangle)]
            extern "C-unwind" fn fmi2GetVersion() -> Str {
                c"2.0".as_ptr()
            }

            $crate::export_entries! { $exported;
                fmi2Instantiate(
                    name: Str, kind: c_int, guid: Str, resources: Str, functions: *const CallbackFunctions,
                    _visible: Boolean, logging_on: Boolean
                ) -> Component = instantiate(&LIBRARY, name, kind, guid, resources, functions, logging_on);
                fmi2FreeInstance(c: Component) = free_instance(c);
                fmi2ExportFiles(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int
                    = export_files(&LIBRARY, context, receive);
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

            #[cfg(not(target_arch = "wasm32"))]
            static LIBRARY: e::Library = e::Library::new(cfg!(test), option_env!("FMU_SIZES"));
            #[cfg(target_arch = "wasm32")]
            use $crate::component::LIBRARY;

            #[unsafe(no_mangle)]
            extern "C-unwind" fn fmi3GetVersion() -> Str {
                c"3.0".as_ptr()
            }

            $crate::export_entries! { $exported;
                fmi3InstantiateCoSimulation(
                    name: Str, token: Str, resources: Str, _visible: Boolean, logging_on: Boolean,
                    event_mode_used: Boolean, early_return_allowed: Boolean,
                    required: *const ValueReference, n_required: usize,
                    environment: InstanceEnvironment, log_message: Option<LogMessage>, update: Option<IntermediateUpdate>
                ) -> Instance = instantiate(
                    &LIBRARY, name, token, resources, logging_on, environment, log_message,
                    e::Interface::CoSimulation(e::CoSimulation { event_mode_used, early_return_allowed, required, n_required, update })
                );
                fmi3InstantiateModelExchange(
                    name: Str, token: Str, resources: Str, _visible: Boolean, logging_on: Boolean,
                    environment: InstanceEnvironment, log_message: Option<LogMessage>
                ) -> Instance = instantiate(
                    &LIBRARY, name, token, resources, logging_on, environment, log_message, e::Interface::ModelExchange
                );
                fmi3InstantiateScheduledExecution(
                    name: Str, token: Str, resources: Str, _visible: Boolean, logging_on: Boolean,
                    environment: InstanceEnvironment, log_message: Option<LogMessage>,
                    clock_update: Option<ClockUpdate>, lock: Option<Preemption>, unlock: Option<Preemption>
                ) -> Instance = instantiate(
                    &LIBRARY, name, token, resources, logging_on, environment, log_message,
                    e::Interface::ScheduledExecution(clock_update, lock, unlock)
                );
                fmi3ActivateModelPartition(c: Instance, clock: ValueReference, time: f64) -> Status
                    = fmi3ActivateModelPartition(c, clock, time);
                fmi3FreeInstance(c: Instance) = free_instance(c);
                fmi3DoStep(
                    c: Instance, t: f64, h: f64, _no_set_prior: Boolean, event: *mut Boolean, terminate: *mut Boolean,
                    early_return: *mut Boolean, last_time: *mut f64
                ) -> Status = do_step(c, t, h, event, terminate, early_return, last_time);
            }

            #[cfg(not(target_arch = "wasm32"))]
            $crate::export_entries! { $exported;
                fmi3ExportFiles(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int
                    = export_files(&LIBRARY, context, receive);
            }

            $crate::export_fmi3_functions!($exported);
            $crate::export_fmi3_values!($exported);
            $crate::export_fmi3_numbers!($exported);
            $crate::export_fmi3_clocks!($exported);
        };
    };
}
