//! Clocks: the same ticks in both interfaces and both versions of FMI, driven as importers do by C
//! name; what belongs to a clock; and Scheduled Execution.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

mod importer;
mod model;
#[path = "../ways/mod.rs"]
mod ways;

use fmu_export::{check, model_description, model_description3};
use importer::{Fmu, reference};
use model::Ticking;
use std::ffi::c_int;
use ways::{C, Instance, Way};

/// Oracle: the definitions of FMI 3.0.2, 2.2.9; the level 0.33 is reached at 0.33 s, as x' = 1.
fn expected() -> Vec<[f64; 3]> {
    let periodic = |kind: f64, period: f64, shift: f64| {
        let ticks = (0..40).map(move |k| [shift + period * f64::from(k), kind, period]);
        ticks.filter(|tick| tick[0] < 1.0 + 1e-9)
    };
    let mut all: Vec<_> = periodic(1.0, 0.1, 0.0).collect();
    all.extend(periodic(2.0, 0.2, 0.05));
    all.extend(periodic(3.0, 0.3, 0.0));
    all.extend(periodic(4.0, 0.25, 0.0));
    all.extend([[0.11, 5.0, 0.11], [0.33, 5.0, 0.22], [0.66, 5.0, 0.33]]);
    all.push([0.3425, 6.0, 0.3425]);
    all.sort_by(|a, b| (a[0] + 1e-9 * a[1]).total_cmp(&(b[0] + 1e-9 * b[1])));
    all
}

#[test]
fn all_ways_have_the_same_ticks() {
    assert_eq!(check::<Ticking>(), [""; 0]);
    let expected = expected();
    for way in Way::ALL {
        let mut fmu = Fmu::<Ticking>::new(way);
        fmu.run(1.0);
        let found = fmu.ticks();
        assert_eq!(
            found.len(),
            expected.len(),
            "{way:?}: {found:?}\n{expected:?}"
        );
        for (found, exact) in found.iter().zip(&expected) {
            let error = (0..3).map(|k| (found[k] - exact[k]).abs());
            assert!(
                error.fold(0.0, f64::max) < 1e-9,
                "{way:?}: {found:?} {exact:?}"
            );
        }
        // The input was 1, 2, … at the ticks of `constant`.
        assert_eq!(fmu.sums, [66.0, 55.0], "{way:?}");
    }
}

#[test]
fn the_description_has_clocks_in_fmi_3_alone() {
    let (two, three) = (
        model_description::<Ticking>().unwrap(),
        model_description3::<Ticking>().unwrap(),
    );
    assert!(!two.contains("<Clock") && !two.contains("\"alarm\""));
    let line = |name: &str| {
        let line = three
            .lines()
            .find(|line| line.contains(&format!(" name=\"{name}\"")));
        line.unwrap_or_else(|| panic!("{name}")).trim().to_owned()
    };
    let has = |name: &str, parts: &[&str]| {
        let line = line(name);
        assert!(parts.iter().all(|part| line.contains(part)), "{line}");
    };
    has(
        "constant",
        &[
            "<Clock ",
            "causality=\"input\"",
            "intervalVariability=\"constant\"",
            "intervalDecimal=\"0.1\"",
        ],
    );
    has(
        "fixed",
        &[
            "intervalVariability=\"fixed\"",
            "intervalDecimal=\"0.2\"",
            "shiftDecimal=\"0.05\"",
        ],
    );
    for (name, kind) in [
        ("calculated", "fixed"),
        ("tunable", "tunable"),
        ("changing", "changing"),
        ("alarm", "countdown"),
    ] {
        has(name, &[&format!("intervalVariability=\"{kind}\"")]);
        assert!(!line(name).contains("intervalDecimal") && !line(name).contains("initial"));
    }
    let clock = format!("clocks=\"{}\"", reference(&three, "constant"));
    has("u", &[&clock, "variability=\"discrete\""]);
    let previous = format!("previous=\"{}\"", reference(&three, "sum_before"));
    has("sum", &[&clock, &previous]);
    let sum = reference(&three, "sum");
    assert!(three.contains(&format!("<ClockedState valueReference=\"{sum}\"")));
    // All other value references are as without clocks.
    let last = [
        "x",
        "sum",
        "sum_before",
        "times",
        "kinds",
        "intervals",
        "der(x)",
        "below",
    ];
    assert!(
        last.map(|name| reference(&three, name)).into_iter().max()
            < Some(reference(&three, "constant"))
    );
}

/// A tunable period counts from the last tick, wherever the clock is ticked.
#[test]
fn a_period_is_tuned() {
    for way in [Way::Steps2, Way::Steps3] {
        let mut fmu = Fmu::<Ticking>::new(way);
        fmu.run_to(0.3, |fmu, t| {
            if (t - 0.1).abs() < 1e-9 {
                assert_eq!(fmu.set("tunable_period", 0.06), 0);
            }
        });
        let times: Vec<_> = (fmu.ticks().iter().filter(|tick| tick[1] == 4.0))
            .map(|tick| tick[0])
            .collect();
        // At 0 with 0.25 s; from 0.1 s on 0.06 s after 0, that is at once, and every 0.06 s.
        let expected = [0.0, 0.1, 0.16, 0.22, 0.28];
        assert_eq!(times.len(), expected.len(), "{way:?}: {times:?}");
        for (found, exact) in times.iter().zip(expected) {
            assert!((found - exact).abs() < 1e-9, "{way:?}: {times:?}");
        }
    }
}

/// The importer's period of a fixed clock is its own until the initialization ends.
#[test]
fn an_interval_is_set_before_the_start_alone() {
    #[rustfmt::skip]
    unsafe extern "C-unwind" {
        fn fmi3SetIntervalDecimal(c: C, vr: *const u32, n: usize, intervals: *const f64) -> c_int;
        fn fmi3GetIntervalDecimal(c: C, vr: *const u32, n: usize, intervals: *mut f64, qualifiers: *mut c_int) -> c_int;
    }
    let fmu = Instance::new::<Ticking>(Way::Events3, false);
    let vr = reference(&Way::Events3.description::<Ticking>(), "fixed");
    let set = |interval: f64| unsafe { fmi3SetIntervalDecimal(fmu.c, &vr, 1, &interval) };
    let get = || {
        let (mut interval, mut qualifier) = (f64::NAN, 0);
        let status =
            unsafe { fmi3GetIntervalDecimal(fmu.c, &vr, 1, &mut interval, &mut qualifier) };
        assert_eq!(status, 0);
        interval
    };
    fmu.enter_initialization();
    assert_eq!((get(), set(0.4), get()), (0.2, 0, 0.4));
    assert_eq!((set(0.0), get()), (3, 0.4));
    fmu.exit_initialization();
    assert_eq!((set(0.5), get()), (3, 0.4));
}

/// A step that ends at 0 s has the ticks before: no rounding is allowed for that is relative to 0.
#[test]
fn a_step_to_zero_has_its_ticks() {
    unsafe extern "C-unwind" {
        fn fmi3EnterInitializationMode(c: C, _: bool, _: f64, t: f64, _: bool, _: f64) -> c_int;
    }
    let fmu = Instance::new::<Ticking>(Way::Steps3, false);
    let status = unsafe { fmi3EnterInitializationMode(fmu.c, false, 0.0, -0.5, false, 0.0) };
    assert_eq!(status, 0);
    fmu.exit_initialization();
    fmu.step(-0.5, 0.5);
    let xml = Way::Steps3.description::<Ticking>();
    let get = |name| fmu.get::<{ model::MOST }>(reference(&xml, name)).unwrap();
    let all = std::iter::zip(get("times"), get("kinds"));
    let times = Vec::from_iter(all.filter(|(_, kind)| *kind == 1.0).map(|(t, _)| t));
    assert_eq!(times.len(), 5, "{times:?}");
    for (k, t) in times.iter().enumerate() {
        assert!((t + 0.5 - 0.1 * k as f64).abs() < 1e-12, "{times:?}");
    }
}
