//! Steps of variable length, steps that are repeated, runs that are resumed from a snapshot.

use std::fs;
use std::path::PathBuf;

use cosim::exchange::faults::Faults;
use cosim::master::{Master, Schedule};
use cosim::run::experiment::Experiment;
use cosim::run::signals::{Signals, matching};
use cosim::run::simulate::{Outcome, Plan, run_plan};
use cosim::stepping::{StepControl, StepLimits};
use cosim::structure::system::System;

use fmi_description::Version;

use super::support::{
    assert_contains, edited, edited_of, oscillator, scratch, settings, stepping, system,
};

const LIMITS: StepLimits = StepLimits {
    length: [1e-5, 5e-2],
    change: [0.2, 1.5],
    safety: 0.99,
    proportional: 0.2,
    integral: 0.15,
};

fn by_energy(tolerance: f64, repeats: bool) -> StepControl {
    StepControl::Energy {
        tolerance,
        scale: 1.0,
        repeats,
        limits: LIMITS,
    }
}

fn by_doubling(tolerance: f64) -> StepControl {
    StepControl::Doubling {
        tolerance,
        limits: LIMITS,
    }
}

/// Time and bits of all outputs at a communication point.
type Row = (f64, Vec<u64>);

/// What a run came to, with its communication points.
fn rows(system: &System, master: Master, plan: &Plan) -> anyhow::Result<(Outcome, Vec<Row>)> {
    let mut signals = Signals::new(system, &matching(system, &["*".into()])?)?;
    let mut rows = Vec::new();
    let mut observer = cosim::run::observer::Function(|master: &Master| {
        let values = signals.read(master)?.iter().map(|x| x.to_bits());
        rows.push((master.time(), values.collect()));
        Ok(())
    });
    let outcome = run_plan(system, master, plan, &|_, _| (), &mut observer)?;
    Ok((outcome, rows))
}

fn plan(control: StepControl) -> Plan {
    Plan {
        control,
        ..Plan::to(2.5)
    }
}

fn started(system: &System, schedule: Schedule, texts: &[&str]) -> Master {
    Master::new(
        system,
        &settings(system, texts).unwrap(),
        stepping(1e-3, schedule),
    )
    .unwrap()
}

/// x = cos(w (t − 0.5)), k = 3, m = 1. Errors fall with the tolerance, and each run takes steps of
/// several lengths within the limits and meets the stop time. A step of length h misses by some h²
/// (order 1, Jacobi), of which there are 2/h: the error is of the size of h, of which the step by
/// doubling is √tolerance; a factor of 3 is left.
#[test]
fn a_smaller_tolerance_gives_a_smaller_error() {
    let system = system("chosen", &oscillator()).unwrap();
    let end = system.port("mass.x").unwrap();
    let exact = (3.0_f64.sqrt() * 2.0).cos();
    for controls in [
        [1e-3, 1e-5].map(|tolerance| by_energy(tolerance, false)),
        [1e-3, 1e-5].map(|tolerance| by_energy(tolerance, true)),
        [1e-3, 1e-5].map(by_doubling),
    ] {
        let errors = controls.map(|control| {
            let master = started(&system, Schedule::Jacobi, &[]);
            let mut last = (0.0, 0.0);
            let mut observer = cosim::run::observer::Function(|master: &Master| {
                last = (master.time(), master.number(end)?);
                Ok(())
            });
            let plan = plan(control);
            let outcome = run_plan(&system, master, &plan, &|_, _| (), &mut observer).unwrap();
            let count = outcome.steps.unwrap();
            let [shortest, longest] = count.lengths.unwrap();
            // Lengths are differences of times: rounded by some 1e-16 s.
            assert!(1e-5 - 1e-15 <= shortest && shortest < longest && longest <= 5e-2 + 1e-15);
            assert!(count.computed >= count.made, "{count:?}");
            assert_eq!(last.0, 2.5);
            (last.1 - exact).abs()
        });
        assert!(errors[1] < 0.3 * errors[0], "{controls:?}: {errors:?}");
        assert!(
            errors[1] < 3.0 * 1e-5_f64.sqrt(),
            "{controls:?}: {errors:?}"
        );
    }
}

/// A system that cannot be stepped so is refused before the run, and says why.
#[test]
fn what_cannot_be_had_is_refused_by_name() {
    let system = system("chosen_refused", &oscillator()).unwrap();
    let refused = |master: Master, control| {
        let error = rows(&system, master, &plan(control)).unwrap_err();
        format!("{error:#}")
    };
    let start = || started(&system, Schedule::Jacobi, &[]);
    assert!(refused(start(), by_energy(0.0, false)).contains("tolerance 0"));
    let mut faults = Faults::default();
    faults.add(&system, "mass.f=delay:0.01").unwrap();
    let experiment = Experiment {
        faults,
        ..Experiment::new(stepping(1e-3, Schedule::Jacobi))
    };
    let delayed = experiment.start(&system).unwrap();
    assert!(refused(delayed, by_doubling(1e-3)).contains("a delay of 0.01 s"));
    let without = |what: &'static str| {
        edited(what, &oscillator(), |_, text| {
            let flag = format!("{what}=\"true\"");
            assert!(text.contains(&flag), "{text}");
            text.replace(&flag, &format!("{what}=\"false\""))
        })
        .unwrap()
    };
    for (what, control, word) in [
        (
            "canGetAndSetFMUstate",
            by_doubling(1e-3),
            "cannot save its state",
        ),
        (
            "canGetAndSetFMUstate",
            StepControl::Repeated,
            "cannot save its state",
        ),
        (
            "canHandleVariableCommunicationStepSize",
            by_energy(1e-3, false),
            "cannot vary its step",
        ),
    ] {
        let system = without(what);
        let master = started(&system, Schedule::Jacobi, &[]);
        let error = format!("{:#}", rows(&system, master, &plan(control)).unwrap_err());
        assert!(error.contains(word), "{error}");
    }
}

/// A run that is interrupted and resumed has the same rows from there on, bit for bit, in every
/// schedule and however its steps are chosen; with what remembers values from point to point.
#[test]
fn a_resumed_run_has_the_same_bits() {
    let system = system("resumed", &oscillator()).unwrap();
    let experiment = |schedule| {
        let mut faults = Faults::default();
        for text in ["spring.x=noise:1e-3", "spring.x_dot=drop:0.3"] {
            faults.add(&system, text).unwrap();
        }
        Experiment {
            settings: settings(&system, &["spring.k=23", "spring.d=0.1"]).unwrap(),
            faults,
            ..Experiment::new(stepping(0.01, schedule))
        }
    };
    let file = scratch("resumed.snapshot");
    for (schedule, control) in [
        (Schedule::Standard, StepControl::Fixed),
        (Schedule::GaussSeidel, StepControl::Fixed),
        (Schedule::Jacobi, StepControl::Repeated),
        (Schedule::JacobiDerivatives, StepControl::Fixed),
        (Schedule::GaussSeidel, by_energy(1e-3, false)),
        (Schedule::Jacobi, by_doubling(1e-3)),
    ] {
        let start = || experiment(schedule).start(&system).unwrap();
        let key = plan(control).key(&system, &experiment(schedule));
        let saving = Plan {
            snapshots: vec![(1.2345, file.clone())],
            key: Some(key.clone()),
            ..plan(control)
        };
        let resuming = Plan {
            resume: Some(file.clone()),
            key: Some(key),
            ..plan(control)
        };
        let (whole, all) = rows(&system, start(), &saving).unwrap();
        let (rest, resumed) = rows(&system, start(), &resuming).unwrap();
        let from = all.iter().position(|(t, _)| *t >= 1.2345).unwrap();
        assert!(from > 10 && all.len() - from > 10);
        assert_eq!(resumed, all[from..], "{schedule:?} {control:?}");
        assert_eq!(rest.residuals, whole.residuals, "{schedule:?} {control:?}");
    }
}

#[test]
fn a_foreign_snapshot_is_refused() {
    let system = system("foreign_snapshot", &oscillator()).unwrap();
    let file = scratch("foreign.snapshot");
    let experiment = |step| Experiment::new(stepping(step, Schedule::Jacobi));
    let run = |step, plan: Plan| {
        let experiment = experiment(step);
        let key = Some(plan.key(&system, &experiment));
        rows(
            &system,
            experiment.start(&system).unwrap(),
            &Plan { key, ..plan },
        )
    };
    let saving = Plan {
        snapshots: vec![(1.0, file.clone())],
        ..Plan::to(1.5)
    };
    run(0.01, saving).unwrap();
    let resumed = |step, file: PathBuf, control| {
        let plan = Plan {
            resume: Some(file),
            ..plan(control)
        };
        format!("{:#}", run(step, plan).unwrap_err())
    };
    let error = resumed(0.02, file.clone(), StepControl::Fixed);
    assert!(
        error.contains("another run: the communication step is 0.01 s"),
        "{error}"
    );
    let error = resumed(0.01, file.clone(), by_doubling(1e-3));
    assert!(error.contains("the choice of steps is Fixed"), "{error}");
    let bytes = fs::read(&file).unwrap();
    for (name, bytes, word) in [
        ("empty", Vec::new(), "not a snapshot"),
        ("short", bytes[..bytes.len() - 1].to_vec(), "checksum"),
        (
            "changed",
            [&bytes[..40], &[bytes[40] ^ 1], &bytes[41..]].concat(),
            "checksum",
        ),
    ] {
        let file = scratch(name);
        fs::write(&file, bytes).unwrap();
        let error = resumed(0.01, file, StepControl::Fixed);
        assert!(error.contains(word), "{name}: {error}");
    }
}

/// The mass ends a step over t = 1.2345 there. All others are brought to there, and the run is that
/// of a master that steps there by hand, bit for bit; without repeating it ends.
#[test]
fn all_are_repeated_to_where_one_stops() {
    repeated_to_where_one_stops(Version::Fmi2);
    // There the step ends early.
    repeated_to_where_one_stops(Version::Fmi3);
}

fn repeated_to_where_one_stops(version: Version) {
    let as_it_is = |_: &str, text: &str| text.to_string();
    let name = format!("stopped_{version:?}");
    let system = edited_of(version, &name, &oscillator(), as_it_is).unwrap();
    let start = |texts: &[&str]| {
        let settings = settings(&system, texts).unwrap();
        Master::new(&system, &settings, stepping(0.01, Schedule::GaussSeidel)).unwrap()
    };
    let pauses = || start(&["mass.pauses_at=1.2345"]);
    let (outcome, all) = rows(&system, pauses(), &plan(StepControl::Repeated)).unwrap();
    let count = outcome.steps.unwrap();
    assert_eq!((count.made, count.computed), (201, 202));
    let mut by_hand = start(&[]);
    let mut signals = Signals::new(&system, &matching(&system, &["*".into()]).unwrap()).unwrap();
    let mut expected = vec![];
    let times = (1..=200).map(|k| 0.5 + f64::from(k) * 0.01);
    let mut times: Vec<f64> = times.chain([1.2345]).collect();
    times.sort_by(f64::total_cmp);
    for time in times {
        by_hand.step_to(time).unwrap();
        let values = signals.read(&by_hand).unwrap().iter().map(|x| x.to_bits());
        expected.push((by_hand.time(), values.collect::<Vec<_>>()));
    }
    assert_eq!(all[1..], expected);
    for control in [by_energy(1e-3, true), by_doubling(1e-3)] {
        let (_, all) = rows(&system, pauses(), &plan(control)).unwrap();
        assert!(all.iter().any(|(time, _)| *time == 1.2345));
    }
    // A component that never makes a whole step.
    let never = start(&["mass.pauses_at=0"]);
    let error = rows(&system, never, &plan(StepControl::Repeated)).unwrap_err();
    assert_contains(
        &format!("{error:#}"),
        &["at t = 0.5 s `mass` stops within the communication step, the last time at 0.5"],
    );
    if version == Version::Fmi3 {
        // Otherwise such a step is continued.
        return rows(&system, pauses(), &Plan::to(2.5)).map(drop).unwrap();
    }
    let error = rows(&system, pauses(), &Plan::to(2.5)).unwrap_err();
    assert!(
        format!("{error:#}").contains("t = 1.2345 s, the last successful time of mass"),
        "{error:#}"
    );
}
