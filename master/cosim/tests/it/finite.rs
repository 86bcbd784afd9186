//! Numbers that are not finite end the run before they pass to another component; in outputs that
//! nothing reads they spoil the result. The FMU is `numbers.c`.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use cosim::Experiment;
use cosim::master::{Master, Schedule, Stepping};
use cosim::run::signals::{Inputs, matching_real};
use cosim::run::simulate::{self, Plan};
use cosim::schedule::Between;
use cosim::stepping::{StepControl, StepLimits};
use cosim::structure::FmuUse;
use cosim::structure::system::System;
use fmi_description::Version;

use super::foreign::compiled;
use super::support::{assert_contains, fmu as fmu_of_kit, pack, scratch, settings, stepping};

const H: f64 = 0.1;
const VERSIONS: [Version; 2] = [Version::Fmi2, Version::Fmi3];
const SCHEDULES: [Schedule; 4] = [
    Schedule::Standard,
    Schedule::Jacobi,
    Schedule::JacobiDerivatives,
    Schedule::GaussSeidel,
];
/// What `kind` makes of the output, as messages show it.
const KINDS: [(&str, &str); 3] = [("1", "NaN"), ("2", "inf"), ("3", "-inf")];

/// The FMU as a file `component.fmu` in the folder `test`, with arrays and Float32 in FMI 3.0.
fn fmu(test: &str, component: &str, version: Version) -> PathBuf {
    let folder = scratch(test);
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "numbers.so", &["numbers.c"], &["-lm"]);
    let file = folder.join(format!("{component}.fmu"));
    let variables = [
        ("u", 0, "input", "1"),
        ("y", 1, "output", ""),
        ("at", 2, "parameter", "1e9"),
        ("kind", 3, "parameter", "0"),
        ("given", 4, "local", ""),
        ("ahead", 5, "parameter", "0"),
        ("q", 14, "output", ""),
        ("r", 15, "output", ""),
    ];
    let mut text = String::new();
    for (name, reference, causality, start) in variables {
        let start = match start {
            "" => String::new(),
            start => format!("start=\"{start}\""),
        };
        let attributes =
            format!("name=\"{name}\" valueReference=\"{reference}\" causality=\"{causality}\"");
        let fixed = match causality {
            "parameter" => "variability=\"fixed\"",
            _ => "",
        };
        text += &match version {
            Version::Fmi2 => {
                format!("<ScalarVariable {attributes} {fixed}><Real {start}/></ScalarVariable>")
            }
            Version::Fmi3 => format!("<Float64 {attributes} {fixed} {start}/>"),
        };
    }
    let (text, platform) = match version {
        Version::Fmi2 => (
            format!(
                r#"<fmiModelDescription fmiVersion="2.0" modelName="numbers" guid="g"><CoSimulation modelIdentifier="numbers"
                canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true" canInterpolateInputs="true"
                maxOutputDerivativeOrder="1"/><ModelVariables>{text}</ModelVariables><ModelStructure><Outputs>
                <Unknown index="2" dependencies=""/><Unknown index="7" dependencies="1"/><Unknown index="8"/></Outputs></ModelStructure>
                </fmiModelDescription>"#
            ),
            "linux64",
        ),
        Version::Fmi3 => (
            format!(
                r#"<fmiModelDescription fmiVersion="3.0" modelName="numbers" instantiationToken="t"><CoSimulation modelIdentifier="numbers"
                canHandleVariableCommunicationStepSize="true" hasEventMode="true"/><ModelVariables>{text}
                <Float64 name="v" valueReference="10" causality="input" start="0 0 0"><Dimension start="3"/></Float64>
                <Float64 name="v_out" valueReference="11" causality="output"><Dimension start="3"/></Float64>
                <Float32 name="w" valueReference="12" causality="input" start="0"/>
                <Float32 name="w_out" valueReference="13" causality="output"/></ModelVariables><ModelStructure>
                <Output valueReference="1" dependencies=""/><Output valueReference="11" dependencies=""/>
                <Output valueReference="13" dependencies=""/><Output valueReference="14" dependencies="0"/><Output valueReference="15"/>
                </ModelStructure></fmiModelDescription>"#
            ),
            "x86_64-linux",
        ),
    };
    pack(&file, &text, platform, &[&library]);
    file
}

fn system(test: &str, version: Version, connections: &[&str]) -> System {
    let files = ["a", "b"].map(|name| fmu(test, name, version));
    let connections: Vec<String> = connections.iter().map(ToString::to_string).collect();
    System::from_fmus(&files, &connections, &FmuUse::default()).unwrap()
}

/// From 0.5 s on.
fn experiment(system: &System, start: &[&str], schedule: Schedule) -> Experiment {
    Experiment {
        stop: Some(1.5),
        settings: settings(system, start).unwrap(),
        ..Experiment::new(stepping(H, schedule))
    }
}

fn number(system: &System, master: &Master, name: &str) -> f64 {
    master.number(system.port(name).unwrap()).unwrap()
}

/// Steps until an error; its text.
fn failure(master: &mut Master) -> String {
    let failed = (0..10).find_map(|_| master.step().err());
    format!("{:#}", failed.expect("a failed step"))
}

/// The output changes at 0.72 s, so that the communication point at 0.8 s is the first that shows
/// it; nothing that is not finite reaches the other component.
#[track_caller]
fn assert_ends(system: &System, experiment: &Experiment, parts: &[&str]) {
    let mut master = experiment.start(system).unwrap();
    let (text, what) = (failure(&mut master), experiment.stepping);
    assert_contains(&format!("{what:?}: {text}"), parts);
    assert_eq!(number(system, &master, "b.given"), 0.0, "{what:?}");
}

#[test]
fn a_number_that_is_not_finite_ends_the_run_before_it_passes() {
    for version in VERSIONS {
        let name = format!("finite-{version:?}");
        let plain = system(&name, version, &["a.y=b.u", "b.q=a.u"]);
        for schedule in SCHEDULES {
            for (kind, shown) in KINDS {
                let kind = format!("a.kind={kind}");
                let base = experiment(&plain, &["a.at=0.72", &kind], schedule);
                let parts = [
                    &format!("`a.y` became {shown} at t = 0.8 s"),
                    "--allow-nonfinite a.y",
                ];
                assert_ends(&plain, &base, &parts);
                let threads = 2;
                assert_ends(&plain, &Experiment { threads, ..base }, &parts);
            }
        }
        for between in [Between::Extrapolated, Between::Interpolated, Between::End] {
            let start = ["a.at=0.72", "a.kind=1"];
            let mut base = experiment(&plain, &start, Schedule::GaussSeidel);
            base.stepping = Stepping {
                between,
                ..base.stepping
            };
            let mut rated = plain.clone();
            for (component, step) in [("a", 0.05), ("b", 0.025)] {
                rated.structure.rates.push((component.into(), step));
                assert_ends(&rated, &base, &["`a.y` became NaN at t = 0."]);
            }
            // Only each second communication point is one of the receiver's.
            rated.structure.rates = vec![("b".into(), 0.2)];
            assert_ends(&rated, &base, &["`a.y` became NaN at t = 0."]);
        }
    }
}

/// Elements, Float32, and a Float64 that no Float32 can hold.
#[test]
fn every_type_and_element_is_checked() {
    let wires = [
        ("a.v_out[2]=b.v[3]", "1", "`a.v_out[2]` became NaN at"),
        ("a.w_out=b.w", "3", "`a.w_out` became -inf at"),
        ("a.w_out=b.w", "4", "`a.w_out` became inf at"),
        (
            "a.y=b.w",
            "4",
            "`b.w` would be set to 1e300, too large for a Float32 at",
        ),
        ("a.w_out=b.u", "1", "`a.w_out` became NaN at"),
    ];
    for (wire, kind, expected) in wires {
        let plain = system("finite-types", Version::Fmi3, &[wire]);
        for schedule in SCHEDULES {
            let start = ["a.at=0.72", &format!("a.kind={kind}")];
            let base = experiment(&plain, &start, schedule);
            let expected = format!("{expected} t = 0.8 s");
            assert_ends(&plain, &base, &[&expected]);
            let threads = 2;
            assert_ends(&plain, &Experiment { threads, ..base }, &[&expected]);
        }
    }
}

/// What a transformation or a fault makes of a finite number.
#[test]
fn transformed_and_altered_numbers_are_checked() {
    let plain = system("finite-altered", Version::Fmi2, &["a.y=b.u"]);
    let mut scaled = plain.clone();
    scaled.structure.connections[0].way[0].transformation =
        Some(system_structure::Transformation::Linear {
            factor: -1e10,
            offset: 0.0,
        });
    let start = ["a.at=0.72", "a.kind=4"];
    for schedule in SCHEDULES {
        let base = experiment(&scaled, &start, schedule);
        let parts = ["`b.u` would be set to -inf at t = 0.8 s"];
        assert_ends(&scaled, &base, &parts);
        let mut base = experiment(&plain, &start, schedule);
        base.faults.add(&plain, "b.u=gain:1e200").unwrap();
        assert_ends(&plain, &base, &["`b.u` would be set to inf at t = 0.8 s"]);
    }
    let start = ["a.at=0.72", "a.kind=5"];
    let base = experiment(&plain, &start, Schedule::JacobiDerivatives);
    let parts = ["`a.y` has the derivative NaN at t = 0.8 s"];
    assert_ends(&plain, &base, &parts);
}

#[test]
fn chosen_steps_end_there_too() {
    let plain = system("finite-chosen", Version::Fmi2, &["a.y=b.u"]);
    let doubling = StepControl::Doubling {
        tolerance: 1e-3,
        limits: StepLimits {
            length: [0.05, 0.1],
            ..StepLimits::default()
        },
    };
    for control in [StepControl::Repeated, doubling] {
        let base = experiment(&plain, &["a.at=0.72", "a.kind=1"], Schedule::Jacobi);
        let master = base.start(&plain).unwrap();
        let plan = Plan {
            control,
            ..Plan::to(1.5)
        };
        let mut nothing: Option<cosim::Recording> = None;
        let done = simulate::run_plan(&plain, master, &plan, &|_, _| (), &mut nothing);
        assert_contains(
            &format!("{:#}", done.unwrap_err()),
            &["`a.y` became NaN at t = 0."],
        );
    }
}

/// From the start on: before the first step. Where passes over a loop are repeated, a component
/// that has not got its inputs yet may divide by 0.
#[test]
fn initialization_is_checked_where_it_has_settled() {
    for version in VERSIONS {
        let name = format!("finite-initial-{version:?}");
        let plain = system(&name, version, &["a.y=b.u"]);
        for schedule in SCHEDULES {
            let base = experiment(&plain, &["a.at=0", "a.kind=2"], schedule);
            let text = format!("{:#}", base.start(&plain).err().unwrap());
            assert_contains(&text, &["`a.y` became inf in initialization"]);
        }
        let looped = system(&name, version, &["b.y=a.u", "a.r=b.u", "b.r=a.at"]);
        let base = experiment(&looped, &["a.u=0"], Schedule::Standard);
        let mut master = base.start(&looped).unwrap();
        master.step().unwrap();
        assert_eq!(number(&looped, &master, "b.u"), 1.0);
        let base = experiment(&looped, &["b.at=0", "b.kind=1"], Schedule::Standard);
        let text = format!("{:#}", base.start(&looped).err().unwrap());
        assert_contains(&text, &["`b.y` became NaN in initialization"]);
    }
}

/// Each variable once, with the first time; the run goes on. Those that are allowed pass.
#[test]
fn unconnected_outputs_spoil_the_verdict() {
    for version in VERSIONS {
        let name = format!("finite-unconnected-{version:?}");
        let plain = system(&name, version, &["a.y=b.u"]);
        for schedule in SCHEDULES {
            for threads in [1, 2] {
                let start = ["b.at=0.72", "b.kind=3"];
                let base = Experiment {
                    threads,
                    ..experiment(&plain, &start, schedule)
                };
                let run = |base: &Experiment| {
                    let master = base.start(&plain).unwrap();
                    simulate::run(&plain, master, 1.5, &|_, _| (), |_| Ok(())).unwrap()
                };
                let outcome = run(&base);
                let bad: Vec<_> = outcome
                    .verdict
                    .findings()
                    .iter()
                    .filter(|f| f.is_bad)
                    .collect();
                let count = if version == Version::Fmi2 { 1 } else { 3 };
                assert_eq!(bad.len(), count, "{schedule:?}: {bad:?}");
                let parts = ["`b.y` became -inf at t = 0.8 s", "--allow-nonfinite b.y"];
                assert_contains(&bad[0].text, &parts);
                assert!((outcome.simulated - 1.0).abs() < 1e-9);
                let allowed = matching_real(&plain, &["b.*".into()]).unwrap();
                let allowed = Experiment {
                    nonfinite: allowed,
                    ..base
                };
                assert!(!run(&allowed).verdict.is_bad());
            }
        }
        // With leave it passes through the wire and what it drives.
        let start = ["a.at=0.72", "a.kind=1"];
        let base = Experiment {
            nonfinite: matching_real(&plain, &["a.y".into()]).unwrap(),
            ..experiment(&plain, &start, Schedule::GaussSeidel)
        };
        let mut master = base.start(&plain).unwrap();
        (0..10).try_for_each(|_| master.step()).unwrap();
        assert!(number(&plain, &master, "b.given") > 0.0);
        let unknown = matching_real(&plain, &["a.x*".into()]).unwrap_err();
        assert_contains(&unknown.to_string(), &["matches `a.x*`"]);
    }
}

/// What was found belongs to a saved state.
#[test]
fn a_restored_run_knows_what_was_found() {
    let plain = system("finite-saved", Version::Fmi2, &["a.y=b.u"]);
    let base = experiment(&plain, &["b.at=0.72", "b.kind=1"], Schedule::Jacobi);
    let mut master = base.start(&plain).unwrap();
    let bad = |master: &Master| {
        let supervision =
            cosim::run::supervision::Supervision::new(&plain, master, Default::default());
        let supervision = supervision.unwrap();
        supervision.verdict(&plain, master).is_bad()
    };
    let before = master.save().unwrap();
    (0..4).try_for_each(|_| master.step()).unwrap();
    let after = master.save().unwrap();
    assert!(bad(&master));
    master.restore(&before).unwrap();
    assert!(!bad(&master));
    master.restore(&after).unwrap();
    assert!(bad(&master));
}

/// Start values, by every way, and values that a script sets.
#[test]
fn start_values_are_checked() {
    for version in VERSIONS {
        let name = format!("finite-start-{version:?}");
        let plain = system(&name, version, &[]);
        let names = match version {
            Version::Fmi2 => vec!["a.u", "a.at"],
            Version::Fmi3 => vec!["a.u", "a.at", "a.v[2]", "a.w"],
        };
        for name in names {
            for text in ["nan", "NaN", "inf", "-INF", "1e400"] {
                let start = [&*format!("{name}={text}")];
                let base = experiment(&plain, &start, Schedule::Jacobi);
                let error = format!("{:#}", base.start(&plain).err().unwrap());
                assert_contains(
                    &error,
                    &[&format!("`{name}` = {text}: it must be a finite")],
                );
                let nonfinite = matching_real(&plain, &[name.into()]).unwrap();
                let allowed = Experiment { nonfinite, ..base };
                allowed.start(&plain).unwrap();
            }
        }
        let set = scratch(&format!("nonfinite-{version:?}.ssv"));
        for text in ["NaN", "INF", "-INF", "1e999"] {
            let ssv = format!(
                r#"<ssv:ParameterSet xmlns:ssv="s" version="1.0" name="p"><ssv:Parameters><ssv:Parameter name="a.at"><ssv:Real value="{text}"/>
                </ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"#
            );
            fs::write(&set, ssv).unwrap();
            let mut given = plain.clone();
            given.path = scratch("none.ssd");
            fs::write(&given.path, "").unwrap();
            given.apply_set(&set).unwrap();
            let base = experiment(&given, &[], Schedule::Jacobi);
            let error = format!("{:#}", base.start(&given).err().unwrap());
            assert_contains(&error, &["nonfinite-", "`a.at` = ", "must be a finite"]);
        }
        let base = experiment(&plain, &[], Schedule::Jacobi);
        let master = base.start(&plain).unwrap();
        let mut inputs = Inputs::new(&plain, &[plain.port("a.u").unwrap()]).unwrap();
        let error = inputs.set(&master, &[f64::NAN]).unwrap_err().to_string();
        assert_contains(&error, &["`a.u` would be set to NaN at t = 0.5 s"]);
    }
    let single = system("finite-start-single", Version::Fmi3, &[]);
    let base = experiment(&single, &["a.w=1e300"], Schedule::Jacobi);
    let error = format!("{:#}", base.start(&single).err().unwrap());
    assert_contains(&error, &["`a.w` = 1e300: it must be a finite number"]);
}

/// Events one ulp ahead, steps that return one ulp later, and discrete states that never settle.
#[test]
fn events_without_end_are_named() {
    let plain = system("finite-events", Version::Fmi3, &["a.y=b.u"]);
    for (ahead, parts) in [
        // The FMU has come to 0.8 s less an ulp: what it announces there is left to the next step.
        ("1", ["`a` has had 1000 events in a row", "at t = 0.9"]),
        ("2", ["fmi3DoStep returned early", "at 0.8"]),
        ("3", ["a", "still change after 100 passes"]),
        (
            "5",
            ["fmi3UpdateDiscreteStates asks to end", "at t = 0.8 s"],
        ),
    ] {
        for schedule in [Schedule::Jacobi, Schedule::GaussSeidel] {
            let start = ["a.at=0.72", &format!("a.ahead={ahead}")];
            let base = experiment(&plain, &start, schedule);
            let mut master = base.start(&plain).unwrap();
            assert_contains(&failure(&mut master), &parts);
        }
    }
    // At 0.8 s = 0.5 s + 3·0.1 s the FMU has come to (0.5 s + 2·0.1 s) + 0.1 s, which is less: it
    // announces that event anew, and there is no step of length 0.
    for schedule in [Schedule::Standard, Schedule::Jacobi] {
        let base = experiment(&plain, &["a.ahead=4"], schedule);
        let mut master = base.start(&plain).unwrap();
        (0..10).for_each(|_| master.step().unwrap());
        assert_eq!(master.time(), 1.5);
    }
}

/// The program: options, exit codes.
#[test]
fn the_program_refuses_and_allows() {
    let file = fmu("finite-program", "a", Version::Fmi2);
    let run = |more: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_cosim"))
            .args(["run", file.to_str().unwrap(), "--step", "0.1", "--check"])
            .args(more)
            .output()
            .unwrap();
        let text = [done.stdout, done.stderr].map(|text| String::from_utf8(text).unwrap());
        (done.status.code().unwrap(), text.concat())
    };
    let (code, text) = run(&["--set", "a.u=nan"]);
    assert_eq!(code, 1, "{text}");
    assert_contains(&text, &["`a.u` = nan: it must be a finite number"]);
    let bad = ["--set", "a.at=0.5", "--set", "a.kind=1"];
    let (code, text) = run(&bad);
    assert_eq!(code, 2, "{text}");
    assert_contains(&text, &["verdict: BAD", "`a.y` became NaN at t = 0.5 s"]);
    let leave = ["--allow-nonfinite", "*.y", "--allow-nonfinite", "u"];
    let (code, text) = run(&[&bad[..], &leave].concat());
    assert_eq!(code, 0, "{text}");
    let (code, text) = run(&["--allow-nonfinite", "a.nothing"]);
    assert_eq!(code, 1, "{text}");
    assert_contains(&text, &["--allow-nonfinite: no variable", "`a.nothing`"]);
}

/// FMUs of the kit do not hand out such a number at all, also where nothing but the watch reads it.
#[test]
fn an_output_of_the_kit_ends_the_run() {
    let folder = scratch("finite-kit");
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join("spring.fmu");
    fs::write(&file, fmu_of_kit("spring")).unwrap();
    let alone = System::from_fmus(&[file], &[], &FmuUse::default()).unwrap();
    let x = [alone.port("spring.x").unwrap()];
    for schedule in SCHEDULES {
        let base = experiment(&alone, &["spring.k=1e308"], schedule);
        let mut master = base.start(&alone).unwrap();
        (0..3).try_for_each(|_| master.step()).unwrap();
        let mut inputs = Inputs::new(&alone, &x).unwrap();
        inputs.set(&master, &[10.0]).unwrap();
        let parts = [
            "spring: ",
            "`F` became -inf; it must be finite",
            "t = 0.9 s",
        ];
        assert_contains(&failure(&mut master), &parts);
    }
}
