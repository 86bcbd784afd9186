//! A run that is saved and restored goes on as it did, bit for bit.

use std::sync::Arc;

use cosim::exchange::faults::Faults;
use cosim::io::input_table::{Column, Table};
use cosim::master::{Master, Schedule};
use cosim::run::experiment::Experiment;
use cosim::run::signals::{Signals, matching};
use cosim::structure::system::System;

use super::support::{oscillator, settings, stepping, system};

const SCHEDULES: [Schedule; 4] = [
    Schedule::Standard,
    Schedule::GaussSeidel,
    Schedule::Jacobi,
    Schedule::JacobiDerivatives,
];

/// With all that remembers values from one communication point to the next.
fn started(system: &System, schedule: Schedule) -> Master {
    let mut faults = Faults::default();
    for text in [
        "spring.x=noise:1e-3",
        "spring.x_dot=drop:0.3",
        "mass.f=delay:0.03",
    ] {
        faults.add(system, text).unwrap();
    }
    let rising = Column {
        name: "spring.x_ddot".into(),
        unit: None,
        values: vec![0.0, 1.0],
    };
    let experiment = Experiment {
        settings: settings(system, &["spring.k=23", "spring.m=0.1", "mass.x_start=0.3"]).unwrap(),
        faults,
        inputs: Some(Arc::new(Table {
            times: vec![0.5, 1.5],
            columns: vec![rising],
        })),
        ..Experiment::new(stepping(0.01, schedule))
    };
    experiment.start(system).unwrap()
}

/// Bits of time, all outputs and the energies of the bonds over some steps.
fn steps(system: &System, master: &mut Master, count: usize) -> Vec<u64> {
    let mut signals = Signals::new(system, &matching(system, &["*".into()]).unwrap()).unwrap();
    let mut all = Vec::new();
    for _ in 0..count {
        master.step().unwrap();
        let values = signals.read(master).unwrap().iter().copied();
        let energies = master.residuals().iter().flat_map(|r| [r.energy, r.peak]);
        let own = [master.time(), master.steps() as f64].into_iter();
        all.extend(own.chain(values).chain(energies).map(f64::to_bits));
    }
    all
}

#[test]
fn a_restored_run_goes_on_as_it_did() {
    let system = system("saved", &oscillator()).unwrap();
    for schedule in SCHEDULES {
        let mut master = started(&system, schedule);
        steps(&system, &mut master, 20);
        let saved = master.save().unwrap();
        let first = steps(&system, &mut master, 100);
        let later = master.save().unwrap();
        let second = steps(&system, &mut master, 50);
        for _ in 0..2 {
            master.restore(&saved).unwrap();
            assert_eq!(steps(&system, &mut master, 100), first, "{schedule:?}");
        }
        master.restore(&later).unwrap();
        assert_eq!(steps(&system, &mut master, 50), second, "{schedule:?}");
        assert_ne!(first, second);
        // States may outlive their run: they are freed before its instances are.
        master.terminate().unwrap();
    }
}

#[test]
fn a_state_of_another_run_is_refused() {
    let system = system("saved_elsewhere", &oscillator()).unwrap();
    let [mut one, other] = [(); 2].map(|()| started(&system, Schedule::Jacobi));
    let error = one.restore(&other.save().unwrap()).unwrap_err();
    assert!(
        format!("{error:#}").contains("a state of another"),
        "{error:#}"
    );
}
