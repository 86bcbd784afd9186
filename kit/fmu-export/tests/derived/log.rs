//! Messages of the model: to whom they go, and how many of them.

use crate::client::*;
use crate::heater::vr;
use allocation_counter::measure;
use fmu_export::ffi::*;
use std::ffi::CStr;

impl Fmu {
    /// The messages since the last call of this.
    fn news(&self) -> Vec<(Status, String, String)> {
        let news = std::mem::take(&mut *self.log.lock().unwrap());
        news.into_iter()
            .map(|m| (m.status, m.category, m.text))
            .collect()
    }

    fn debug(&self, on: i32, categories: &[&CStr]) -> Status {
        let categories: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        unsafe { fmi2SetDebugLogging(self.c, on, categories.len(), categories.as_ptr()) }
    }

    /// A stepping instance that is hot and switched on, so that each step has messages of both
    /// levels.
    fn hot(logging_on: bool) -> Self {
        let fmu = Fmu::with(callbacks, c"file:///tmp/", logging_on);
        assert_eq!(fmu.set(&[vr::AMBIENT], &[400.0]), Status::Ok);
        assert_eq!(fmu.set_boolean(vr::ON, 1), Status::Ok);
        fmu.setup(0.0, None);
        assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
        fmu.start();
        fmu
    }
}

fn said(status: Status, category: &str, text: &str) -> (Status, String, String) {
    (status, category.to_owned(), text.to_owned())
}

const HOT: &str = "400.00625 K is hot";

/// One step of 0.01 s from 400 K: 500 W into 800 J/K.
fn step(fmu: &Fmu, t: f64) -> Vec<(Status, String, String)> {
    assert_eq!(fmu.step(t, 0.01), Status::Ok);
    fmu.news()
}

#[test]
fn with_logging_everything_is_told_in_order_under_its_category() {
    let fmu = Fmu::hot(true);
    let expected = [
        said(Status::Ok, "heat", "starts at 400 K"),
        said(Status::Ok, "logEvents", "initialized"),
    ];
    assert!(fmu.news().ends_with(&expected));
    let expected = [
        said(Status::Warning, "heat", HOT),
        said(Status::Ok, "switch", "on at 0 s"),
        said(Status::Ok, "logEvents", "done"),
        said(Status::Ok, "logEvents", "not declared"),
    ];
    assert_eq!(step(&fmu, 0.0), expected);
    assert_eq!(fmu.set(&[vr::POWER], &[100.0]), Status::Ok);
    assert_eq!(
        fmu.news(),
        [said(Status::Warning, "logStatusWarning", "power = 100 W")]
    );
}

#[test]
fn without_logging_warnings_are_told_alone() {
    let fmu = Fmu::hot(false);
    assert_eq!(fmu.news(), []);
    assert_eq!(step(&fmu, 0.0), [said(Status::Warning, "heat", HOT)]);
    assert_eq!(fmu.debug(0, &[]), Status::Ok);
    assert_eq!(step(&fmu, 0.01), []);
}

#[test]
fn categories_are_switched_one_by_one() {
    let fmu = Fmu::hot(false);
    assert_eq!(fmu.debug(1, &[c"switch"]), Status::Ok);
    assert_eq!(step(&fmu, 0.0), [said(Status::Ok, "switch", "on at 0 s")]);
    // A warning is heard as one of its category, and as a warning.
    assert_eq!(fmu.debug(1, &[c"heat"]), Status::Ok);
    assert_eq!(step(&fmu, 0.01).len(), 1);
    assert_eq!(fmu.debug(1, &[c"logStatusWarning"]), Status::Ok);
    assert_eq!(step(&fmu, 0.02).len(), 1);
    assert_eq!(
        fmu.debug(1, &[c"logEvents", c"heat", c"nothing"]),
        Status::Ok
    );
    assert_eq!(step(&fmu, 0.03).len(), 3);
    assert_eq!(fmu.debug(0, &[c"heat", c"logEvents"]), Status::Ok);
    assert_eq!(step(&fmu, 0.04), []);
    assert_eq!(fmu.debug(1, &[c"logAll"]), Status::Ok);
    assert_eq!(step(&fmu, 0.05).len(), 4);
}

#[test]
fn a_discarded_step_tells_why_before_it_is_refused() {
    let fmu = Fmu::hot(true);
    fmu.news();
    assert_eq!(fmu.step(0.0, 1000.0), Status::Discard);
    let news = fmu.news();
    assert_eq!(
        news[0],
        said(Status::Warning, "heat", "t = 0 s: 1025 K, 100% lost")
    );
    assert_eq!(news[1].0, Status::Discard);
    assert_eq!(news.len(), 2);
}

/// The first ten of a kind, then the 100th, the 1000th.
#[test]
#[cfg_attr(miri, ignore = "too long for an interpreter")]
fn a_flood_is_thinned_out() {
    let fmu = Fmu::hot(false);
    assert_eq!(fmu.debug(1, &[c"switch"]), Status::Ok);
    let mut news = Vec::new();
    for k in 0..2500 {
        assert_eq!(fmu.step(f64::from(k) * 0.01, 0.01), Status::Ok);
        news.extend(fmu.news().into_iter().map(|(_, _, text)| (k, text)));
    }
    let counts: Vec<_> = news.iter().map(|(k, _)| *k).collect();
    assert_eq!(counts, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 99, 999]);
    assert_eq!(
        news[9].1,
        "on at 0.09 s (from now on only the 100th, the 1000th and so on are sent)"
    );
    assert_eq!(news[10].1, "on at 0.99 s (the 100th of these messages)");
}

/// What nobody wants to hear costs nothing, and neither does what is left out of a flood.
#[test]
fn a_step_without_a_message_does_not_allocate() {
    let fmu = Fmu::hot(false);
    let run = |from: i32, to: i32| {
        (from..to).for_each(|k| assert_eq!(fmu.step(f64::from(k) * 0.01, 0.01), Status::Ok))
    };
    assert_ne!(measure(|| run(0, 10)).count_total, 0, "ten warnings");
    assert_eq!(measure(|| run(10, 99)).count_total, 0);
    assert_ne!(
        measure(|| run(99, 100)).count_total,
        0,
        "the hundredth warning"
    );
    assert_eq!(fmu.debug(0, &[]), Status::Ok);
    assert_eq!(measure(|| run(100, 1100)).count_total, 0);
}

/// A model that tells everything to nobody.
#[test]
fn without_a_logger_nothing_is_told() {
    let silent = |log: &_| CallbackFunctions {
        logger: None,
        ..callbacks(log)
    };
    let fmu = Fmu::with(silent, c"file:///tmp/", true);
    fmu.setup(0.0, None);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    assert_eq!(
        measure(|| assert_eq!(fmu.step(0.0, 0.01), Status::Ok)).count_total,
        0
    );
}

/// Messages are not part of a state.
#[test]
fn saved_states_do_not_depend_on_what_was_told() {
    let [loud, quiet] = [true, false].map(|on| {
        let fmu = Fmu::hot(on);
        step(&fmu, 0.0);
        fmu.snapshot()
    });
    assert_eq!(loud, quiet);
}

#[test]
fn own_categories_are_declared() {
    let xml = fmu_export::model_description::<crate::heater::Heater>().unwrap();
    assert!(xml.contains("<Category name=\"heat\" description=\"Heat and temperatures\"/>\n    <Category name=\"switch\" description=\"Switching\"/>\n  </LogCategories>"), "{xml}");
}
