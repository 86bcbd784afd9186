//! Value references, constants, calculated parameters, texts, enumerations and nested structs.

use crate::client::*;
use crate::heater::{Heater, vr};
use fmu_export::ffi::*;
use std::ptr;

/// Checks that `wrong` has this status, says `text`, and changes nothing that can be saved.
fn answered(fmu: &Fmu, status: Status, text: &str, wrong: impl FnOnce() -> Status) {
    let before = fmu.snapshot();
    assert_eq!(wrong(), status, "{text}");
    assert_eq!(fmu.last().text, text);
    assert_eq!(fmu.snapshot(), before, "{text}");
}

#[test]
fn the_table_agrees_with_the_model() {
    assert_eq!(fmu_export::check::<Heater>(), [""; 0]);
}

#[test]
fn value_references_are_what_the_rows_say() {
    let fmu = Fmu::stepping();
    let reals = [
        vr::ZERO,
        vr::CAPACITY,
        vr::CONDUCTANCE,
        vr::POWER,
        vr::LIMITS[0],
        vr::LIMITS[1],
        vr::AMBIENT,
    ];
    assert_eq!(
        fmu.get(reals),
        [273.15, 800.0, 2.0, 500.0, 60.0, 62.5, 293.15]
    );
    for (number, must) in [
        (vr::GAP, "one of the model description"),
        (vr::POWER - 1, "one of the model description"),
        (vr::AMBIENT - 1, "one of the model description"),
        (vr::BEYOND, "from 0 to 203"),
        (u32::MAX, "from 0 to 203"),
    ] {
        let text = |call| format!("{call}: unknown value reference {number}; it must be {must}");
        answered(&fmu, Status::Error, &text("fmi2SetReal"), || {
            fmu.set(&[vr::POWER, number], &[400.0, 1.0])
        });
        answered(&fmu, Status::Error, &text("fmi2GetReal"), || {
            fmu.try_get(number)
        });
        answered(&fmu, Status::Error, &text("fmi2SetInteger"), || {
            fmu.set_integer(number, 1)
        });
        answered(&fmu, Status::Error, &text("fmi2SetString"), || {
            fmu.set_string(number, c"a")
        });
    }
    let xml = fmu_export::model_description::<Heater>().unwrap();
    for (name, number) in [
        ("body.capacity", 1),
        ("power", 10),
        ("limits[2]", 13),
        ("ambient", 100),
        ("mode", 102),
        ("switched_by", 203),
    ] {
        assert!(
            xml.contains(&format!("name=\"{name}\" valueReference=\"{number}\"")),
            "{name}"
        );
    }
    // Positions count variables, not references: `temperature` is the eleventh.
    assert!(
        xml.contains("<Unknown index=\"11\" dependencies=\"\"/>"),
        "{xml}"
    );
}

/// What was set of which parameter is kept by reference: with gaps and out of the file order too.
#[test]
fn parameters_behind_a_gap_are_kept() {
    let fmu = Fmu::instantiated();
    assert_eq!(
        fmu.set(
            &[vr::LIMITS[1], vr::CAPACITY, vr::POWER],
            &[70.5, 900.0, 250.0]
        ),
        Status::Ok
    );
    assert_eq!(fmu.set_string(vr::NOTE, c"a \xc3\xa4"), Status::Ok);
    fmu.setup(0.0, None);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    let bytes = fmu.snapshot();
    assert_eq!(fmu.call(fmi2Reset), Status::Ok);
    assert_eq!(fmu.set(&[vr::POWER], &[1.0]), Status::Ok);
    let (status, mut state) = fmu.deserialize(&bytes);
    assert_eq!(status, Status::Ok, "{:?}", fmu.last());
    assert_eq!(fmu.restore(state), Status::Ok);
    assert_eq!(fmu.free(&mut state), Status::Ok);
    assert_eq!(
        fmu.get([vr::LIMITS[0], vr::LIMITS[1], vr::CAPACITY, vr::POWER]),
        [60.0, 70.5, 900.0, 250.0]
    );
    assert_eq!(fmu.get_string(vr::NOTE), "a ä");
    assert_eq!(fmu.snapshot(), bytes);
}

#[test]
fn constants_and_calculated_parameters_can_be_read_only() {
    let fmu = Fmu::instantiated();
    answered(
        &fmu,
        Status::Error,
        "fmi2SetReal: `zero` = 1: a Real constant cannot be set; only inputs and parameters can",
        || fmu.set(&[vr::ZERO], &[1.0]),
    );
    fmu.setup(0.0, None);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    assert_eq!(fmu.get([vr::TIME_CONSTANT, vr::ZERO]), [400.0, 273.15]);
    assert_eq!(fmu.set(&[vr::CAPACITY], &[1000.0]), Status::Ok);
    assert_eq!(fmu.get([vr::TIME_CONSTANT]), [500.0]);
    let text = "fmi2SetReal: `time_constant` = 1: a Real calculated parameter cannot be set; only inputs and parameters can";
    answered(&fmu, Status::Error, text, || {
        fmu.set(&[vr::TIME_CONSTANT], &[1.0])
    });
    fmu.start();
    answered(&fmu, Status::Error, text, || {
        fmu.set(&[vr::TIME_CONSTANT], &[1.0])
    });
    assert_eq!(fmu.get([vr::TIME_CONSTANT]), [500.0]);
    assert_eq!(fmu.call(fmi2Terminate), Status::Ok);
    assert_eq!(fmu.get([vr::TIME_CONSTANT, vr::ZERO]), [500.0, 273.15]);
    let xml = fmu_export::model_description::<Heater>().unwrap();
    assert!(
        xml.contains(r#"causality="calculatedParameter" variability="fixed" initial="calculated""#)
    );
    assert!(xml.contains(r#"causality="local" variability="constant" initial="exact""#));
    assert!(xml.contains(r#"<Real unit="K" start="273.15"/>"#));
    // Only among the initial unknowns: it is number 13, and follows the parameters 2 and 3.
    assert_eq!(xml.matches(r#"<Unknown index="13""#).count(), 1);
    assert!(
        xml.contains(r#"<Unknown index="13" dependencies="2 3"/>"#),
        "{xml}"
    );
}

#[test]
fn a_text_follows_state_and_inputs() {
    let fmu = Fmu::initializing();
    assert_eq!(fmu.get_string(vr::DOING), "rests");
    fmu.start();
    assert_eq!(fmu.set_boolean(vr::ON, 1), Status::Ok);
    assert_eq!(fmu.get_string(vr::DOING), "heats");
    assert_eq!(fmu.set_integer(vr::MODE, 3), Status::Ok);
    assert_eq!(fmu.step(0.0, 1.0), Status::Ok);
    assert_eq!(fmu.get_string(vr::DOING), "heats");
    assert_eq!(fmu.set_integer(vr::MODE, 1), Status::Ok);
    assert_eq!(fmu.get_string(vr::DOING), "rests");
    answered(
        &fmu,
        Status::Error,
        "fmi2SetString: `doing` = \"x\": a String output cannot be set; only inputs and parameters can",
        || fmu.set_string(vr::DOING, c"x"),
    );
    answered(
        &fmu,
        Status::Error,
        "fmi2GetReal: `doing` is a String output and cannot be read as Real; it must be read as String",
        || fmu.try_get(vr::DOING),
    );
    let mut text = ptr::null();
    answered(
        &fmu,
        Status::Error,
        "fmi2GetString: `power` is a Real tunable parameter and cannot be read as String; it must be read as Real",
        || unsafe { fmi2GetString(fmu.c, &vr::POWER, 1, &mut text) },
    );
    assert_eq!(fmu.call(fmi2Terminate), Status::Ok);
    assert_eq!(fmu.get_string(vr::DOING), "rests");
}

/// Not before initialization: there is nothing to compute them of.
#[test]
fn outputs_of_all_types_wait_for_initialization() {
    let fmu = Fmu::instantiated();
    let mut text = ptr::null();
    let place = "not allowed in state Instantiated; allowed in Initialization Mode, Step Complete, Terminated";
    answered(
        &fmu,
        Status::Error,
        &format!("fmi2GetString: {place}"),
        || unsafe { fmi2GetString(fmu.c, &vr::DOING, 1, &mut text) },
    );
    answered(
        &fmu,
        Status::Error,
        &format!("fmi2GetReal: {place}"),
        || fmu.try_get(vr::TIME_CONSTANT),
    );
}

#[test]
fn enumerations_take_their_items_only() {
    let fmu = Fmu::stepping();
    for item in 1..=3 {
        assert_eq!(fmu.set_integer(vr::MODE, item), Status::Ok);
        assert_eq!(fmu.get_integer(vr::SWITCHED_BY), item);
    }
    for wrong in [0, 4, -1, i32::MIN, i32::MAX] {
        let text = format!(
            "fmi2SetInteger: `mode` = {wrong} must be 1 (Off) or 2 (Manual) or 3 (Thermostat)"
        );
        answered(&fmu, Status::Discard, &text, || {
            fmu.set_integer(vr::MODE, wrong)
        });
    }
    assert_eq!(fmu.get_integer(vr::SWITCHED_BY), 3);
}

#[test]
fn units_with_an_offset_are_in_the_description() {
    let xml = fmu_export::model_description::<Heater>().unwrap();
    assert!(
        xml.contains("<Unit name=\"degC\">\n      <BaseUnit K=\"1\" offset=\"273.15\"/>"),
        "{xml}"
    );
    assert!(xml.contains("<BaseUnit K=\"1\"/>\n      <DisplayUnit name=\"degC\" factor=\"1.0\" offset=\"-273.15\"/>"), "{xml}");
}
