//! The key of a run changes with all that its numbers depend on, and with nothing else; a snapshot
//! of another run is refused by name.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cosim::exchange::faults::Faults;
use cosim::io::input_table::{Column, Table};
use cosim::master::{Jitter, Schedule};
use cosim::run::experiment::Experiment;
use cosim::run::run_key::RunKey;
use cosim::schedule::Between;
use cosim::structure::system::System;

use super::program::{cosim, fmus, packed};
use super::support::{
    assert_contains, edited, oscillator, oscillator_links, packed as fmu_of, scratch, settings,
    ssd, stepping, system,
};

fn experiment(system: &System) -> Experiment {
    let mut faults = Faults::default();
    faults.add(system, "spring.x=noise:1e-3").unwrap();
    let column = |name: &str, last| Column {
        name: name.into(),
        unit: None,
        values: vec![0.0, last],
    };
    Experiment {
        stop: Some(2.0),
        settings: settings(system, &["spring.k=2", "spring.d=0.1"]).unwrap(),
        faults,
        inputs: Some(Arc::new(Table {
            times: vec![0.0, 1.0],
            columns: vec![column("spring.x_ddot", 1.0), column("spring.stage", 2.0)],
        })),
        ..Experiment::new(stepping(0.01, Schedule::Jacobi))
    }
}

type Change = fn(&mut System, &mut Experiment);

fn table(experiment: &mut Experiment) -> &mut Table {
    Arc::make_mut(experiment.inputs.as_mut().unwrap())
}

#[test]
fn each_condition_changes_the_key() {
    let system = system("run_key", &oscillator()).unwrap();
    let first = RunKey::new(&system, &experiment(&system));
    let key = |change: Change| {
        let (mut system, mut experiment) = (system.clone(), experiment(&system));
        change(&mut system, &mut experiment);
        RunKey::new(&system, &experiment)
    };
    let changes: [(&str, Change); 25] = [
        ("the start time is 0.5 s there and 0.25 s", |_, e| {
            e.stepping.start = 0.25
        }),
        ("the communication step", |_, e| e.stepping.step = 0.02),
        ("the schedule", |_, e| {
            e.stepping.schedule = Schedule::Standard
        }),
        ("--between", |_, e| {
            e.stepping.between = Between::Extrapolated
        }),
        ("the jitter", |_, e| {
            let (seed, part, lost) = (1, 0.1, 0.0);
            e.stepping.jitter = Some(Jitter { seed, part, lost });
        }),
        ("the stop time", |_, e| e.stop = Some(2.5)),
        ("`spring.k` is 2 there and 3", |s, e| {
            e.settings.extend(settings(s, &["spring.k=3"]).unwrap());
        }),
        ("`spring.m` is not given", |s, e| {
            e.settings.extend(settings(s, &["spring.m=0.1"]).unwrap());
        }),
        ("`spring.d` is 0.1 there and not given", |_, e| {
            e.settings.truncate(1)
        }),
        ("the list of faults", |_, e| e.faults.list[0].from = 1.0),
        ("the list of faults", |s, e| {
            e.faults.add(s, "mass.f=bias:1").unwrap();
        }),
        ("the seed of faults", |_, e| e.faults.seed = 1),
        ("the input `spring.stage`", |_, e| {
            table(e).columns[1].values[1] = 3.0
        }),
        ("the input `spring.stage`", |_, e| table(e).times[1] = 2.0),
        ("the input `spring.x_ddot`", |_, e| {
            table(e).columns[0].unit = Some("mm/s2".into());
        }),
        ("the input", |_, e| e.inputs = None),
        ("the FMU of `mass`", |s, _| s.fmus[1] = s.fmus[0].clone()),
        ("the order of components", |s, _| {
            s.structure.components.reverse();
            s.fmus.reverse();
        }),
        ("the source of `mass.f`", |s, _| {
            s.structure.connections.pop();
        }),
        ("the source of `spring.x`", |s, _| {
            s.structure.connections[0].start.1 = "x_dot".into();
        }),
        ("the order of connections", |s, _| {
            s.structure.connections.swap(0, 1)
        }),
        ("--feedthrough is  there and mass", |s, _| {
            s.structure.feedthrough.push("mass".into());
        }),
        ("the step of `mass`", |s, _| {
            s.structure.rates.push(("mass".into(), 0.005))
        }),
        ("--solve-loops", |s, _| s.structure.solves_loops = true),
        ("the list of connectors of `mass`", |s, _| {
            s.structure.components[1].connectors[0].unit = Some(fmi_description::Unit::named("N"));
        }),
    ];
    let mut digests = vec![first.digest()];
    for (named, change) in changes {
        let changed = key(change);
        let difference = changed.difference(&first, "there", "").unwrap_or_default();
        assert_contains(&difference, &[named]);
        assert!(!digests.contains(&changed.digest()), "{named}");
        digests.push(changed.digest());
    }
    let same: [Change; 8] = [
        |_, e| e.threads = 7,
        |_, e| e.settings.reverse(),
        |s, e| {
            let again = ["spring.k=7", "spring.k=2.0"];
            e.settings.extend(settings(s, &again).unwrap());
        },
        |s, _| s.path = "/elsewhere/system.ssp".into(),
        |s, _| s.structure.name = "another".into(),
        |s, _| s.structure.components[0].source = "/elsewhere/Spring.fmu".into(),
        |s, _| s.structure.connections[0].place = "line 7".into(),
        |_, e| {
            let columns = table(e).columns.clone();
            table(e).columns = columns.into_iter().rev().collect();
        },
    ];
    for (k, change) in same.into_iter().enumerate() {
        let changed = key(change);
        assert_eq!(changed.difference(&first, "there", ""), None, "{k}");
        assert_eq!(changed.digest(), first.digest(), "{k}");
    }
}

/// The bytes of an FMU, and what the structure's file says, count; where it lies does not.
#[test]
fn files_count_by_their_content() {
    let key = |system: &System| RunKey::new(system, &experiment(system)).digest();
    let first = key(&system("run_key_files", &oscillator()).unwrap());
    assert_eq!(
        key(&system("run_key_elsewhere", &oscillator()).unwrap()),
        first
    );
    let stiffer = |_: &str, text: &str| text.replace("stiffness", "Stiffness");
    let other = edited("run_key_edited", &oscillator(), stiffer).unwrap();
    assert_ne!(key(&other), first);
    let factor = "<ssd:LinearTransformation factor=\"2\"/>";
    let other = ssd(&oscillator_links("", factor, ""));
    assert_ne!(key(&system("run_key_factor", &other).unwrap()), first);
}

/// A start value that names a file counts by the content of the file, and of the files that a JSON
/// file names; its folder makes no difference.
#[test]
fn a_file_that_a_start_value_names_counts() {
    let folders = ["run_key_a", "run_key_b"].map(scratch);
    let write = |folder: &Path, name: &str, text: &str| {
        fs::create_dir_all(folder).unwrap();
        fs::write(folder.join(name), text).unwrap();
    };
    for folder in &folders {
        write(
            folder,
            "machine.json",
            r#"{"extends": ["base.json"], "own": "machine.json"}"#,
        );
        write(folder, "base.json", r#"{"k": 1}"#);
    }
    let text = |_: &str, text: &str| {
        let real = text.find("<ScalarVariable name=\"m\"").unwrap_or(0);
        let (before, after) = text.split_at(real);
        let end = after.find("</ScalarVariable>").unwrap_or(0);
        let (variable, rest) = after.split_at(end);
        let start = variable.find("<Real").unwrap_or(variable.len());
        let string = if end > 0 {
            "<String start=\"none\"/>"
        } else {
            ""
        };
        format!("{before}{}{string}{rest}", &variable[..start])
    };
    let system = edited("run_key_text", &oscillator(), text).unwrap();
    let key = |file: PathBuf| {
        let mut experiment = experiment(&system);
        let setting = system.setting("spring.m", file.display());
        experiment.settings.push(setting.unwrap());
        RunKey::new(&system, &experiment).digest()
    };
    let [first, other] = folders
        .each_ref()
        .map(|folder| key(folder.join("machine.json")));
    assert_eq!(first, other);
    write(&folders[1], "base.json", r#"{"k": 2}"#);
    assert_ne!(key(folders[1].join("machine.json")), first);
    write(&folders[1], "base.json", r#"{"k": 1}"#);
    assert_eq!(key(folders[1].join("machine.json")), first);
    write(&folders[1], "machine.json", r#"{"extends": ["base.json"]}"#);
    assert_ne!(key(folders[1].join("machine.json")), first);
    assert_ne!(key(folders[1].join("missing.json")), first);
}

/// Options one after the other, each with what the message names; and options that may differ.
#[test]
fn a_snapshot_of_another_run_is_refused_by_name() {
    let file = packed("run_key_program");
    let [other, _] = fmus("run_key_other");
    let snapshot = scratch("run_key.snapshot").display().to_string();
    let inputs = |name: &str, last: &str| {
        let file = scratch(name);
        fs::write(&file, format!("time,spring.x_ddot\n0,0\n3,{last}\n")).unwrap();
        file.display().to_string()
    };
    let (table, again) = (inputs("run_key_1.csv", "1"), inputs("run_key_2.csv", "1"));
    let changed = inputs("run_key_3.csv", "2");
    let base = ["--step", "0.01", "--set", "spring.k=2", "--quiet"];
    let run = |more: &[&str]| {
        let mut arguments = vec!["run", "--system", &file];
        arguments.extend(base.iter().chain(more));
        cosim(&arguments)
    };
    let saving = format!("1={snapshot}");
    let (code, _, error) = run(&["--input", &table, "--snapshot", &saving]);
    assert_eq!(code, 0, "{error}");
    let set = scratch("run_key.ssv").display().to_string();
    fs::write(
        &set,
        "<ssv:ParameterSet xmlns:ssv=\"v\" version=\"1.0\" name=\"s\"><ssv:Parameters><ssv:Parameter name=\"spring.d\"><ssv:Real value=\"0.5\"/>\
         </ssv:Parameter></ssv:Parameters></ssv:ParameterSet>",
    )
    .unwrap();
    let fmu = format!("spring={}", edited_spring(&other));
    for (more, part) in [
        (
            ["--set", "spring.k=3"],
            "`spring.k` is 2 in the snapshot and 3 here",
        ),
        (
            ["--set", "mass.x_start=3"],
            "`mass.x_start` is not given in the snapshot",
        ),
        (
            ["--parameters", &set],
            "`spring.d` is not given in the snapshot and 0.5 here",
        ),
        (["--fmu", &fmu], "the FMU of `spring` is sha256"),
        (
            ["--schedule", "standard"],
            "the schedule is GaussSeidel in the snapshot and Standard here",
        ),
        (["--between", "extrapolated"], "--between is Held"),
        (
            ["--rate", "mass=5ms"],
            "the step of `mass` is not given in the snapshot and 0.005 s here",
        ),
        (
            ["--fault", "mass.f=bias:1"],
            "the list of faults is not given in the snapshot",
        ),
        (
            ["--energy-tolerance", "1e-3"],
            "the choice of steps is Fixed",
        ),
    ] {
        let resume = ["--input", &table, "--resume", &snapshot];
        let (code, _, error) = run(&[&resume[..], &more[..]].concat());
        assert_eq!(code, 1, "{more:?}");
        assert_contains(&error, &[&snapshot, "another run", part]);
    }
    for more in [
        &["--solve-loops", "--input", &table][..],
        &["--input", &changed],
        &[],
    ] {
        let (code, _, error) = run(&[&["--resume", &snapshot], more].concat());
        assert_eq!(code, 1, "{more:?}");
        assert_contains(&error, &["another run"]);
    }
    let csv = scratch("run_key.csv").display().to_string();
    for more in [
        &["--input", &table][..],
        &["--input", &again],
        &["--input", &table, "--threads", "2", "--csv", &csv],
        &[
            "--input",
            &table,
            "--stop-time",
            "3",
            "--set",
            "spring.k=2.0",
        ],
    ] {
        let (code, _, error) = run(&[&["--resume", &snapshot], more].concat());
        assert_eq!(code, 0, "{more:?}: {error}");
    }
}

/// An FMU that differs in a description only.
fn edited_spring(beside: &str) -> String {
    let mut files = super::support::files("spring", fmi_description::Version::Fmi2);
    for (name, bytes) in &mut files {
        if name == "modelDescription.xml" {
            let text = String::from_utf8(bytes.clone()).unwrap();
            *bytes = text.replace("stiffness", "Stiffness").into_bytes();
        }
    }
    let file = Path::new(beside).with_file_name("edited.fmu");
    fs::write(&file, fmu_of(&files)).unwrap();
    file.display().to_string()
}
