//! Call order, against sections 2.3 and 4.2.1 of FMI 3.0.2, written out once more.

use crate::client3::*;
use crate::probe::vr;
use std::ptr;

type Attempt = fn(&Fmu3) -> Status;

/// One correct call of a function in each of its states.
#[rustfmt::skip]
const CALLS: &[(&str, &str, Attempt)] = &[
    // name, states it is allowed in: I(nstantiated) N (initialization) E(vent) S(tep) A (step after
    // a set) T(erminated)
    ("fmi3SetDebugLogging",         "INESAT", |f| unsafe { fmi3SetDebugLogging(f.c, 1, 0, ptr::null()) }),
    ("fmi3EnterInitializationMode", "I",      |f| f.enter_initialization(0.0, None)),
    ("fmi3ExitInitializationMode",  "N",      |f| f.call(fmi3ExitInitializationMode)),
    ("fmi3EnterEventMode",          "SA",     |f| f.call(fmi3EnterEventMode)),
    ("fmi3EnterStepMode",           "E",      |f| f.call(fmi3EnterStepMode)),
    ("fmi3EvaluateDiscreteStates",  "E",      |f| f.call(fmi3EvaluateDiscreteStates)),
    ("fmi3UpdateDiscreteStates",    "E",      |f| f.update().0),
    ("fmi3DoStep",                  "SA",     |f| f.step(0.0, 1.0).0),
    ("fmi3Terminate",               "ESA",    |f| f.call(fmi3Terminate)),
    ("fmi3Reset",                   "INESAT", |f| f.call(fmi3Reset)),
    ("fmi3GetFloat64",              "NEST",   |f| f.try_get::<1>(&[vr::Y]).0),
    ("fmi3GetFloat64",              "INEST",  |f| f.try_get::<2>(&[vr::U[0]]).0),
    ("fmi3GetInt32",                "INEST",  |f| f.get_int32(vr::LEVEL).0),
    ("fmi3GetInt64",                "INEST",  |f| f.get_int64(vr::LAW).0),
    ("fmi3GetBoolean",              "NEST",   |f| f.get_boolean(vr::ON).0),
    ("fmi3GetString",               "INEST",  |f| f.get_string(vr::FILE).0),
    ("fmi3SetFloat64",              "INESA",  |f| f.set(&[vr::U[0]], &[1.0, 2.0])),
    ("fmi3SetInt32",                "INESA",  |f| f.set_int32(vr::FAULT, 0)),
    ("fmi3SetInt64",                "IN",     |f| f.set_int64(vr::LAW, 2)),
    ("fmi3SetBoolean",              "INESA",  |f| f.set_boolean(vr::SWITCH, 1)),
    ("fmi3SetString",               "IN",     |f| f.set_string(vr::FILE, c"1")),
    // Of variables of types that this FMU has not: a call for none is right.
    ("fmi3GetFloat32",              "INEST",  |f| unsafe { fmi3GetFloat32(f.c, ptr::null(), 0, ptr::null_mut(), 0) }),
    ("fmi3GetInt8",                 "INEST",  |f| unsafe { fmi3GetInt8(f.c, ptr::null(), 0, ptr::null_mut(), 0) }),
    ("fmi3GetUInt8",                "INEST",  |f| unsafe { fmi3GetUInt8(f.c, ptr::null(), 0, ptr::null_mut(), 0) }),
    ("fmi3GetInt16",                "INEST",  |f| unsafe { fmi3GetInt16(f.c, ptr::null(), 0, ptr::null_mut(), 0) }),
    ("fmi3GetUInt16",               "INEST",  |f| unsafe { fmi3GetUInt16(f.c, ptr::null(), 0, ptr::null_mut(), 0) }),
    ("fmi3GetUInt32",               "INEST",  |f| unsafe { fmi3GetUInt32(f.c, ptr::null(), 0, ptr::null_mut(), 0) }),
    ("fmi3GetUInt64",               "INEST",  |f| unsafe { fmi3GetUInt64(f.c, ptr::null(), 0, ptr::null_mut(), 0) }),
    ("fmi3GetBinary",               "INEST",  |f| unsafe { fmi3GetBinary(f.c, ptr::null(), 0, ptr::null_mut(), ptr::null_mut(), 0) }),
    ("fmi3GetClock",                "E",      |f| unsafe { fmi3GetClock(f.c, ptr::null(), 0, ptr::null_mut()) }),
    ("fmi3SetFloat32",              "INESA",  |f| unsafe { fmi3SetFloat32(f.c, ptr::null(), 0, ptr::null(), 0) }),
    ("fmi3SetInt8",                 "INESA",  |f| unsafe { fmi3SetInt8(f.c, ptr::null(), 0, ptr::null(), 0) }),
    ("fmi3SetUInt8",                "INESA",  |f| unsafe { fmi3SetUInt8(f.c, ptr::null(), 0, ptr::null(), 0) }),
    ("fmi3SetInt16",                "INESA",  |f| unsafe { fmi3SetInt16(f.c, ptr::null(), 0, ptr::null(), 0) }),
    ("fmi3SetUInt16",               "INESA",  |f| unsafe { fmi3SetUInt16(f.c, ptr::null(), 0, ptr::null(), 0) }),
    ("fmi3SetUInt32",               "INESA",  |f| unsafe { fmi3SetUInt32(f.c, ptr::null(), 0, ptr::null(), 0) }),
    ("fmi3SetUInt64",               "INESA",  |f| unsafe { fmi3SetUInt64(f.c, ptr::null(), 0, ptr::null(), 0) }),
    ("fmi3SetBinary",               "INESA",  |f| unsafe { fmi3SetBinary(f.c, ptr::null(), 0, ptr::null(), ptr::null(), 0) }),
    ("fmi3SetClock",                "E",      |f| unsafe { fmi3SetClock(f.c, ptr::null(), 0, ptr::null()) }),
    ("fmi3GetIntervalDecimal",      "NE",     |f| unsafe { fmi3GetIntervalDecimal(f.c, ptr::null(), 0, ptr::null_mut(), ptr::null_mut()) }),
    ("fmi3GetIntervalFraction",     "NE",     |f| unsafe { fmi3GetIntervalFraction(f.c, ptr::null(), 0, ptr::null_mut(), ptr::null_mut(), ptr::null_mut()) }),
    ("fmi3GetShiftDecimal",         "N",      |f| unsafe { fmi3GetShiftDecimal(f.c, ptr::null(), 0, ptr::null_mut()) }),
    ("fmi3GetShiftFraction",        "N",      |f| unsafe { fmi3GetShiftFraction(f.c, ptr::null(), 0, ptr::null_mut(), ptr::null_mut()) }),
    ("fmi3SetIntervalDecimal",      "NE",     |f| unsafe { fmi3SetIntervalDecimal(f.c, ptr::null(), 0, ptr::null()) }),
    ("fmi3SetIntervalFraction",     "NE",     |f| unsafe { fmi3SetIntervalFraction(f.c, ptr::null(), 0, ptr::null(), ptr::null()) }),
    ("fmi3SetShiftDecimal",         "NE",     |f| unsafe { fmi3SetShiftDecimal(f.c, ptr::null(), 0, ptr::null()) }),
    ("fmi3SetShiftFraction",        "NE",     |f| unsafe { fmi3SetShiftFraction(f.c, ptr::null(), 0, ptr::null(), ptr::null()) }),
    ("fmi3GetNumberOfVariableDependencies", "INESAT", |f| unsafe { fmi3GetNumberOfVariableDependencies(f.c, vr::Y, &mut 0) }),
    ("fmi3GetVariableDependencies", "INESAT", |f| f.dependencies(vr::Y).0),
    ("fmi3GetDirectionalDerivative", "NESAT", |f| f.directional(&[vr::Y], &[vr::U[0]], &[1.0, 0.0], 1).0),
    ("fmi3GetAdjointDerivative",    "NESAT",  |f| f.adjoint(&[vr::Y], &[vr::U[0]], &[1.0], 2).0),
    ("fmi3GetOutputDerivatives",    "ST",     |f| f.output_derivatives(&[vr::Y], &[1], 1).0),
    ("fmi3GetFMUState",             "INESAT", |f| unsafe { fmi3GetFMUState(f.c, &mut ptr::null_mut()) }),
    ("fmi3SetFMUState",             "INESAT", |f| f.restore(f.save())),
    ("fmi3FreeFMUState",            "INESAT", |f| f.free(&mut f.save())),
    ("fmi3SerializedFMUStateSize",  "INESAT", |f| unsafe { fmi3SerializedFMUStateSize(f.c, f.save(), &mut 0) }),
    ("fmi3SerializeFMUState",       "INESAT", |f| { f.serialize(f.save()); Status::Ok }),
    ("fmi3DeserializeFMUState",     "INESAT", |f| f.deserialize(&f.snapshot()).0),
    // Of structural parameters, Model Exchange and Scheduled Execution: never.
    ("fmi3EnterConfigurationMode",  "",       |f| f.call(fmi3EnterConfigurationMode)),
    ("fmi3ExitConfigurationMode",   "",       |f| f.call(fmi3ExitConfigurationMode)),
    ("fmi3EnterContinuousTimeMode", "",       |f| f.call(fmi3EnterContinuousTimeMode)),
    ("fmi3CompletedIntegratorStep", "",       |f| unsafe { fmi3CompletedIntegratorStep(f.c, 1, &mut 0, &mut 0) }),
    ("fmi3SetTime",                 "",       |f| unsafe { fmi3SetTime(f.c, 0.0) }),
    ("fmi3SetContinuousStates",     "",       |f| unsafe { fmi3SetContinuousStates(f.c, ptr::null(), 0) }),
    ("fmi3GetContinuousStateDerivatives", "", |f| unsafe { fmi3GetContinuousStateDerivatives(f.c, ptr::null_mut(), 0) }),
    ("fmi3GetEventIndicators",      "",       |f| unsafe { fmi3GetEventIndicators(f.c, ptr::null_mut(), 0) }),
    ("fmi3GetContinuousStates",     "",       |f| unsafe { fmi3GetContinuousStates(f.c, ptr::null_mut(), 0) }),
    ("fmi3GetNominalsOfContinuousStates", "", |f| unsafe { fmi3GetNominalsOfContinuousStates(f.c, ptr::null_mut(), 0) }),
    ("fmi3GetNumberOfEventIndicators", "",    |f| unsafe { fmi3GetNumberOfEventIndicators(f.c, &mut 0) }),
    ("fmi3GetNumberOfContinuousStates", "",   |f| unsafe { fmi3GetNumberOfContinuousStates(f.c, &mut 0) }),
    ("fmi3ActivateModelPartition",  "",       |f| unsafe { fmi3ActivateModelPartition(f.c, 0, 0.0) }),
];

fn in_state(state: char) -> Fmu3 {
    match state {
        'I' => Fmu3::instantiated(EVENTS),
        'N' => Fmu3::initializing(EVENTS),
        'E' => Fmu3::initialized(EVENTS),
        'S' => Fmu3::stepping(EVENTS),
        'A' => {
            let fmu = Fmu3::stepping(EVENTS);
            assert_eq!(fmu.set(&[vr::HELD], &[2.0]), Status::Ok);
            fmu
        }
        _ => {
            let fmu = Fmu3::stepping(EVENTS);
            assert_eq!(fmu.call(fmi3Terminate), Status::Ok);
            fmu
        }
    }
}

/// Miri, which looks at the memory of the calls, takes two of them.
const STATES: &str = if cfg!(miri) { "NT" } else { "INESAT" };

#[test]
fn each_function_is_allowed_in_its_states_only() {
    for (name, allowed, attempt) in CALLS {
        for state in STATES.chars() {
            let fmu = in_state(state);
            let before = (!cfg!(miri)).then(|| fmu.snapshot());
            let status = attempt(&fmu);
            if allowed.contains(state) {
                assert_eq!(
                    status,
                    Status::Ok,
                    "{name} in {state}: {:?}",
                    fmu.messages()
                );
                continue;
            }
            assert_eq!(status, Status::Error, "{name} in {state}");
            if let Some(before) = before {
                assert_eq!(
                    fmu.snapshot(),
                    before,
                    "{name} in {state} changed the instance"
                );
            }
            let message = fmu.last().text;
            assert!(message.starts_with(&format!("{name}: ")), "{message}");
            assert!(
                [
                    "allowed",
                    "any more",
                    "no value before",
                    "offers Co-Simulation",
                    "does not offer",
                    "no structural"
                ]
                .iter()
                .any(|text| message.contains(text)),
                "{message}"
            );
        }
    }
}

/// Of the 75 functions of the header, all but fmi3GetVersion, three for instantiation and
/// fmi3FreeInstance.
#[test]
fn the_table_has_every_function_with_an_instance() {
    let names: std::collections::BTreeSet<_> = CALLS.iter().map(|(name, ..)| *name).collect();
    assert_eq!(names.len(), 70);
}

#[test]
fn a_call_out_of_order_names_the_states() {
    let fmu = Fmu3::instantiated(EVENTS);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Error);
    assert_eq!(
        fmu.last().text,
        "fmi3DoStep: not allowed in state Instantiated; allowed in Step Mode, Step Mode after a set"
    );
    let fmu = in_state('A');
    assert_eq!(fmu.try_get::<1>(&[vr::Y]).0, Status::Error);
    assert_eq!(
        fmu.last().text,
        "fmi3GetFloat64: not allowed in state Step Mode after a set; allowed in Instantiated, Initialization Mode, Event Mode, Step \
         Mode, Intermediate Update Mode, Terminated"
    );
}

/// Section 4.2.1: what is set in Step Mode acts in the step; it can be read after it, or in Event
/// Mode.
#[test]
fn nothing_is_read_after_a_set_in_step_mode_until_a_step_or_event_mode() {
    let fmu = Fmu3::stepping(EVENTS);
    assert_eq!(fmu.set(&[vr::U[0]], &[0.0, 4.0]), Status::Ok);
    assert_eq!(fmu.try_get::<1>(&[vr::Y]).0, Status::Error);
    assert_eq!(fmu.call(fmi3EnterEventMode), Status::Ok);
    assert_eq!(fmu.get(&[vr::Y]), [4.0]);
    assert_eq!(fmu.set(&[vr::U[0]], &[0.0, 5.0]), Status::Ok);
    assert_eq!(fmu.get(&[vr::Y]), [5.0]);
    assert_eq!(fmu.update(), (Status::Ok, [0; 5]));
    assert_eq!(fmu.call(fmi3EnterStepMode), Status::Ok);
    assert_eq!(fmu.get(&[vr::Y]), [5.0]);
    assert_eq!(fmu.set(&[vr::U[0]], &[0.0, 6.0]), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0).0, Status::Ok);
    assert_eq!(fmu.get(&[vr::Y]), [6.0]);
}

#[test]
fn event_mode_is_for_importers_that_use_it() {
    let fmu = Fmu3::stepping(PLAIN);
    let before = fmu.snapshot();
    assert_eq!(fmu.call(fmi3EnterEventMode), Status::Error);
    assert!(
        fmu.last().text.contains("eventModeUsed was false"),
        "{:?}",
        fmu.last()
    );
    assert_eq!(fmu.snapshot(), before);
}

/// An instance of NULL is an error in every function, not a crash.
#[test]
fn null_instances_are_refused() {
    let null = Fmu3 {
        c: ptr::null_mut(),
        world: None,
    };
    let prepared = [
        "fmi3SetFMUState",
        "fmi3FreeFMUState",
        "fmi3SerializedFMUStateSize",
        "fmi3SerializeFMUState",
        "fmi3DeserializeFMUState",
    ];
    for (name, _, attempt) in CALLS.iter().filter(|(name, ..)| !prepared.contains(name)) {
        assert_eq!(attempt(&null), Status::Error, "{name}");
    }
    assert_eq!(null.restore(ptr::null_mut()), Status::Error);
    assert_eq!(null.free(&mut ptr::null_mut()), Status::Error);
    assert_eq!(null.deserialize(&[]).0, Status::Error);
    // SAFETY: NULL instances.
    unsafe {
        assert_eq!(
            fmi3SerializedFMUStateSize(ptr::null_mut(), ptr::null_mut(), &mut 0),
            Status::Error
        );
        assert_eq!(
            fmi3SerializeFMUState(ptr::null_mut(), ptr::null_mut(), ptr::null_mut(), 0),
            Status::Error
        );
        fmi3FreeInstance(ptr::null_mut());
    }
}
