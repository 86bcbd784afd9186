//! The same system in one thread and in several: the same bits, messages and errors.

use std::fs;

use cosim::master::{Master, Schedule};
use cosim::run::simulate::{self, Experiment};
use cosim::structure::system::{Setting, System};

use super::support::{link, oscillators, settings, ssd, stepping, system};

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

/// Systems drawn at random: springs and masses of any number, each input driven by any output that
/// fits it. What does not start on one thread, because of an algebraic loop, starts on none; what
/// fails or diverges does so alike.
#[test]
fn random_systems_give_the_same_bits_in_threads() {
    // Whatever the units are.
    const END: &str = "\">";
    const PLAIN: &str = "\" suppressUnitConversion=\"true\">";
    let mut state = 7_u64;
    let mut draw = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let one = ssd("");
    let elements = one.split("<ssd:Component ").skip(1);
    let elements: Vec<&str> = elements
        .map(|e| e.split("</ssd:Elements>").next().unwrap())
        .collect();
    let mut ran = [0; 3];
    for trial in 0..24 {
        let (springs, masses) = (1 + draw(5), 1 + draw(5));
        let numbered = |element: &str, name: &str, k: usize| {
            let element = format!("<ssd:Component {element}");
            element.replace(&format!("\"{name}\""), &format!("\"{name}{k}\""))
        };
        let mut names: Vec<String> = (0..springs)
            .map(|k| numbered(elements[0], "spring", k))
            .collect();
        for k in 0..masses {
            let place = draw(names.len() + 1);
            names.insert(place, numbered(elements[1], "mass", k));
        }
        let mut links = String::new();
        for k in 0..springs {
            for input in ["x", "x_dot", "x_ddot"] {
                let output = ["x", "x_dot", "x_ddot"][draw(3)];
                if draw(4) > 0 {
                    let from = format!("mass{}", draw(masses));
                    links += &link((&from, output), (&format!("spring{k}"), input), "")
                        .replace(END, PLAIN);
                }
            }
        }
        for k in 0..masses {
            let from = format!("spring{}", draw(springs));
            let output = ["F", "F_mean"][draw(2)];
            links += &link((&from, output), (&format!("mass{k}"), "f"), "").replace(END, PLAIN);
        }
        let structure = one
            .replace(
                &one[one.find("<ssd:Component ").unwrap()..one.find("</ssd:Elements>").unwrap()],
                &names.concat(),
            )
            .replace(
                "<ssd:Connections></ssd:Connections>",
                &format!("<ssd:Connections>{links}</ssd:Connections>"),
            );
        let system = system(&format!("random-{trial}"), &structure).unwrap();
        let starts: Vec<_> = (0..masses)
            .map(|k| format!("mass{k}.x_start=0.{}", 1 + draw(9)))
            .collect();
        let starts: Vec<_> = starts.iter().map(String::as_str).collect();
        let settings = settings(&system, &starts).unwrap();
        for (ran, schedule) in
            ran.iter_mut()
                .zip([Schedule::Standard, Schedule::Jacobi, Schedule::GaussSeidel])
        {
            let of = |threads| {
                let mut master =
                    Master::with_threads(&system, &settings, stepping(1e-2, schedule), threads)
                        .map_err(|error| format!("{error:#}"))?;
                let mut bits = Vec::new();
                for _ in 0..300 {
                    if let Err(error) = master.step() {
                        return Ok((bits, format!("{error:#}")));
                    }
                    bits.extend(master.exchange().values.iter().map(|v| v.to_bits()));
                }
                Ok::<_, String>((bits, String::new()))
            };
            let alone = of(1);
            *ran += usize::from(alone.is_ok());
            for threads in [2, 3] {
                assert!(
                    of(threads) == alone,
                    "system {trial}, {schedule:?}, {threads} threads: {structure}"
                );
            }
        }
    }
    assert!(ran[0] > 10 && ran[1] > 5 && ran[2] > 5, "{ran:?} started");
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
    for schedule in [Schedule::Standard, Schedule::Jacobi] {
        let texts = [1, 2, 4].map(|threads| {
            let mut experiment = experiment(&system, schedule, threads);
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
