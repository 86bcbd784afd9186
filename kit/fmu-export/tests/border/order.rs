//! Call order, against the table of FMI 2.0.4 section 4.2.4, written out once more.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;
use std::ptr;
use std::sync::Arc;

type Attempt = fn(&Fmu) -> Status;

/// One correct call of a function.
#[rustfmt::skip]
const CALLS: &[(&str, &str, Attempt)] = &[
    // name, states it is allowed in: I(nstantiated) N (initialization mode) S(tep complete)
    // T(erminated)
    ("fmi2SetDebugLogging",          "INST", |f| unsafe { fmi2SetDebugLogging(f.c, 1, 0, ptr::null()) }),
    ("fmi2SetupExperiment",          "I",    |f| unsafe { fmi2SetupExperiment(f.c, 0, 0.0, 0.0, 0, 0.0) }),
    ("fmi2EnterInitializationMode",  "I",    |f| f.call(fmi2EnterInitializationMode)),
    ("fmi2ExitInitializationMode",   "N",    |f| f.call(fmi2ExitInitializationMode)),
    ("fmi2Terminate",                "S",    |f| f.call(fmi2Terminate)),
    ("fmi2Reset",                    "INST", |f| f.call(fmi2Reset)),
    ("fmi2GetReal",                  "NST",  |f| f.try_get(vr::Y)),
    ("fmi2GetInteger",               "NST",  |f| unsafe { fmi2GetInteger(f.c, &vr::LEVEL, 1, &mut 0) }),
    ("fmi2GetBoolean",               "NST",  |f| unsafe { fmi2GetBoolean(f.c, &vr::ON, 1, &mut 0) }),
    ("fmi2GetString",                "NST",  |f| unsafe { fmi2GetString(f.c, &vr::FILE, 1, &mut ptr::null()) }),
    ("fmi2SetReal",                  "INS",  |f| f.set(&[vr::U[0]], &[1.0])),
    ("fmi2SetInteger",               "INS",  |f| f.set_integer(vr::FAULT, 0)),
    ("fmi2SetBoolean",               "INS",  |f| f.set_boolean(vr::SWITCH, 1)),
    ("fmi2SetString",                "IN",   |f| f.set_string(vr::FILE, c"1")),
    ("fmi2GetFMUstate",              "INST", |f| unsafe { fmi2GetFMUstate(f.c, &mut ptr::null_mut()) }),
    ("fmi2SetFMUstate",              "INST", |f| f.restore(f.save())),
    ("fmi2FreeFMUstate",             "INST", |f| f.free(&mut f.save())),
    ("fmi2SerializedFMUstateSize",   "INST", |f| unsafe { fmi2SerializedFMUstateSize(f.c, f.save(), &mut 0) }),
    ("fmi2SerializeFMUstate",        "INST", |f| { f.serialize(f.save()); Status::Ok }),
    ("fmi2DeSerializeFMUstate",      "INST", |f| f.deserialize(&f.snapshot()).0),
    ("fmi2GetDirectionalDerivative", "NST",  |f| f.directional(&[vr::Y], &[vr::U[0]], &[1.0]).0),
    ("fmi2SetRealInputDerivatives",  "INS",  |f| f.derivatives(&[vr::U[0]], &[1], &[1.0])),
    ("fmi2GetRealOutputDerivatives", "ST",   |f| f.output_derivative(vr::Y, 1).0),
    ("fmi2DoStep",                   "S",    |f| f.step(0.0, 1.0)),
    ("fmi2CancelStep",               "",     |f| f.call(fmi2CancelStep)),
    ("fmi2GetStatus",                "ST",   |f| unsafe { fmi2GetStatus(f.c, DO_STEP_STATUS, &mut Status::Ok) }),
    ("fmi2GetRealStatus",            "ST",   |f| unsafe { fmi2GetRealStatus(f.c, LAST_SUCCESSFUL_TIME, &mut 0.0) }),
    ("fmi2GetBooleanStatus",         "ST",   |f| unsafe { fmi2GetBooleanStatus(f.c, TERMINATED, &mut 0) }),
    // FMI 2.0 defines no Integer status, and no step is ever pending.
    ("fmi2GetIntegerStatus",         "",     |f| unsafe { fmi2GetIntegerStatus(f.c, DO_STEP_STATUS, &mut 0) }),
    ("fmi2GetStringStatus",          "",     |f| unsafe { fmi2GetStringStatus(f.c, PENDING_STATUS, &mut ptr::null()) }),
];

fn in_state(state: char) -> Fmu {
    match state {
        'I' => Fmu::instantiated(),
        'N' => Fmu::initializing(),
        'S' => Fmu::stepping(),
        _ => {
            let fmu = Fmu::stepping();
            assert_eq!(fmu.call(fmi2Terminate), Status::Ok);
            fmu
        }
    }
}

/// Miri, which looks at the memory of the calls, takes two of them.
const STATES: &str = if cfg!(miri) { "NT" } else { "INST" };

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
            assert!(
                matches!(status, Status::Error | Status::Discard),
                "{name} in {state}: {status:?}"
            );
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
                ["allowed", "any more", "synchronous", "has no"]
                    .iter()
                    .any(|text| message.contains(text)),
                "{message}"
            );
        }
    }
}

#[test]
fn a_call_out_of_order_names_the_states() {
    let fmu = Fmu::instantiated();
    assert_eq!(fmu.step(0.0, 1.0), Status::Error);
    assert_eq!(
        fmu.last().text,
        "fmi2DoStep: not allowed in state Instantiated; allowed in Step Complete"
    );
    assert_eq!(fmu.try_get(vr::X[0]), Status::Error);
    let states = "allowed in Initialization Mode, Step Complete, Terminated";
    assert_eq!(
        fmu.last().text,
        format!("fmi2GetReal: not allowed in state Instantiated; {states}")
    );
}

/// An instance of NULL is an error in every function, not a crash.
#[test]
fn null_instances_are_refused() {
    let null = Fmu {
        c: ptr::null_mut(),
        log: Arc::default(),
    };
    for (name, _, attempt) in CALLS {
        if [
            "fmi2SetFMUstate",
            "fmi2FreeFMUstate",
            "fmi2SerializedFMUstateSize",
            "fmi2SerializeFMUstate",
            "fmi2DeSerializeFMUstate",
        ]
        .contains(name)
        {
            continue; // these need an instance to prepare; below
        }
        assert_eq!(attempt(&null), Status::Error, "{name}");
    }
    assert_eq!(null.restore(ptr::null_mut()), Status::Error);
    assert_eq!(null.free(&mut ptr::null_mut()), Status::Error);
    assert_eq!(null.deserialize(&[]).0, Status::Error);
    // SAFETY: NULL instances.
    unsafe {
        assert_eq!(
            fmi2SerializedFMUstateSize(ptr::null_mut(), ptr::null_mut(), &mut 0),
            Status::Error
        );
        assert_eq!(
            fmi2SerializeFMUstate(ptr::null_mut(), ptr::null_mut(), ptr::null_mut(), 0),
            Status::Error
        );
        fmi2FreeInstance(ptr::null_mut());
    }
}
