//! What is done to values on their way: faults of wires, noise, events of a scenario.

use std::fs;
use std::sync::Arc;

use cosim::exchange::faults::Faults;
use cosim::io::input_table::{Column, Table};
use cosim::io::scenario;
use cosim::master::Schedule;
use cosim::run::recording::Recording;
use cosim::run::simulate::{self, Experiment};
use cosim::structure::system::System;

use super::inputs::spring;
use super::support::{link, oscillator, scratch, settings, ssd, stepping, system};

const SCHEDULES: [Schedule; 4] = [
    Schedule::Standard,
    Schedule::GaussSeidel,
    Schedule::Jacobi,
    Schedule::JacobiDerivatives,
];

fn faults(system: &System, texts: &[&str], seed: u64) -> anyhow::Result<Faults> {
    let mut faults = Faults {
        seed,
        ..Faults::default()
    };
    texts.iter().try_for_each(|text| faults.add(system, text))?;
    Ok(faults)
}

fn experiment(system: &System, step: f64, schedule: Schedule, faults: Faults) -> Experiment {
    Experiment {
        settings: settings(system, &["spring.k=1"]).unwrap(),
        faults,
        ..Experiment::new(stepping(step, schedule))
    }
}

fn record(
    system: &System,
    experiment: &Experiment,
    stop: f64,
    name: &str,
) -> anyhow::Result<Vec<f64>> {
    let port = system.port(name)?;
    let mut recording = Recording::new(system, &[port])?;
    let master = experiment.start(system)?;
    simulate::run(system, master, stop, &|_, _| (), |master| {
        recording.add(master)
    })?;
    Ok(recording.column(port)?.to_vec())
}

/// x = 1 m at 0.5 s and 5 m at 1.5 s.
fn rising() -> Option<Arc<Table>> {
    Some(Arc::new(Table {
        times: vec![0.5, 1.5],
        columns: vec![Column {
            name: "spring.x".into(),
            unit: None,
            values: vec![1.0, 5.0],
        }],
    }))
}

/// x is 1, 2, 3, 4, 5 at 0.5 s, 0.75 s and so on; F = −x of what arrives.
#[test]
fn each_effect_does_what_it_says_from_and_until_its_times() {
    let system = spring("effects");
    let run = |texts: &[&str]| -> anyhow::Result<Vec<f64>> {
        let experiment = Experiment {
            threads: 1,
            inputs: rising(),
            ..experiment(&system, 0.25, Schedule::Jacobi, faults(&system, texts, 1)?)
        };
        let force = record(&system, &experiment, 1.5, "spring.F")?;
        Ok(force.into_iter().map(|f| -f).collect())
    };
    for (texts, expected) in [
        (&[][..], [1.0, 2.0, 3.0, 4.0, 5.0]),
        (&["spring.x=bias:0.5@1..1.5"], [1.0, 2.0, 3.5, 4.5, 5.0]),
        (&["spring.x=gain:-2@1"], [1.0, 2.0, -6.0, -8.0, -10.0]),
        (&["spring.x=override:7@0.75..1"], [1.0, 7.0, 3.0, 4.0, 5.0]),
        (&["x=freeze@0.75..1.25"], [1.0, 2.0, 2.0, 4.0, 5.0]),
        (&["spring.x=freeze"], [1.0; 5]),
        (&["spring.x=delay:0.5"], [1.0, 1.0, 1.0, 2.0, 3.0]),
        (&["spring.x=delay:0.25@1.25"], [1.0, 2.0, 3.0, 3.0, 4.0]),
        (&["spring.x=drop:1@1..1.5"], [1.0, 2.0, 2.0, 2.0, 5.0]),
        (&["spring.x=drop:0"], [1.0, 2.0, 3.0, 4.0, 5.0]),
        (
            &["spring.x=bias:1", "spring.x=gain:2"],
            [4.0, 6.0, 8.0, 10.0, 12.0],
        ),
        (
            &["spring.x=gain:2", "spring.x=bias:1"],
            [3.0, 5.0, 7.0, 9.0, 11.0],
        ),
        (
            &["spring.x=delay:0.25", "spring.x=freeze@1"],
            [1.0, 1.0, 2.0, 2.0, 2.0],
        ),
    ] {
        assert_eq!(run(texts).unwrap(), expected, "{texts:?}");
    }
    let dropped = run(&["spring.x=drop:0.5"]).unwrap();
    assert_eq!(dropped, run(&["spring.x=drop:0.5"]).unwrap());
    for (text, part) in [
        ("spring.x", "it must be WIRE=EFFECT"),
        (
            "spring.x=wobble:1",
            "`wobble` is nothing that can be done to a value; it must be bias:NUMBER",
        ),
        (
            "spring.x=bias:soft",
            "bias of `spring.x`: `soft` is not a finite number",
        ),
        (
            "spring.x=noise:-1",
            "noise of `spring.x`: `-1` is not a standard deviation",
        ),
        ("spring.x=drop:2", "`2` is not a probability from 0 to 1"),
        ("spring.x=freeze:2", "it takes no number"),
        (
            "spring.x=bias:1@2..1",
            "it begins at 2 s and must end later than that, not at 1 s",
        ),
        ("spring.x=bias:1@soon", "`soon` is no time in s"),
        (
            "spring.x=delay:0.3",
            "the delay of 0.3 s of `spring.x` must be a multiple of the communication step, 0.25 s",
        ),
        (
            "spring.off=gain:2",
            "gain of `spring.off`, which is of type Boolean: this is for Reals",
        ),
        (
            "spring.stage=bias:0.5",
            "bias of `spring.stage`: `0.5` is not a whole number",
        ),
        (
            "spring.off=override:2",
            "override of `spring.off`: `2` is not true (1) or false (0)",
        ),
        (
            "spring.x_dot=bias:1",
            "no connection and no input file gives `spring.x_dot` a value",
        ),
        ("spring.F=bias:1", "no connection passes on `spring.F`"),
        ("spring.y=bias:1", "`spring.y`"),
    ] {
        let error = format!("{:#}", run(&[text]).unwrap_err());
        assert!(error.contains(part), "{text}: {error}");
    }
}

/// Until the fault begins the run is the same bit for bit; then no force reaches the mass, neither
/// at communication points nor as the mean of a step: it moves at the speed it has.
#[test]
fn a_wire_that_is_cut_is_cut_in_every_schedule() {
    let system = system("cut", &oscillator()).unwrap();
    for schedule in SCHEDULES {
        let plain = experiment(&system, 0.125, schedule, Faults::default());
        let cut = faults(&system, &["mass.f=override:0@1.5"], 0).unwrap();
        let cut = experiment(&system, 0.125, schedule, cut);
        let speeds = |e: &Experiment| record(&system, e, 2.5, "mass.x_dot").unwrap();
        let (plain, cut) = (speeds(&plain), speeds(&cut));
        assert_eq!(plain[..=8], cut[..=8], "{schedule:?}: to 1.5 s");
        assert!(
            cut[9..].iter().all(|v| *v == cut[8]),
            "{schedule:?}: {cut:?}"
        );
        assert!(plain[9] != plain[8], "{schedule:?}");
    }
}

/// At an output the fault is in its unit and on all its wires; at an input behind what the
/// connection does.
#[test]
fn an_output_is_altered_before_its_connections_and_an_input_behind_its_own() {
    let doubled = link(
        ("mass", "x"),
        ("spring", "x"),
        "<ssc:LinearTransformation factor=\"2\"/>",
    ) + &link(("mass", "x"), ("spring", "x_dot"), "").replace(
        "<ssd:Connection ",
        "<ssd:Connection suppressUnitConversion=\"true\" ",
    );
    let system = system("ends", &ssd(&doubled)).unwrap();
    let run = |text: &str| {
        let faults = faults(&system, &[text], 3).unwrap();
        let experiment = experiment(&system, 0.25, Schedule::Jacobi, faults);
        ["spring.x", "spring.x_dot"].map(|name| record(&system, &experiment, 1.0, name).unwrap()[1])
    };
    assert_eq!(run("mass.x=bias:0.5"), [3.0, 1.5]);
    assert_eq!(run("spring.x=bias:0.5"), [2.5, 1.0]);
    let [x, x_dot] = run("mass.x=noise:0.1");
    assert!(
        x != 2.0 && (x - 2.0 * x_dot).abs() < 1e-15,
        "one number for both wires"
    );
}

/// The mass moves only by the forces of steps made: at the start it is where it was, the force is
/// not. An input file, for which values are passed once more at each communication point, changes
/// nothing.
#[test]
fn noise_reaches_the_input_it_is_meant_for_and_repeats_with_its_seed() {
    let system = system("noise", &oscillator()).unwrap();
    let run = |texts: &[&str], seed: u64, name: &str| {
        let faults = faults(&system, texts, seed).unwrap();
        let experiment = experiment(&system, 0.01, Schedule::GaussSeidel, faults);
        record(&system, &experiment, 0.6, name).unwrap()
    };
    let (clean, x) = (run(&[], 0, "spring.F"), run(&[], 0, "mass.x"));
    let noisy = run(&["spring.x=noise:0.01"], 5, "spring.F");
    assert_eq!((clean.len(), noisy.len()), (11, 11));
    assert_eq!(run(&["spring.x=noise:0.01"], 5, "mass.x")[0], x[0]);
    let difference = (noisy[0] - clean[0]).abs();
    assert!(
        0.0 < difference && difference < 0.06,
        "k times some deviations: {difference}"
    );
    assert_eq!(run(&["spring.x=noise:0.01"], 5, "spring.F"), noisy);
    assert_ne!(run(&["spring.x=noise:0.01"], 6, "spring.F"), noisy);
    assert_eq!(run(&["spring.x=noise:0"], 5, "spring.F"), clean);
    let mut fed = experiment(
        &system,
        0.01,
        Schedule::GaussSeidel,
        faults(&system, &["spring.x=noise:0.01"], 5).unwrap(),
    );
    fed.inputs = Some(Arc::new(Table {
        times: vec![0.0],
        columns: vec![Column {
            name: "spring.stage".into(),
            unit: None,
            values: vec![0.0],
        }],
    }));
    assert_eq!(record(&system, &fed, 0.6, "spring.F").unwrap(), noisy);
}

/// Mean and deviation of n draws: within 4 of their own standard errors, σ/√n and σ/√(2n).
#[test]
fn the_noise_has_the_deviation_asked_for() {
    let system = spring("deviation");
    let mut experiment = experiment(
        &system,
        1.0,
        Schedule::Jacobi,
        faults(&system, &["spring.x=noise:0.25"], 7).unwrap(),
    );
    experiment.inputs = rising();
    let force = record(&system, &experiment, 20_000.5, "spring.F").unwrap();
    let draws: Vec<f64> = force[1..].iter().map(|f| -f - 5.0).collect();
    let (n, sigma) = (20_000.0, 0.25);
    let mean = draws.iter().sum::<f64>() / n;
    let spread = (draws.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    assert!(mean.abs() < 4.0 * sigma / n.sqrt(), "{mean}");
    assert!(
        (spread - sigma).abs() < 4.0 * sigma / (2.0 * n).sqrt(),
        "{spread}"
    );
}

/// Times count from the start of the run, 0.5 s. A ramp begins at what the input has; what is reset
/// has the value that it would have without the scenario.
#[test]
fn a_scenario_alters_inputs_and_outputs_at_its_times() {
    let file = |name: &str, text: &str| {
        let file = scratch(name);
        fs::write(&file, text).unwrap();
        file
    };
    let system = spring("scenario");
    let play = |system: &System, text: &str, name: &str| {
        let mut experiment = experiment(system, 0.25, Schedule::Jacobi, Faults::default());
        let file = file("scenario.json", text);
        let said =
            scenario::add(&file, system, experiment.stepping, &mut experiment.faults).unwrap();
        (record(system, &experiment, 2.5, name).unwrap(), said)
    };
    let moved = r#"{"defaults": {"model": "spring", "variable": "x", "action": "override"}, "events": [
        {"time": 0.5, "action": "ramp", "value": 4, "duration": 0.5}, {"time": 0.2, "value": 2},
        {"time": 1.25, "action": "reset"}, {"time": 1.5, "action": "bias", "value": "1"}], "end": 1.75}"#;
    let (x, said) = play(&system, moved, "spring.x");
    assert_eq!(x, [0.0, 2.0, 2.0, 3.0, 4.0, 0.0, 1.0, 0.0, 0.0]);
    assert!(
        said.ends_with("4 events; what it alters ends at t = 2.25 s"),
        "{said}"
    );
    let discrete = r#"{"events": [{"time": 0, "model": "spring", "variable": "stage", "action": "bias", "value": 3},
        {"time": 1, "model": "spring", "variable": "off", "action": "override", "value": true}]}"#;
    let (stage, said) = play(&system, discrete, "spring.stage");
    assert_eq!(stage[..6], [3.0, 3.0, 3.0, 3.0, 3.0, 0.0]);
    assert!(said.contains("because it has no `end`"), "{said}");
    assert_eq!(
        play(&system, discrete, "spring.off").0[..6],
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    );
    let whole = super::support::system("played", &oscillator()).unwrap();
    let output = r#"{"events": [{"time": 0.25, "model": "mass", "variable": "x", "action": "override", "value": 9}], "end": 0.75}"#;
    assert_eq!(play(&whole, output, "spring.x").0[1..3], [9.0, 9.0]);
    assert_ne!(play(&whole, output, "spring.x").0[3], 9.0);
}
