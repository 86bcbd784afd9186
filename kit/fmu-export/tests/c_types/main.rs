//! The C types that `fmu-export` writes by hand have the size, alignment, layout and values that a
//! C compiler gives those of the standard's headers: `headers.txt`, which `headers.py` writes.

#![cfg(target_pointer_width = "64")]

use std::collections::BTreeMap;
use std::ffi::c_int;
use std::mem::{align_of, offset_of, size_of};

use fmu_export::{ffi as fmi2, ffi3 as fmi3};

type Numbers = Vec<usize>;

/// What a kind of line of the file says, by name.
fn headers(kind: &str) -> BTreeMap<String, Numbers> {
    let lines = include_str!("headers.txt").lines();
    let of_kind = lines.filter_map(|line| line.strip_prefix(kind)?.strip_prefix(' '));
    let split = of_kind.map(|line| {
        let mut words = line.split(' ');
        let name = words.next().expect("a name").to_string();
        (name, words.map(|n| n.parse().expect("a number")).collect())
    });
    split.collect()
}

/// Ours, in the same form.
fn ours<const N: usize>(
    names: impl IntoIterator<Item = (&'static str, [usize; N])>,
) -> BTreeMap<String, Numbers> {
    let named = names.into_iter();
    named
        .map(|(name, n)| (name.to_string(), n.to_vec()))
        .collect()
}

fn layout<T>() -> [usize; 2] {
    [size_of::<T>(), align_of::<T>()]
}

#[test]
fn types_have_the_size_and_alignment_of_the_headers() {
    let ours = ours([
        ("fmi2Component", layout::<fmi2::Component>()),
        (
            "fmi2ComponentEnvironment",
            layout::<fmi2::ComponentEnvironment>(),
        ),
        ("fmi2FMUstate", layout::<fmi2::FmuState>()),
        ("fmi2ValueReference", layout::<fmi2::ValueReference>()),
        ("fmi2Real", layout::<fmi2::Real>()),
        ("fmi2Integer", layout::<fmi2::Integer>()),
        ("fmi2Boolean", layout::<fmi2::Boolean>()),
        ("fmi2String", layout::<fmi2::Str>()),
        ("fmi2Byte", layout::<fmi2::Byte>()),
        ("fmi2Status", layout::<fmi2::Status>()),
        ("fmi2Type", layout::<c_int>()),
        ("fmi2StatusKind", layout::<c_int>()),
        (
            "fmi2CallbackLogger",
            layout::<Option<fmi2::CallbackLogger>>(),
        ),
        (
            "fmi2CallbackAllocateMemory",
            layout::<Option<fmi2::CallbackAllocateMemory>>(),
        ),
        (
            "fmi2CallbackFreeMemory",
            layout::<Option<fmi2::CallbackFreeMemory>>(),
        ),
        ("fmi2StepFinished", layout::<Option<fmi2::StepFinished>>()),
        ("fmi2CallbackFunctions", layout::<fmi2::CallbackFunctions>()),
        ("fmi2EventInfo", layout::<fmi2::EventInfo>()),
        ("fmi3Instance", layout::<fmi3::Instance>()),
        (
            "fmi3InstanceEnvironment",
            layout::<fmi3::InstanceEnvironment>(),
        ),
        ("fmi3FMUState", layout::<fmi3::FmuState>()),
        ("fmi3ValueReference", layout::<fmi3::ValueReference>()),
        ("fmi3Boolean", layout::<fmi3::Boolean>()),
        ("fmi3Clock", layout::<fmi3::Boolean>()),
        ("fmi3String", layout::<fmi3::Str>()),
        ("fmi3Byte", layout::<fmi3::Byte>()),
        ("fmi3Binary", layout::<fmi3::Binary>()),
        ("fmi3Status", layout::<fmi3::Status>()),
        ("fmi3DependencyKind", layout::<c_int>()),
        (
            "fmi3LogMessageCallback",
            layout::<Option<fmi3::LogMessage>>(),
        ),
        (
            "fmi3IntermediateUpdateCallback",
            layout::<Option<fmi3::IntermediateUpdate>>(),
        ),
        (
            "fmi3ClockUpdateCallback",
            layout::<Option<fmi3::ClockUpdate>>(),
        ),
        (
            "fmi3LockPreemptionCallback",
            layout::<Option<fmi3::Preemption>>(),
        ),
        (
            "fmi3UnlockPreemptionCallback",
            layout::<Option<fmi3::Preemption>>(),
        ),
    ]);
    assert_eq!(ours, headers("type"));
}

#[test]
fn fields_are_in_the_order_of_the_headers() {
    use fmi2::{CallbackFunctions, EventInfo};
    let callbacks = [
        ("logger", offset_of!(CallbackFunctions, logger)),
        (
            "allocateMemory",
            offset_of!(CallbackFunctions, allocate_memory),
        ),
        ("freeMemory", offset_of!(CallbackFunctions, free_memory)),
        ("stepFinished", offset_of!(CallbackFunctions, step_finished)),
        (
            "componentEnvironment",
            offset_of!(CallbackFunctions, component_environment),
        ),
    ];
    let event = [
        (
            "newDiscreteStatesNeeded",
            offset_of!(EventInfo, new_discrete_states_needed),
        ),
        (
            "terminateSimulation",
            offset_of!(EventInfo, terminate_simulation),
        ),
        (
            "nominalsOfContinuousStatesChanged",
            offset_of!(EventInfo, nominals_of_continuous_states_changed),
        ),
        (
            "valuesOfContinuousStatesChanged",
            offset_of!(EventInfo, values_of_continuous_states_changed),
        ),
        (
            "nextEventTimeDefined",
            offset_of!(EventInfo, next_event_time_defined),
        ),
        ("nextEventTime", offset_of!(EventInfo, next_event_time)),
    ];
    let of = |name: &str, fields: &[(&str, usize)]| {
        let fields = fields.iter();
        let named = fields.map(|(field, offset)| (format!("{name}.{field}"), vec![*offset]));
        named.collect::<Vec<_>>()
    };
    let mut ours = of("fmi2CallbackFunctions", &callbacks);
    ours.extend(of("fmi2EventInfo", &event));
    assert_eq!(BTreeMap::from_iter(ours), headers("field"));
}

#[test]
fn enumerations_have_the_values_of_the_headers() {
    let statuses = [
        ("fmi2OK", fmi2::Status::Ok as c_int),
        ("fmi2Warning", fmi2::Status::Warning as c_int),
        ("fmi2Discard", fmi2::Status::Discard as c_int),
        ("fmi2Error", fmi2::Status::Error as c_int),
        ("fmi2Fatal", fmi2::Status::Fatal as c_int),
        ("fmi2Pending", fmi2::Status::Pending as c_int),
        ("fmi2ModelExchange", fmi2::MODEL_EXCHANGE),
        ("fmi2CoSimulation", fmi2::CO_SIMULATION),
        ("fmi2DoStepStatus", fmi2::DO_STEP_STATUS),
        ("fmi2PendingStatus", fmi2::PENDING_STATUS),
        ("fmi2LastSuccessfulTime", fmi2::LAST_SUCCESSFUL_TIME),
        ("fmi2Terminated", fmi2::TERMINATED),
        ("fmi3OK", fmi3::Status::Ok as c_int),
        ("fmi3Warning", fmi3::Status::Warning as c_int),
        ("fmi3Discard", fmi3::Status::Discard as c_int),
        ("fmi3Error", fmi3::Status::Error as c_int),
        ("fmi3Fatal", fmi3::Status::Fatal as c_int),
        ("fmi3Dependent", fmi3::DEPENDENT),
    ];
    let number = |n: c_int| usize::try_from(n).expect("no negative value");
    let ours = ours(statuses.map(|(name, value)| (name, [number(value)])));
    assert_eq!(ours, headers("value"));
}
