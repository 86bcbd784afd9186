//! The C types that `fmu-export` writes by hand have the size, alignment, layout and values of the
//! standard's headers, as bindgen reads them for `fmi-sys`.

use std::mem::{align_of, offset_of, size_of};

use fmi::fmi2::binding as standard;
use fmu_export::ffi as ours;

macro_rules! same_layout {
    ($($ours:ty = $standard:ty),* $(,)?) => {$(
        assert_eq!(
            (size_of::<$ours>(), align_of::<$ours>()),
            (size_of::<$standard>(), align_of::<$standard>()),
            "{}", stringify!($ours)
        );
    )*};
}

#[test]
fn types_have_the_size_and_alignment_of_the_headers() {
    same_layout! {
        ours::Component = standard::fmi2Component,
        ours::ComponentEnvironment = standard::fmi2ComponentEnvironment,
        ours::FmuState = standard::fmi2FMUstate,
        ours::ValueReference = standard::fmi2ValueReference,
        ours::Real = standard::fmi2Real,
        ours::Integer = standard::fmi2Integer,
        ours::Boolean = standard::fmi2Boolean,
        ours::Str = standard::fmi2String,
        ours::Byte = standard::fmi2Byte,
        ours::Status = standard::fmi2Status,
        std::ffi::c_int = standard::fmi2Type,
        std::ffi::c_int = standard::fmi2StatusKind,
        Option<ours::CallbackLogger> = standard::fmi2CallbackLogger,
        Option<ours::CallbackAllocateMemory> = standard::fmi2CallbackAllocateMemory,
        Option<ours::CallbackFreeMemory> = standard::fmi2CallbackFreeMemory,
        Option<ours::StepFinished> = standard::fmi2StepFinished,
        ours::CallbackFunctions = standard::fmi2CallbackFunctions,
    }
}

#[test]
fn the_callbacks_are_in_the_order_of_the_headers() {
    use ours::CallbackFunctions as Ours;
    use standard::fmi2CallbackFunctions as Standard;
    assert_eq!(offset_of!(Ours, logger), offset_of!(Standard, logger));
    assert_eq!(
        offset_of!(Ours, allocate_memory),
        offset_of!(Standard, allocateMemory)
    );
    assert_eq!(
        offset_of!(Ours, free_memory),
        offset_of!(Standard, freeMemory)
    );
    assert_eq!(
        offset_of!(Ours, step_finished),
        offset_of!(Standard, stepFinished)
    );
    assert_eq!(
        offset_of!(Ours, component_environment),
        offset_of!(Standard, componentEnvironment)
    );
}

#[test]
fn enumerations_have_the_values_of_the_headers() {
    use ours::Status;
    for (ours, standard) in [
        (Status::Ok, standard::fmi2Status_fmi2OK),
        (Status::Warning, standard::fmi2Status_fmi2Warning),
        (Status::Discard, standard::fmi2Status_fmi2Discard),
        (Status::Error, standard::fmi2Status_fmi2Error),
        (Status::Fatal, standard::fmi2Status_fmi2Fatal),
        (Status::Pending, standard::fmi2Status_fmi2Pending),
    ] {
        assert_eq!(i64::from(ours as i32), i64::from(standard), "{ours:?}");
    }
    for (ours, standard) in [
        (ours::CO_SIMULATION, standard::fmi2Type_fmi2CoSimulation),
        (
            ours::DO_STEP_STATUS,
            standard::fmi2StatusKind_fmi2DoStepStatus,
        ),
        (
            ours::PENDING_STATUS,
            standard::fmi2StatusKind_fmi2PendingStatus,
        ),
        (
            ours::LAST_SUCCESSFUL_TIME,
            standard::fmi2StatusKind_fmi2LastSuccessfulTime,
        ),
        (ours::TERMINATED, standard::fmi2StatusKind_fmi2Terminated),
    ] {
        assert_eq!(i64::from(ours), i64::from(standard));
    }
}
