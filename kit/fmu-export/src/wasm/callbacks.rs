//! The callbacks of a module for its host and for `component`: imports with the names of
//! FMI-LS-WASM, and C functions that call them, to be passed to fmi3InstantiateCoSimulation.

use crate::c_api::library::text;
use crate::fmi3::ffi::*;

mod imports {
    #[link(wasm_import_module = "fmi:fmi3/callbacks@3.0.0")]
    unsafe extern "C" {
        #[link_name = "log-message"]
        pub(super) fn log_message(
            instance: *const u8,
            instance_size: usize,
            status: i32,
            category: *const u8,
            category_size: usize,
            message: *const u8,
            message_size: usize,
        );
    }

    #[link(wasm_import_module = "fmi:fmi3/intermediate-update-callbacks@3.0.0")]
    unsafe extern "C" {
        #[link_name = "intermediate-update"]
        pub(super) fn intermediate_update(
            time: f64,
            set_requested: i32,
            get_allowed: i32,
            step_finished: i32,
            can_return_early: i32,
            answer: *mut super::Answer,
        );
    }
}

/// What the host answers to an intermediate update.
#[repr(C)]
struct Answer {
    early_return_requested: u8,
    early_return_time: f64,
}

/// Tells the host of the module.
pub(crate) fn tell(instance: &str, status: Status, category: &str, message: &str) {
    // SAFETY: the texts live during the call.
    unsafe {
        imports::log_message(
            instance.as_ptr(),
            instance.len(),
            status as i32,
            category.as_ptr(),
            category.len(),
            message.as_ptr(),
            message.len(),
        );
    }
}

/// Tells the host why the module is about to be lost: a panic is a trap here, after which none of
/// its instances is of use. Whether an instance logs does not matter then.
pub(crate) fn tell_panic(what: &str) {
    tell("", Status::Fatal, "logStatusError", what);
}

unsafe extern "C-unwind" fn log_message(
    environment: InstanceEnvironment,
    status: Status,
    category: Str,
    message: Str,
) {
    // SAFETY: the environment is what `fmu_log_message` asks for; the others are C strings.
    let [instance, category, message] =
        unsafe { [environment.cast_const().cast(), category, message].map(|s| text(s)) };
    let [instance, category, message] =
        [&instance, &category, &message].map(|text| text.as_deref().unwrap_or_default());
    tell(instance, status, category, message);
}

unsafe extern "C-unwind" fn intermediate_update(
    _environment: InstanceEnvironment,
    time: f64,
    set_requested: Boolean,
    get_allowed: Boolean,
    step_finished: Boolean,
    can_return_early: Boolean,
    early_return_requested: *mut Boolean,
    early_return_time: *mut f64,
) {
    let flags = [set_requested, get_allowed, step_finished, can_return_early].map(i32::from);
    let [set_requested, get_allowed, step_finished, can_return_early] = flags;
    let mut answer = Answer {
        early_return_requested: 0,
        early_return_time: 0.0,
    };
    // SAFETY: the caller gives places for the answers.
    unsafe {
        imports::intermediate_update(
            time,
            set_requested,
            get_allowed,
            step_finished,
            can_return_early,
            &raw mut answer,
        );
        early_return_requested.write(answer.early_return_requested);
        early_return_time.write(answer.early_return_time);
    }
}

/// The argument `logMessage` for instances whose messages go to the import `log-message`. The
/// argument `instanceEnvironment` is then NULL or the instance's name, a C string that lives as long
/// as the instance.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn fmu_log_message() -> LogMessage {
    log_message
}

/// The argument `intermediateUpdate` for instances whose updates go to the import
/// `intermediate-update`.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn fmu_intermediate_update() -> IntermediateUpdate {
    intermediate_update
}
