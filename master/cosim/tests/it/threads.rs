//! The same system in one thread and in several: the same bits, messages and errors.

use std::fs;

use cosim::master::{Master, Schedule};
use cosim::run::simulate::{self, Experiment};
use cosim::structure::system::{Setting, System};

use super::support::{oscillators, settings, stepping, system};

const SCHEDULES: [Schedule; 4] = [
    Schedule::Standard,
    Schedule::Jacobi,
    Schedule::JacobiDerivatives,
    Schedule::GaussSeidel,
];

fn parameters(system: &System) -> Vec<Setting> {
    let each = |k| {
        [
            format!("spring{k}.k={}", 20 + 3 * k),
            format!("spring{k}.d=0.9"),
            format!("spring{k}.m=0.01"),
            format!("mass{k}.x_start=0.{k}"),
        ]
    };
    let texts: Vec<_> = (1..=5).flat_map(each).collect();
    let texts: Vec<_> = texts.iter().map(String::as_str).collect();
    settings(system, &texts).unwrap()
}

/// All connected outputs at each communication point, as bits.
fn bits(system: &System, experiment: &Experiment, steps: usize) -> Vec<u64> {
    let mut master = experiment.start(system).unwrap();
    let mut bits = Vec::new();
    for _ in 0..steps {
        master.step().unwrap();
        bits.extend(master.exchange().values.iter().map(|v| v.to_bits()));
    }
    let residuals = master.residuals().iter();
    bits.extend(residuals.map(|r| r.energy.to_bits()));
    bits
}

fn experiment(system: &System, schedule: Schedule, threads: usize) -> Experiment {
    Experiment {
        threads,
        settings: parameters(system),
        ..Experiment::new(stepping(1e-3, schedule))
    }
}

/// More steps are asked for by the environment: `THREAD_STEPS=100000`.
#[test]
fn every_number_of_threads_gives_the_same_bits() {
    let system = system("beside", &oscillators(5)).unwrap();
    let steps = std::env::var("THREAD_STEPS").map_or(1000, |steps| steps.parse().unwrap());
    for schedule in SCHEDULES {
        let of = |threads| bits(&system, &experiment(&system, schedule, threads), steps);
        let alone = of(1);
        assert!(alone.iter().any(|b| f64::from_bits(*b) != 0.0));
        for threads in [2, 4, 7] {
            assert!(of(threads) == alone, "{schedule:?}, {threads} threads");
        }
    }
}

/// Random numbers are drawn in the order of components.
#[test]
fn noise_is_the_same_in_threads() {
    let system = system("beside-noise", &oscillators(5)).unwrap();
    for schedule in SCHEDULES {
        let of = |threads| {
            let mut experiment = experiment(&system, schedule, threads);
            for wire in ["spring2.x", "mass4.f", "mass1.f"] {
                let noise = format!("{wire}=noise:1e-3");
                experiment.faults.add(&system, &noise).unwrap();
            }
            bits(&system, &experiment, 100)
        };
        assert!(of(1) == of(3), "{schedule:?}");
    }
}

#[test]
fn instances_in_threads_go_back_to_a_saved_state() {
    let system = system("beside-saved", &oscillators(5)).unwrap();
    let experiment = experiment(&system, Schedule::GaussSeidel, 3);
    let mut master = experiment.start(&system).unwrap();
    let steps = |master: &mut Master| {
        (0..20).for_each(|_| master.step().unwrap());
        master.exchange().values.clone()
    };
    let saved = master.save().unwrap();
    let first = steps(&mut master);
    master.restore(&saved).unwrap();
    assert_eq!(steps(&mut master), first);
    drop(master);
    // A state that outlives its run keeps its thread.
    drop(saved);
}

/// The first of the failing components is named, whichever thread is faster.
#[test]
fn an_error_is_that_of_one_thread() {
    let system = system("beside-error", &oscillators(5)).unwrap();
    let texts = [1, 2, 4].map(|threads| {
        let mut experiment = experiment(&system, Schedule::Jacobi, threads);
        let fails = ["mass4.fails_at=0.6", "mass2.fails_at=0.6"];
        experiment
            .settings
            .extend(settings(&system, &fails).unwrap());
        let master = experiment.start(&system).unwrap();
        let error = simulate::run(&system, master, 1.0, &|_, _| (), |_| Ok(())).unwrap_err();
        format!("{error:#}")
    });
    assert!(
        texts[0].contains("mass2") && texts[0].contains("fails_at"),
        "{}",
        texts[0]
    );
    assert!(texts[1] == texts[0] && texts[2] == texts[0], "{texts:?}");
}

/// Each thread has a library of its own, so a global variable that a step uses is nobody else's.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn code_that_is_not_made_for_threads_runs_in_two() {
    use super::foreign::compiled;
    use super::support::{load, pack, scratch};

    const DESCRIPTION: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="counter" guid="{1}">
      <CoSimulation modelIdentifier="counter" canHandleVariableCommunicationStepSize="true"/><ModelVariables>
      <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
      <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable></ModelVariables>
      <ModelStructure><Outputs><Unknown index="2" dependencies=""/></Outputs></ModelStructure></fmiModelDescription>"#;
    let folder = scratch("counter");
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "counter.so", &["counter.c"], &[]);
    pack(
        &folder.join("counter.fmu"),
        DESCRIPTION,
        "linux64",
        &[&library],
    );
    let names = ["a", "b", "c", "d"];
    let elements: String = names
        .map(|name| {
            format!(
                r#"<ssd:Component name="{name}" source="counter.fmu"><ssd:Connectors><ssd:Connector name="u" kind="input"/>
                <ssd:Connector name="y" kind="output"/></ssd:Connectors></ssd:Component>"#
            )
        })
        .concat();
    let connection =
        r#"<ssd:Connection startElement="a" startConnector="y" endElement="b" endConnector="u"/>"#;
    let structure = format!(
        r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" version="1.0" name="s"><ssd:System name="s"><ssd:Elements>{elements}
        </ssd:Elements><ssd:Connections>{connection}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"#
    );
    let file = folder.join("counter.ssd");
    fs::write(&file, structure).unwrap();
    let system = load(&file).unwrap();
    for threads in [1, 2] {
        let stepping = stepping(1e-3, Schedule::Standard);
        let mut master = Master::with_threads(&system, &[], stepping, threads).unwrap();
        for k in 0..200 {
            master.step().unwrap();
            for name in names {
                let y = master.number(system.port(&format!("{name}.y")).unwrap());
                assert_eq!(y.unwrap(), 20000.0, "{name}, step {k}, {threads} threads");
            }
        }
    }
}
