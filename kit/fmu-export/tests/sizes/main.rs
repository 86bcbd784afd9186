//! Arrays of any length, sizes that are parameters, matrices, arrays of structs: through the C
//! border, and in the model descriptions.
#![allow(missing_docs, non_snake_case, clippy::undocumented_unsafe_blocks)]

mod client;
mod rod;

use client::*;
use fmu_export::{check, model_description, model_description3};
use rod::Rod;
use std::f64::consts::PI;
use std::thread;

#[test]
fn the_table_agrees_with_the_model() {
    assert_eq!(check::<Rod>(), [""; 0]);
}

/// The temperatures of a rod whose mode `k` is excited, at time t. Oracle: the mode is an
/// eigenvector of the exchange, with the eigenvalue −4 rate sin²(kπ/2n).
fn mode(n: usize, k: usize, t: f64) -> Vec<f64> {
    let angle = k as f64 * PI / n as f64;
    let decay = (-4.0 * 0.25 * (0.5 * angle).sin().powi(2) * t).exp();
    let cell = |i| 300.0 + 8.0 * decay * (angle * (i as f64 + 0.5)).cos() + 0.125 * t;
    (0..n).map(cell).collect()
}

/// Sets, initializes, steps, saves, restores and resets a rod of `n` cells.
fn lives(n: usize) {
    let fmu = Rod3::sized(n as u64);
    fmu.ok(fmu.set(vr::T_0, &mode(n, n / 2, 0.0)));
    fmu.ok(fmu.set(vr::HEATING, &vec![0.125; n]));
    fmu.start();
    assert_eq!(fmu.get(vr::T, n), mode(n, n / 2, 0.0));
    fmu.step(0.0, 0.5);
    // The fourth-order method with steps of h = 0.1 s misses e^z, z = −0.5 h, by z⁵/120 = 2.6e-9 a
    // step; five steps of an amplitude of 8. Rounding: some 40 ε of 310 K.
    let tolerance = 5.0 * 8.0 * 2.7e-9 + 40.0 * 310.0 * f64::EPSILON;
    let found = fmu.get(vr::T, n);
    for (T, exact) in found.iter().zip(mode(n, n / 2, 0.5)) {
        assert!((T - exact).abs() < tolerance, "{T} {exact}");
    }
    let state = fmu.save();
    let bytes = fmu.bytes(state);
    fmu.step(0.5, 0.5);
    let later = fmu.get(vr::T, n);
    assert_ne!(found, later);
    for state in [state, fmu.state(&bytes)] {
        fmu.restore(state);
        assert_eq!(fmu.get(vr::T, n), found);
        assert_eq!(fmu.get(vr::HEATING, n), vec![0.125; n]);
        fmu.step(0.5, 0.5);
        assert_eq!(fmu.get(vr::T, n), later);
    }
    fmu.ok(unsafe { fmi3Reset(fmu.c) });
    assert_eq!(fmu.size(vr::N), 5);
    fmu.restore(state);
    assert_eq!((fmu.size(vr::N), fmu.get(vr::T, n)), (n as u64, found));
}

#[test]
fn rods_of_any_length_live_in_a_small_stack() {
    for n in [1, 32, 5000, 100_000] {
        let small = thread::Builder::new().stack_size(512 << 10);
        small.spawn(move || lives(n)).unwrap().join().unwrap();
    }
}

#[test]
fn sizes_are_set_in_configuration_mode_only() {
    let fmu = Rod3::new();
    assert_eq!((fmu.size(vr::N), fmu.size(vr::M)), (5, 2));
    assert_eq!(fmu.set_size(vr::N, 7), Status::Error);
    assert_eq!(
        fmu.said(),
        "fmi3SetUInt64: `n` = 7: an UInt64 structural parameter can only be set in Configuration Mode"
    );
    fmu.ok(fmu.set(vr::T_0, &[290.0; 5]));
    fmu.ok(fmu.set(vr::MATRIX, &[7.0; 6]));
    fmu.ok(unsafe { fmi3EnterConfigurationMode(fmu.c) });
    for (wrong, value) in [
        (0, "0"),
        (200_001, "200001"),
        (u64::MAX, "18446744073709551615"),
    ] {
        assert_eq!(fmu.set_size(vr::N, wrong), Status::Discard);
        let text = format!("fmi3SetUInt64: `n` = {value} must be from 1 to 200000");
        assert_eq!(fmu.said(), text);
    }
    assert_eq!(fmu.set(vr::T_0, &[1.0; 5]), Status::Error);
    fmu.ok(fmu.set_size(vr::M, 4));
    fmu.ok(fmu.set_size(vr::N, 7));
    fmu.ok(unsafe { fmi3ExitConfigurationMode(fmu.c) });
    // What is longer now has its start values; what is not, what was set.
    assert_eq!(
        fmu.get(vr::T_0, 7),
        [280.0, 281.0, 282.0, 283.0, 284.0, 285.0, 286.0]
    );
    assert_eq!(fmu.get(vr::WEIGHTS, 12)[11], 11.25);
    assert_eq!(fmu.get(vr::MATRIX, 6), [7.0; 6]);
    let too_few =
        "fmi3SetFloat64: nValues = 5 is less than the number of elements of these variables";
    assert_eq!(
        (fmu.set(vr::T_0, &[1.0; 5]), fmu.said().as_str()),
        (Status::Error, too_few)
    );
    fmu.start();
    assert_eq!(fmu.get(vr::SHOWN, 4).len(), 4);
    assert_eq!(unsafe { fmi3EnterConfigurationMode(fmu.c) }, Status::Error);
    assert!(
        fmu.said()
            .contains("sizes can only be set before initialization"),
        "{}",
        fmu.said()
    );
}

/// A size that is not set keeps the values that were set before, also through another one's change.
#[test]
fn a_size_keeps_what_is_not_of_it() {
    let fmu = Rod3::new();
    fmu.ok(fmu.set(vr::WEIGHTS, &[2.0; 6]));
    fmu.ok(fmu.set(vr::TABLE, &[0.5; 1000]));
    fmu.ok(unsafe { fmi3EnterConfigurationMode(fmu.c) });
    fmu.ok(fmu.set_size(vr::N, 3));
    fmu.ok(fmu.set_size(vr::M, 2));
    fmu.ok(unsafe { fmi3ExitConfigurationMode(fmu.c) });
    assert_eq!(
        (fmu.get(vr::WEIGHTS, 6), fmu.get(vr::TABLE, 1000)),
        (vec![2.0; 6], vec![0.5; 1000])
    );
    fmu.ok(fmu.set(vr::T_0, &[1.0, 2.0, 4.0]));
    fmu.start();
    assert_eq!(fmu.get(vr::SHOWN, 2), [14.0, 14.0]);
}

#[test]
fn a_wrong_value_in_an_array_is_named_and_nothing_is_set() {
    let fmu = Rod3::sized(1000);
    let mut heating = vec![1.0; 1000];
    heating[776] = 2e3;
    assert_eq!(fmu.set(vr::HEATING, &heating), Status::Discard);
    assert!(
        fmu.said()
            .starts_with("fmi3SetFloat64: `heating[777]` = 2000 must be "),
        "{}",
        fmu.said()
    );
    assert_eq!(fmu.get(vr::HEATING, 1000), vec![0.0; 1000]);
    assert_eq!(fmu.set(vr::T, &[1.0; 1000]), Status::Error);
}

#[test]
fn integers_booleans_and_outputs_are_arrays_too() {
    let fmu = Rod3::new();
    fmu.ok(unsafe { fmi3EnterConfigurationMode(fmu.c) });
    fmu.ok(fmu.set_size(vr::M, 3));
    fmu.ok(unsafe { fmi3ExitConfigurationMode(fmu.c) });
    let (flags, counts) = ([0; 40], [4, -5, 6]);
    fmu.ok(unsafe { fmi3SetBoolean(fmu.c, &vr::FLAGS, 1, flags.as_ptr(), 40) });
    let (mut read_flags, mut read) = ([1; 40], [0; 3]);
    fmu.ok(unsafe { fmi3GetBoolean(fmu.c, &vr::FLAGS, 1, read_flags.as_mut_ptr(), 40) });
    fmu.ok(unsafe { fmi3GetInt32(fmu.c, &vr::COUNTS, 1, read.as_mut_ptr(), 3) });
    assert_eq!((read_flags, read), (flags, [-3; 3]));
    fmu.ok(unsafe { fmi3SetInt32(fmu.c, &vr::COUNTS, 1, counts.as_ptr(), 3) });
    fmu.ok(unsafe { fmi3GetInt32(fmu.c, &vr::COUNTS, 1, read.as_mut_ptr(), 3) });
    assert_eq!(read, counts);
    fmu.start();
    fmu.ok(fmu.set(vr::HEATING, &[1.0, 2.0, 4.0, 8.0, 16.0]));
    fmu.step(0.0, 0.1); // what is set in Step Mode is read after a step
    assert_eq!(fmu.get(vr::PAIRS, 5), [1.0, 3.0, 6.0, 12.0, 24.0]);
}

#[test]
fn a_model_without_output_derivatives_says_so() {
    let fmu = Rod3::new();
    fmu.start();
    let mut found = [f64::NAN; 5];
    let status =
        unsafe { fmi3GetOutputDerivatives(fmu.c, &vr::PAIRS, 1, &1, found.as_mut_ptr(), 5) };
    assert_eq!(status, Status::Error);
    let said = fmu.said();
    assert!(said.contains("no output derivatives"), "{said}");
}

/// Neither the way along the direction nor the way back is open: the sum of what one input does after
/// the other. Oracle: the outputs are sums of two neighbours. Tolerance: rounding of 1000 K/s over
/// steps of ∛ε of that, the nominal value.
#[test]
fn inputs_at_opposite_bounds_have_directional_derivatives() {
    let fmu = Rod3::new();
    fmu.ok(fmu.set(vr::HEATING, &[1e3, -1e3, 0.0, 0.0, 0.0]));
    fmu.start();
    let (seed, mut found) = ([2.0, 5.0, 1.0, 0.0, 0.0], [f64::NAN; 5]);
    fmu.ok(unsafe {
        let (seed, found) = (seed.as_ptr(), found.as_mut_ptr());
        fmi3GetDirectionalDerivative(fmu.c, &vr::PAIRS, 1, &vr::HEATING, 1, seed, 5, found, 5)
    });
    for (found, expected) in found.iter().zip([2.0, 7.0, 6.0, 1.0, 0.0]) {
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    }
}

/// Oracle: the rate of a mode is its eigenvalue times it.
#[test]
fn importers_integrate_rods_of_any_length() {
    let (n, k) = (700, 3);
    let fmu = Rod3::of(true).with(n as u64);
    fmu.ok(fmu.set(vr::T_0, &mode(n, k, 0.0)));
    fmu.start();
    let (mut states, mut rates) = (0, vec![f64::NAN; n]);
    fmu.ok(unsafe { fmi3GetNumberOfContinuousStates(fmu.c, &mut states) });
    fmu.ok(unsafe { fmi3GetContinuousStateDerivatives(fmu.c, rates.as_mut_ptr(), n) });
    assert_eq!((states, &rates), (n, &fmu.get(vr::DER_T, n)));
    let eigenvalue = -(0.5 * k as f64 * PI / n as f64).sin().powi(2);
    for (rate, T) in rates.iter().zip(mode(n, k, 0.0)) {
        // Differences of numbers of 300 K, each rounded.
        assert!(
            (rate - eigenvalue * (T - 300.0)).abs() < 4.0 * 308.0 * f64::EPSILON,
            "{rate}"
        );
    }
}

/// In FMI 2.0 each element has a reference; a batch may take them in any order.
#[test]
fn elements_have_references_in_fmi_2() {
    let fmu = Rod2::new();
    assert_eq!(fmu.set_integer(vr::N, 7), fmu_export::ffi::Status::Error);
    fmu.initialize();
    let cells: Vec<_> = (0..5).map(|i| element(vr::T_0, i)).collect();
    assert_eq!(
        fmu.get(&[element(vr::TABLE, 999), vr::MATRIX + 3, vr::R[1]]),
        [1.5, 4.0, 0.5]
    );
    assert_eq!(
        fmu.set(&cells, &mode(5, 2, 0.0)),
        fmu_export::ffi::Status::Ok
    );
    assert_eq!(
        fmu.set(&[element(vr::TABLE, 999), vr::R[1]], &[2.5, 0.75]),
        fmu_export::ffi::Status::Ok
    );
    assert_eq!(
        fmu.get(&[
            vr::R[0],
            vr::R[1],
            element(vr::TABLE, 998),
            element(vr::TABLE, 999)
        ]),
        [0.5, 0.75, 1.5, 2.5]
    );
    for wrong in [
        vr::T_0,
        element(vr::T_0, 5),
        element(vr::MATRIX, 0),
        element(4094, 0),
        u32::MAX,
    ] {
        assert_eq!(
            fmu.set(&[wrong], &[300.0]),
            fmu_export::ffi::Status::Error,
            "{wrong}"
        );
    }
    fmu.start();
    fmu.step(0.0, 0.5);
    let T: Vec<_> = (0..5).rev().map(|i| element(vr::T, i)).collect();
    let found = fmu.get(&T);
    // The other version gives the same bits.
    let other = Rod3::new();
    other.ok(other.set(vr::T_0, &mode(5, 2, 0.0)));
    other.start();
    other.step(0.0, 0.5);
    assert_eq!(
        other.get(vr::T, 5).into_iter().rev().collect::<Vec<_>>(),
        found
    );
}

#[test]
fn descriptions_have_dimensions_and_names_of_elements() {
    let xml = model_description3::<Rod>().unwrap();
    for part in [
        r#"<UInt64 name="n" valueReference="0" description="Number of cells" causality="structuralParameter" variability="fixed" initial="exact" min="1" max="200000" start="5"/>"#,
        r#"<Dimension valueReference="0"/>"#,
        "<Dimension valueReference=\"1\"/>\n      <Dimension start=\"3\"/>",
        "<Dimension start=\"2\"/>\n      <Dimension start=\"3\"/>",
        r#"<Dimension start="1000"/>"#,
        r#"<Float64 name="motor[2].winding.R" valueReference="54""#,
        r#"start="280.0 281.0 282.0 283.0 284.0""#,
        r#"<Output valueReference="58" dependencies="55 57" dependenciesKind="dependent dependent"/>"#,
        r#"<ContinuousStateDerivative valueReference="60" dependencies="55 57" dependenciesKind="dependent dependent"/>"#,
        r#"<Float64 name="der(T)" valueReference="60""#,
        r#"<InitialUnknown valueReference="57" dependencies="3" dependenciesKind="dependent"/>"#,
    ] {
        assert!(xml.contains(part), "{part} in {xml:.3000}");
    }
    let xml = model_description::<Rod>().unwrap();
    let first = element(vr::WEIGHTS, 0);
    for part in [
        r#"name="n" valueReference="0" description="Number of cells" causality="local" variability="constant" initial="exact""#.to_owned(),
        format!(r#"name="weights[1,1]" valueReference="{first}""#),
        format!(r#"name="weights[2,3]" valueReference="{}""#, first + 5),
        r#"name="matrix[2,1]" valueReference="9""#.to_owned(),
        r#"name="flags[40]" valueReference="51""#.to_owned(),
    ] {
        assert!(xml.contains(&part), "{part}");
    }
    // Each pair depends on its own heating and temperature and on the heating before, the first on none.
    let position = |name: &str| {
        let before = &xml[..xml.find(&format!("name=\"{name}\"")).unwrap()];
        before.matches("<ScalarVariable").count()
    };
    let [pair, heating, T] = ["pairs[1]", "heating[1]", "T[1]"].map(position);
    for (index, dependencies) in [
        (pair, format!("{heating} {T}")),
        (
            pair + 4,
            format!("{} {} {}", heating + 3, heating + 4, T + 4),
        ),
    ] {
        let unknown = format!(r#"<Unknown index="{index}" dependencies="{dependencies}"/>"#);
        assert!(xml.contains(&unknown), "{unknown}");
    }
}

/// Longer than what is handed out at once; the last is looked at as the first is, before any is
/// written.
#[test]
fn whole_numbers_are_set_and_read_as_one_array() {
    let n = 1001;
    let fmu = Rod3::sized(n as u64);
    let mut given: Vec<i32> = (0..n).map(|k| (70_000 - 71 * k).max(-5)).collect();
    fmu.ok(fmu.set_whole(vr::SWITCHES, &given));
    let read = || {
        let mut found = vec![0; given.len()];
        fmu.ok(fmu.try_get_whole(vr::SWITCHES, &mut found));
        found
    };
    assert_eq!(read(), given);
    let mut wrong = vec![3; given.len()];
    *wrong.last_mut().unwrap() = -6;
    assert_eq!(fmu.set_whole(vr::SWITCHES, &wrong), Status::Discard);
    let said = fmu.said();
    assert!(said.contains("`switches[1001]` = -6"), "{said}");
    assert_eq!(read(), given);
    given.pop();
    assert_eq!(fmu.set_whole(vr::SWITCHES, &given), Status::Error);
}

/// Times beside those of a memcpy of as many bytes, for a reader: `cargo test --profile fmu-release
/// -p fmu-export --test sizes -- --ignored --nocapture`.
#[test]
#[ignore = "prints times, which depend on what else the machine does"]
fn times_of_arrays() {
    let n = 100_000;
    let fmu = Rod3::sized(n as u64);
    fmu.start();
    let (mut from, mut to) = (vec![0.5; n], vec![0.0; n]);
    let time = |f: &mut dyn FnMut()| {
        let once = |f: &mut dyn FnMut()| {
            let start = std::time::Instant::now();
            f();
            start.elapsed().as_secs_f64() * 1e6
        };
        (0..200).map(|_| once(f)).fold(f64::INFINITY, f64::min)
    };
    let copy = time(&mut || to.copy_from_slice(std::hint::black_box(&from)));
    let say = |what: &str, f: &mut dyn FnMut()| {
        println!("{what}: {:.1} µs, {:.1} of a copy", time(f), time(f) / copy);
    };
    say("set", &mut || {
        from[7] += 1.0; // another array each time
        fmu.ok(fmu.set(vr::HEATING, &from));
    });
    fmu.step(0.0, 0.1);
    let mut whole = vec![5; n];
    say("set whole numbers, half as many bytes", &mut || {
        whole[7] ^= 1;
        fmu.ok(fmu.set_whole(vr::SWITCHES, &whole));
    });
    fmu.step(0.1, 0.1);
    say("get whole numbers", &mut || {
        fmu.ok(fmu.try_get_whole(vr::SWITCHES, &mut whole));
    });
    say("get", &mut || fmu.ok(fmu.try_get(vr::T, &mut to)));
    let mut state = fmu.save();
    say("save", &mut || {
        fmu.ok(unsafe { fmi3GetFMUState(fmu.c, &mut state) })
    });
    say("restore", &mut || fmu.restore(state));
    let bytes = fmu.bytes(state).len();
    println!(
        "a state has {bytes} bytes, {:.1} arrays",
        bytes as f64 / (8 * n) as f64
    );
}
