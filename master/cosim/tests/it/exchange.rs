//! FMUs for Model Exchange as components, against closed forms. The FMU, `exchange.c`, refuses every
//! call that the standard does not allow.

use std::fs;
use std::path::PathBuf;

use super::exchange_fmu::{
    BALL, BELT, CHATTER, DECAY, DISCARD_RATE, END_EVENT, END_STEP, ENDLESS, ERROR_RATE, Exchange,
    G, NAN_RATE, NAN_STATE, ROD, STEPPED, TICKS, VAN_DER_POL, refused, run,
};
use super::support::{assert_contains, scratch};

/// Oracle: t_0 = √(2 h/g), then flights of 2 v eᵏ/g. Times are sums of these, so rounding is all that
/// a solver of order 5 errs by; the steps of the master change nothing.
#[test]
fn a_ball_bounces_when_it_must() {
    let (h, e) = (1.3, 0.75);
    let mut impact = (2.0 * h / G).sqrt();
    let (mut speed, mut impacts) = (G * impact, vec![]);
    while impact < 3.0 {
        impacts.push(impact);
        speed *= e;
        impact += 2.0 * speed / G;
    }
    for version in [2, 3] {
        let test = format!("exchange-ball-{version}");
        let file = Exchange::new(version, BALL, e, &[h, 0.0]).pack(&test, "a");
        for step in ["0.01", "0.3"] {
            for schedule in ["standard", "gauss-seidel"] {
                let until = ["--step", step, "--stop-time", "3", "--schedule", schedule];
                let done = run(&test, &[&[&*file][..], &until].concat());
                assert_eq!(done.last("a.count") as usize, impacts.len());
                let found = done.columns["a.last"].iter().filter(|t| **t > 0.0);
                for t in found {
                    let error = impacts.iter().map(|i| (i - t).abs()).fold(1.0, f64::min);
                    assert!(error < 1e-9, "{t}: {error:e}");
                }
            }
        }
    }
}

/// Oracle: sticks for 2.5 p, slips for π − atan2(p/4, 0.1), both s, after it stuck for 3.75 p.
#[test]
fn a_block_sticks_and_slips() {
    let p = 0.43_f64;
    let slip = std::f64::consts::PI - (p / 4.0).atan2(0.1);
    for version in [2, 3] {
        let test = format!("exchange-belt-{version}");
        let file = Exchange::new(version, BELT, p, &[0.0, 0.1]).pack(&test, "a");
        let until = ["--step", "0.05", "--stop-time", "20", "--tolerance", "1e-9"];
        let done = run(&test, &[&[&*file][..], &until].concat());
        let mut changes = vec![3.75 * p];
        while *changes.last().unwrap() < 20.0 {
            let next = if changes.len() % 2 == 1 {
                slip
            } else {
                2.5 * p
            };
            changes.push(changes.last().unwrap() + next);
        }
        changes.pop();
        assert_eq!(done.last("a.count") as usize, changes.len());
        // The tolerance over the slope of the speed where it sticks again, p/2, and the sum of all.
        let error = (done.last("a.last") - changes.last().unwrap()).abs();
        assert!(error < 1e-7, "{error:e}");
    }
}

/// Oracle: Hairer and Wanner's reference solution of VDPOL (ε = 10⁻⁶ at t = 2), scaled.
#[test]
fn a_stiff_oscillator_is_found_stiff() {
    let directional = [
        r#"providesDirectionalDerivative="true""#,
        r#"providesDirectionalDerivatives="true""#,
    ];
    for (version, flags) in [(2, ""), (2, directional[0]), (3, directional[1])] {
        let test = format!("exchange-stiff-{version}-{}", flags.len());
        let mut fmu = Exchange::new(version, VAN_DER_POL, 1000.0, &[2.0, 0.0]);
        fmu.flags = flags;
        let file = fmu.pack(&test, "a");
        let until = ["--step", "2", "--stop-time", "2000", "--tolerance", "1e-7"];
        let done = run(&test, &[&[&*file][..], &until].concat());
        let error = (done.last("a.y") - 1.706_167_732_170_488_3).abs();
        assert!(error < 1e-5, "{error:e}");
        assert_contains(&done.text, &["stiff from t = "]);
        assert!(done.number("right-hand sides") < 60_000, "{}", done.text);
    }
}

/// Oracle: the first mode of the chain decays with 4 (n + 1)² sin²(π / 2(n + 1)). Its Jacobian is
/// banded, and FMI 2.0 says so.
#[test]
fn a_rod_of_a_thousand_cells_cools() {
    let n = 1000;
    let angle = std::f64::consts::PI / (n as f64 + 1.0);
    let x: Vec<f64> = (1..=n).map(|i| (f64::from(i) * angle).sin()).collect();
    let rate = 4.0 * (n as f64 + 1.0).powi(2) * (0.5 * angle).sin().powi(2);
    let file = Exchange::new(2, ROD, 0.0, &x).pack("exchange-rod", "a");
    let until = [
        "--step",
        "0.01",
        "--stop-time",
        "0.2",
        "--signals",
        "a.x[500]",
    ];
    let done = run("exchange-rod", &[&[&*file][..], &until].concat());
    let expected = x[499] * (-rate * 0.2).exp();
    let error = (done.last("a.x[500]") - expected).abs();
    assert!(error < 1e-5, "{error:e}");
    assert!(done.number("right-hand sides") < 3000, "{}", done.text);
}

/// Events at 0.1 s, then every 0.25 s, at which the state begins at 0 again.
#[test]
fn time_events_set_states_anew() {
    for version in [2, 3] {
        let test = format!("exchange-ticks-{version}");
        let file = Exchange::new(version, TICKS, 3.0, &[5.0, 0.0]).pack(&test, "a");
        let until = ["--step", "0.07", "--stop-time", "1.33"];
        let done = run(&test, &[&[&*file][..], &until].concat());
        for (t, y) in done.columns["time"].iter().zip(&done.columns["a.y"]) {
            let since = if *t < 0.1 { *t } else { (t - 0.1) % 0.25 };
            let start = if *t < 0.1 { 5.0 } else { 0.0 };
            assert!((y - start - 3.0 * since).abs() < 1e-12, "{t}: {y}");
        }
        assert!((done.last("a.last") - 1.1).abs() < 1e-15);
        assert_eq!(done.number("events"), 5);
    }
}

/// A continuous input that jumps over an indicator, and a discrete one, at communication points.
#[test]
fn inputs_make_events() {
    for version in [2, 3] {
        for schedule in ["standard", "jacobi"] {
            let test = format!("exchange-inputs-{version}-{schedule}");
            let file = Exchange::new(version, STEPPED, 0.0, &[0.0, 0.0]).pack(&test, "a");
            let table = scratch(&test).join("in.csv");
            fs::write(&table, "time,a.u,a.n\n0,0,0\n0.3,1,7\n0.6,0,7\n1,0,8\n").unwrap();
            let table = table.display().to_string();
            let done = run(
                &test,
                &[
                    &file,
                    "--step",
                    "0.1",
                    "--stop-time",
                    "1",
                    "--schedule",
                    schedule,
                    "--input",
                    &table,
                ],
            );
            let x = done.last("a.y") - done.columns["time"].last().unwrap() * 0.0;
            // Between its rows a table is a line: u passes 0.5 at 0.15 s and 0.45 s, at points.
            assert!((0.25..0.45).contains(&x), "{x}");
            assert_eq!(done.last("a.count"), 2.0);
            let seen = &done.columns["a.seen"];
            assert_eq!(seen[seen.len() - 2], 7.0, "{seen:?}");
        }
    }
}

/// x' = u − x with u = 0: nothing changes, so the steps of the master cost nothing.
#[test]
fn short_communication_steps_cost_no_evaluations() {
    let test = "exchange-free";
    let file = Exchange::new(2, DECAY, 0.0, &[1.0, 1.0]).pack(test, "a");
    let work = |step| {
        let done = run(test, &[&file, "--step", step, "--stop-time", "1"]);
        // Ten times the tolerance, which a step may err by.
        assert!((done.last("a.y") - (-1.0_f64).exp()).abs() < 1e-5);
        done.number("right-hand sides")
    };
    let (few, many) = (work("0.1"), work("0.0001"));
    assert!(many < 20 * few && many < 4000, "{few} {many}");
    let mut fmu = Exchange::new(3, DECAY, 0.0, &[1.0, 1.0]);
    fmu.flags = r#"needsCompletedIntegratorStep="false""#;
    let file = fmu.pack(test, "b");
    run(test, &[&file, "--step", "0.1", "--stop-time", "1"]);
}

#[test]
fn a_model_may_end_the_run() {
    for version in [2, 3] {
        for (kind, fault, time) in [(DECAY, END_STEP, 0.36), (TICKS, END_EVENT, 0.35)] {
            let test = format!("exchange-end-{version}-{kind}");
            let mut fmu = Exchange::new(version, kind, 1.0, &[1.0, 1.0]);
            fmu.fault = fault;
            let file = fmu.pack(&test, "a");
            let done = run(&test, &[&file, "--step", "0.04", "--stop-time", "1"]);
            assert_contains(&done.text, &["asks to end the simulation at t = 0.3"]);
            assert!((done.last("time") - time).abs() < 1e-12, "{}", done.text);
        }
    }
}

#[test]
fn what_does_not_end_is_named() {
    for version in [2, 3] {
        let test = format!("exchange-endless-{version}");
        let ball = Exchange::new(version, BALL, 0.5, &[1.0, 0.0]).pack(&test, "a");
        // t_0 (1 + 2 e / (1 − e)) = 3 t_0.
        refused(&test, &[&ball, "--stop-time", "3"], &["Zeno", "1.354"]);
        let file = Exchange::new(version, CHATTER, 0.0, &[0.5, 0.0]).pack(&test, "b");
        refused(
            &test,
            &[&file, "--stop-time", "3"],
            &["chattering at t = 0.5"],
        );
        let fault = |kind, fault| {
            let mut fmu = Exchange::new(version, kind, 0.9, &[1.0, 0.0]);
            fmu.fault = fault;
            fmu.pack(&test, "c")
        };
        let rates = ["fmi2GetDerivatives", "fmi3GetContinuousStateDerivatives"];
        let rates = rates[version as usize - 2];
        for (kind, number, parts) in [
            (DECAY, ERROR_RATE, &["c", rates, "Error"][..]),
            (DECAY, DISCARD_RATE, &["c", rates, "Discard"]),
            (DECAY, NAN_RATE, &["derivative of `x[1]` is NaN at t = 0.3"]),
            (
                BALL,
                ENDLESS,
                &["still change after 100 passes", "t = 0.4515"],
            ),
            (
                BALL,
                NAN_STATE,
                &["state `x[1]` is NaN after the event at t = 0.4515"],
            ),
        ] {
            let file = fault(kind, number);
            refused(&test, &[&file, "--stop-time", "3", "--step", "0.1"], parts);
        }
    }
    let test = "exchange-lacking";
    let mut fmu = Exchange::new(2, DECAY, 0.0, &[1.0, 0.0]);
    fmu.defines = &["-DLACKS_RATES"];
    let file = fmu.pack(test, "a");
    refused(
        test,
        &[&file],
        &["its library does not export fmi2GetDerivatives"],
    );
}

/// The run goes on from a snapshot bit for bit, whatever the integrator is in the middle of; two
/// threads give the same bits, and steps that are repeated change nothing.
#[test]
fn states_are_saved_with_the_integrator() {
    for version in [2, 3] {
        for (kind, p) in [
            (BALL, 0.8),
            (VAN_DER_POL, 200.0),
            (TICKS, 3.0),
            (DECAY, 0.0),
        ] {
            let test = format!("exchange-saved-{version}-{kind}");
            let fmu = Exchange::new(version, kind, p, &[1.2, 0.1]);
            let [a, b] = ["a", "b"].map(|name| fmu.pack(&test, name));
            let snapshot = scratch(&test).join("saved").display().to_string();
            let system = [
                &*a,
                &b,
                "--connect",
                "a.t=b.u",
                "--step",
                "0.013",
                "--stop-time",
                "2",
            ];
            let plain = run(&test, &system);
            let save = format!("0.77={snapshot}");
            let saved = run(&test, &[&system[..], &["--snapshot", &save]].concat());
            let resumed = run(&test, &[&system[..], &["--resume", &snapshot]].concat());
            let threaded = run(&test, &[&system[..], &["--threads", "2"]].concat());
            for (name, column) in &plain.columns {
                let rest = &column[column.len() - resumed.columns[name].len()..];
                assert_eq!(rest, resumed.columns[name], "{name}");
                for other in [&saved, &threaded] {
                    assert_eq!(*column, other.columns[name], "{name}");
                }
            }
            // Each step is made three times, from saved states, and its lengths are chosen.
            let limits = ["--doubling-tolerance", "1e-3", "--step-limits", "1e-3,0.05"];
            let limits = [&limits[..], &["--schedule", "jacobi"]].concat();
            let chosen = run(&test, &[&system[..], &limits].concat());
            let difference = chosen.last("a.y") - plain.last("a.y");
            assert!(difference.abs() < 1e-5, "{difference:e}");
            assert_eq!(resumed.number("steps"), plain.number("steps"));
        }
    }
}

/// The error at 1 s of x' = u − x, where u = t through another component, falls with the step of the
/// master as `--between` says: 1 held and at the end, 2 extrapolated and interpolated.
#[test]
fn the_order_over_the_communication_step_is_that_of_between() {
    let test = "exchange-order";
    let fmu = Exchange::new(2, DECAY, 0.0, &[0.5, 0.0]);
    let [a, b] = ["a", "b"].map(|name| fmu.pack(test, name));
    // x_a = e^-t / 2, u_b = x_a: x_b = (1 + t) e^-t / 2.
    let exact = (-1.0_f64).exp();
    let ratio = |option: &str, way: &str| {
        let error = |step: &str| {
            let system = [&a, &b, "--connect", "a.y=b.u", "--signals", "b.x[1]"];
            let accurate = ["--step", step, "--stop-time", "1", "--tolerance", "1e-11"];
            let done = run(test, &[&system[..], &accurate, &[option, way]].concat());
            (done.last("b.x[1]") - exact).abs()
        };
        error("0.02") / error("0.01")
    };
    for (between, order) in [
        ("held", 1),
        ("end", 1),
        ("extrapolated", 2),
        ("interpolated", 2),
    ] {
        let (ratio, expected) = (ratio("--between", between), f64::from(1 << order));
        assert!((ratio / expected - 1.0).abs() < 0.1, "{between}: {ratio}");
    }
    assert!((ratio("--schedule", "jacobi") - 2.0).abs() < 0.1);
}

#[test]
fn the_interface_is_chosen_or_refused() {
    let test = "exchange-choice";
    let a = Exchange::new(2, DECAY, 0.0, &[1.0, 1.0]).pack(test, "a");
    let b = PathBuf::from(&a).with_file_name("b.fmu");
    fs::copy(&a, &b).unwrap();
    let b = b.display().to_string();
    for chosen in [
        &["--interface", "me"][..],
        &["--interface", "a=me"],
        &["--interface", "*=me"],
    ] {
        run(test, &[&[&*a, "--stop-time", "0.1"][..], chosen].concat());
    }
    let cs = "a: model `exchange` offers Model Exchange only, no Co-Simulation";
    for (files, chosen, parts) in [
        (&[&*a][..], "cs", &["cannot be loaded", &cs[3..]][..]),
        (
            &[&*a],
            "c=me",
            &["--interface c=me: the system has no component of this name"],
        ),
        (
            &[&*a],
            "a=se",
            &["--interface a=se: `se` must be me (Model Exchange) or cs"],
        ),
        (
            &[&*a, &b],
            "me",
            &["there are 2 components: say COMPONENT=me"],
        ),
    ] {
        refused(test, &[files, &["--interface", chosen]].concat(), parts);
    }
}
