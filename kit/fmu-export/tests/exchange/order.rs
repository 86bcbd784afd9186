//! Call order, against FMI 2.0.4 section 3.2.3 and FMI 3.0.2 sections 2.3 and 3.2, written out once
//! more.

use crate::client::*;
use crate::vr;
use fmu_export::ffi::EventInfo;
use std::ffi::c_int;
use std::ptr;

type Attempt = fn(&Fmu) -> c_int;

/// One correct call of a function, and the states it is allowed in: I(nstantiated) N (initialization
/// mode) E(vent mode) C(ontinuous-time mode) T(erminated).
#[rustfmt::skip]
const CALLS2: &[(&str, &str, Attempt)] = &[
    ("fmi2SetupExperiment",          "I",     |f| unsafe { fmi2SetupExperiment(f.c, 0, 0.0, 0.0, 0, 0.0) }),
    ("fmi2EnterInitializationMode",  "I",     |f| unsafe { fmi2EnterInitializationMode(f.c) }),
    ("fmi2ExitInitializationMode",   "N",     |f| unsafe { fmi2ExitInitializationMode(f.c) }),
    ("fmi2Terminate",                "EC",    |f| unsafe { fmi2Terminate(f.c) }),
    ("fmi2Reset",                    "INECT", |f| unsafe { fmi2Reset(f.c) }),
    ("fmi2GetReal",                  "NECT",  |f| unsafe { fmi2GetReal(f.c, &vr::ENERGY, 1, &mut 0.0) }),
    ("fmi2GetReal",                  "NECT",  |f| unsafe { fmi2GetReal(f.c, &vr::DER_VELOCITY, 1, &mut 0.0) }),
    ("fmi2GetInteger",               "NECT",  |f| unsafe { fmi2GetInteger(f.c, &vr::BOUNCES, 1, &mut 0) }),
    ("fmi2SetReal",                  "INEC",  |f| f.set(vr::WIND, &[1.0])),
    ("fmi2SetReal",                  "INE",   |f| f.set(vr::RESTITUTION, &[0.5])),
    ("fmi2SetInteger",               "INE",   |f| f.set_integer(vr::FAULT, 0)),
    ("fmi2GetFMUstate",              "INECT", |f| { f.save(); 0 }),
    ("fmi2SetFMUstate",              "INECT", |f| f.restore(f.save())),
    ("fmi2DeSerializeFMUstate",      "INECT", |f| { f.deserialize(&f.bytes()).unwrap(); 0 }),
    ("fmi2GetDirectionalDerivative", "NECT",  |f| unsafe { fmi2GetDirectionalDerivative(f.c, &vr::DER_VELOCITY, 1, &vr::WIND, 1, &1.0, &mut 0.0) }),
    ("fmi2EnterEventMode",           "EC",    |f| unsafe { fmi2EnterEventMode(f.c) }),
    ("fmi2NewDiscreteStates",        "E",     |f| unsafe { fmi2NewDiscreteStates(f.c, &mut EventInfo::default()) }),
    ("fmi2EnterContinuousTimeMode",  "E",     |f| unsafe { fmi2EnterContinuousTimeMode(f.c) }),
    ("fmi2CompletedIntegratorStep",  "C",     |f| unsafe { fmi2CompletedIntegratorStep(f.c, 1, &mut 0, &mut 0) }),
    ("fmi2SetTime",                  "EC",    |f| f.set_time(0.5)),
    ("fmi2SetContinuousStates",      "C",     |f| f.set_states(&[1.0; 4])),
    ("fmi2GetDerivatives",           "ECT",   |f| unsafe { fmi2GetDerivatives(f.c, [0.0; 4].as_mut_ptr(), 4) }),
    ("fmi2GetEventIndicators",       "NECT",  |f| unsafe { fmi2GetEventIndicators(f.c, &mut 0.0, 1) }),
    ("fmi2GetContinuousStates",      "NECT",  |f| unsafe { fmi2GetContinuousStates(f.c, [0.0; 4].as_mut_ptr(), 4) }),
    ("fmi2GetNominalsOfContinuousStates", "IECT", |f| unsafe { fmi2GetNominalsOfContinuousStates(f.c, [0.0; 4].as_mut_ptr(), 4) }),
    ("fmi2DoStep",                   "",      |f| unsafe { fmi2DoStep(f.c, 0.0, 0.1, 0) }),
    ("fmi2GetStatus",                "",      |f| unsafe { fmi2GetStatus(f.c, 0, &mut 0) }),
    ("fmi2SetRealInputDerivatives",  "",      |f| unsafe { fmi2SetRealInputDerivatives(f.c, &vr::WIND, 1, &1, &1.0) }),
];

#[rustfmt::skip]
const CALLS3: &[(&str, &str, Attempt)] = &[
    ("fmi3EnterInitializationMode",  "I",     |f| unsafe { fmi3EnterInitializationMode(f.c, false, 0.0, 0.0, false, 0.0) }),
    ("fmi3ExitInitializationMode",   "N",     |f| unsafe { fmi3ExitInitializationMode(f.c) }),
    ("fmi3Terminate",                "EC",    |f| unsafe { fmi3Terminate(f.c) }),
    ("fmi3Reset",                    "INECT", |f| unsafe { fmi3Reset(f.c) }),
    ("fmi3GetFloat64",               "NECT",  |f| unsafe { fmi3GetFloat64(f.c, &vr::ENERGY, 1, &mut 0.0, 1) }),
    ("fmi3GetInt32",                 "NECT",  |f| unsafe { fmi3GetInt32(f.c, &vr::BOUNCES, 1, &mut 0, 1) }),
    ("fmi3SetFloat64",               "INEC",  |f| f.set(vr::WIND, &[1.0, 1.0])),
    ("fmi3SetFloat64",               "INE",   |f| f.set(vr::RESTITUTION, &[0.5])),
    ("fmi3SetInt32",                 "INE",   |f| f.set_integer(vr::FAULT, 0)),
    ("fmi3GetFMUState",              "INECT", |f| { f.save(); 0 }),
    ("fmi3SetFMUState",              "INECT", |f| f.restore(f.save())),
    ("fmi3DeserializeFMUState",      "INECT", |f| { f.deserialize(&f.bytes()).unwrap(); 0 }),
    ("fmi3GetDirectionalDerivative", "NECT",  |f| unsafe { fmi3GetDirectionalDerivative(f.c, &vr::ENERGY, 1, &vr::KICK, 1, &1.0, 1, &mut 0.0, 1) }),
    ("fmi3EnterEventMode",           "C",     |f| unsafe { fmi3EnterEventMode(f.c) }),
    ("fmi3EvaluateDiscreteStates",   "E",     |f| unsafe { fmi3EvaluateDiscreteStates(f.c) }),
    ("fmi3UpdateDiscreteStates",     "E",     |f| unsafe {
        fmi3UpdateDiscreteStates(f.c, &mut false, &mut false, &mut false, &mut false, &mut false, &mut 0.0)
    }),
    ("fmi3EnterContinuousTimeMode",  "E",     |f| unsafe { fmi3EnterContinuousTimeMode(f.c) }),
    ("fmi3CompletedIntegratorStep",  "C",     |f| unsafe { fmi3CompletedIntegratorStep(f.c, true, &mut false, &mut false) }),
    ("fmi3SetTime",                  "EC",    |f| f.set_time(0.5)),
    ("fmi3SetContinuousStates",      "C",     |f| f.set_states(&[1.0; 4])),
    ("fmi3GetContinuousStateDerivatives", "NECT", |f| unsafe { fmi3GetContinuousStateDerivatives(f.c, [0.0; 4].as_mut_ptr(), 4) }),
    ("fmi3GetEventIndicators",       "NECT",  |f| unsafe { fmi3GetEventIndicators(f.c, &mut 0.0, 1) }),
    ("fmi3GetContinuousStates",      "NECT",  |f| unsafe { fmi3GetContinuousStates(f.c, [0.0; 4].as_mut_ptr(), 4) }),
    ("fmi3GetNominalsOfContinuousStates", "NECT", |f| unsafe { fmi3GetNominalsOfContinuousStates(f.c, [0.0; 4].as_mut_ptr(), 4) }),
    ("fmi3GetNumberOfContinuousStates", "INECT", |f| unsafe { fmi3GetNumberOfContinuousStates(f.c, &mut 0) }),
    ("fmi3GetNumberOfEventIndicators", "INECT", |f| unsafe { fmi3GetNumberOfEventIndicators(f.c, &mut 0) }),
    ("fmi3EnterStepMode",            "",      |f| unsafe { fmi3EnterStepMode(f.c) }),
    ("fmi3DoStep",                   "",      |f| unsafe { fmi3DoStep(f.c, 0.0, 0.1, true, &mut false, &mut false, &mut false, &mut 0.0) }),
    ("fmi3GetOutputDerivatives",     "",      |f| unsafe { fmi3GetOutputDerivatives(f.c, ptr::null(), 0, ptr::null(), ptr::null_mut(), 0) }),
];

fn in_state(version: u8, state: char) -> Fmu {
    let fmu = match state {
        'I' | 'N' => Fmu::new(version),
        'E' => Fmu::in_event_mode(version),
        _ => Fmu::running(version),
    };
    match state {
        'N' => fmu.enter_initialization(),
        'T' => assert_eq!(fmu.call([fmi2Terminate, fmi3Terminate]), 0),
        _ => {}
    }
    fmu
}

#[test]
fn each_function_is_allowed_in_its_states_only() {
    for (version, calls) in [(2, CALLS2), (3, CALLS3)] {
        for (name, allowed, attempt) in calls {
            for state in "INECT".chars() {
                let fmu = in_state(version, state);
                let before = fmu.bytes();
                let status = attempt(&fmu);
                if allowed.contains(state) {
                    assert_eq!(status, 0, "{name} in {state}: {}", fmu.last());
                    continue;
                }
                assert_eq!(status, 3, "{name} in {state}: {}", fmu.last());
                assert!(
                    fmu.bytes() == before,
                    "{name} in {state} changed the instance"
                );
                let message = fmu.last();
                let is_said = message.starts_with(&format!("{name}: "))
                    && [
                        "not allowed",
                        "is for Co-Simulation",
                        "can be set",
                        "any more",
                        "no value",
                    ]
                    .iter()
                    .any(|text| message.contains(text));
                assert!(is_said, "{message}");
            }
        }
    }
}

/// The other interface's states are not named to an instance of this one.
#[test]
fn a_call_out_of_order_names_the_states() {
    let fmu = Fmu::in_event_mode(2);
    assert_eq!(fmu.set_states(&[0.0; 4]), 3);
    assert_eq!(
        fmu.last(),
        "fmi2SetContinuousStates: not allowed in state Event Mode; allowed in Continuous-Time Mode"
    );
    assert_eq!(unsafe { fmi2EnterInitializationMode(fmu.c) }, 3);
    assert_eq!(
        fmu.last(),
        "fmi2EnterInitializationMode: not allowed in state Event Mode; allowed in Instantiated"
    );
    let fmu = Fmu::new(2);
    assert_eq!(unsafe { fmi2GetReal(fmu.c, &vr::ENERGY, 1, &mut 0.0) }, 3);
    assert_eq!(
        fmu.last(),
        "fmi2GetReal: not allowed in state Instantiated; allowed in Initialization Mode, Event Mode, Continuous-Time Mode, Terminated"
    );
    let fmu = Fmu::of(2, 1);
    assert_eq!(fmu.set_time(0.0), 3);
    assert_eq!(
        fmu.last(),
        "fmi2SetTime: this function is for Model Exchange, and the instance was made for Co-Simulation"
    );
    assert_eq!(unsafe { fmi2GetReal(fmu.c, &vr::ENERGY, 1, &mut 0.0) }, 3);
    assert_eq!(
        fmu.last(),
        "fmi2GetReal: not allowed in state Instantiated; allowed in Initialization Mode, Step Complete, Terminated"
    );
}
