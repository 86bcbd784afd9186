//! Components in processes of their own: the same bits, and whatever such a component does, the run
//! ends with a reason, its rows and the other components.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use cosim::master::{Master, Schedule};
use cosim::run::simulate::{self, Experiment};
use cosim::structure::FmuUse;
use cosim::structure::package::{FmuPlace, Package};
use cosim::structure::system::System;

use super::foreign::plain_fmu;
use super::hostile::packed;
use super::support::{assert_contains, oscillators, scratch, settings, stepping, system};

const SCHEDULES: [Schedule; 4] = [
    Schedule::Standard,
    Schedule::Jacobi,
    Schedule::JacobiDerivatives,
    Schedule::GaussSeidel,
];

/// The same system with these components in processes of their own.
fn isolated(system: &System, components: &[&str]) -> System {
    let options = FmuUse {
        isolated: components.iter().map(ToString::to_string).collect(),
        ..FmuUse::default()
    };
    let package = &mut Package::open(&system.path).unwrap();
    let place = FmuPlace::Structure {
        else_in: Vec::new(),
    };
    let loaded = &mut BTreeMap::new();
    System::from_package(package, None, &place, &[], &[], &options, loaded).unwrap()
}

fn experiment(system: &System, schedule: Schedule) -> Experiment {
    let texts = ["spring1.k=23", "spring2.d=0.9", "mass1.x_start=0.3"];
    Experiment {
        settings: settings(system, &texts).unwrap(),
        ..Experiment::new(stepping(1e-3, schedule))
    }
}

fn steps(master: &mut Master, count: usize) -> Vec<u64> {
    let mut bits = Vec::new();
    for _ in 0..count {
        master.step().unwrap();
        bits.extend(master.exchange().values.iter().map(|v| v.to_bits()));
    }
    bits
}

/// More steps are asked for by the environment: `ISOLATED_STEPS=100000`.
#[test]
fn isolated_components_give_the_same_bits() {
    let plain = system("isolated", &oscillators(2)).unwrap();
    let count = std::env::var("ISOLATED_STEPS").map_or(300, |steps| steps.parse().unwrap());
    for schedule in SCHEDULES {
        let of = |system: &System| {
            let mut master = experiment(system, schedule).start(system).unwrap();
            steps(&mut master, count)
        };
        let alone = of(&plain);
        assert!(alone.iter().any(|b| f64::from_bits(*b) != 0.0));
        for components in [&["all"][..], &["spring*"], &["mass2"]] {
            assert!(
                of(&isolated(&plain, components)) == alone,
                "{schedule:?}, {components:?}"
            );
        }
    }
}

#[test]
fn an_annotation_isolates_its_component() {
    let said = "<ssd:Annotations><ssc:Annotation type=\"io.github.hdrm-fmu.process\"/></ssd:Annotations></ssd:Component>";
    let annotated = oscillators(2).replacen("</ssd:Component>", said, 1);
    let annotated = system("isolated-annotated", &annotated).unwrap();
    assert_eq!(annotated.structure.isolated, ["spring1"]);
    let isolated: Vec<_> = (annotated.fmus.iter().map(|fmu| fmu.is_isolated())).collect();
    assert_eq!(isolated, [true, false, false, false]);
    let plain = system("isolated-unannotated", &oscillators(2)).unwrap();
    let of = |system: &System| {
        let experiment = experiment(system, Schedule::Standard);
        steps(&mut experiment.start(system).unwrap(), 50)
    };
    assert!(of(&annotated) == of(&plain));
}

/// With threads besides, and a step that is divided: more calls are begun at a time than the memory
/// has places for.
#[test]
fn processes_threads_and_rates_go_together() {
    let mut plain = system("isolated-rates", &oscillators(2)).unwrap();
    plain.structure.rates = vec![("mass1".into(), 1e-5), ("spring2".into(), 2e-3)];
    let mut other = isolated(&plain, &["mass1", "spring2"]);
    other.structure.rates = plain.structure.rates.clone();
    let of = |system: &System, threads| {
        let mut experiment = experiment(system, Schedule::GaussSeidel);
        experiment.threads = threads;
        steps(&mut experiment.start(system).unwrap(), 50)
    };
    let alone = of(&plain, 1);
    assert!(of(&other, 1) == alone && of(&other, 2) == alone);
}

#[test]
fn isolated_components_go_back_to_a_saved_state() {
    let system = isolated(
        &system("isolated-saved", &oscillators(2)).unwrap(),
        &["all"],
    );
    let mut master = experiment(&system, Schedule::GaussSeidel)
        .start(&system)
        .unwrap();
    steps(&mut master, 20);
    let saved = master.save().unwrap();
    let first = steps(&mut master, 20);
    master.restore(&saved).unwrap();
    assert!(steps(&mut master, 20) == first);
}

/// The verdict names the components that are in processes, and says nothing where there are none.
#[test]
fn the_verdict_names_isolated_components() {
    let plain = system("isolated-named", &oscillators(2)).unwrap();
    for (system, note) in [
        (isolated(&plain, &["spring1", "mass2"]), true),
        (plain, false),
    ] {
        let master = experiment(&system, Schedule::Standard).start(&system);
        let outcome = simulate::run(&system, master.unwrap(), 0.6, &|_, _| (), |_| Ok(())).unwrap();
        let verdict = outcome.verdict.to_string();
        let names = "  - in a process of its own: spring1, mass2\n";
        assert_eq!(format!("{verdict}\n").contains(names), note, "{verdict}");
        assert_eq!(verdict.contains("process of its own"), note, "{verdict}");
    }
}

/// A run of `h2.fmu` or `h3.fmu` in a process of its own, next to another FMU: exit code, what was
/// printed, rows. Nothing is left in the folder for temporary files.
fn run(folder: &Path, fmu: &str, asked: &str, more: &[&str]) -> (i32, String, usize) {
    let temporary = folder.join("temporary");
    fs::create_dir_all(&temporary).unwrap();
    let csv = folder.join("out.csv");
    let _ = fs::remove_file(&csv);
    let done = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["run", fmu])
        .arg(folder.join("plain.fmu"))
        .args("--isolate h* --quiet --step 0.1 --stop-time 1 --signals * --csv".split(' '))
        .arg(&csv)
        .args(more)
        .env("HOSTILE", asked)
        .env("TMPDIR", &temporary)
        .output()
        .unwrap();
    let text = [done.stdout, done.stderr].concat();
    let rows = fs::read_to_string(&csv).map_or(0, |text| text.lines().count() - 1);
    assert_eq!(fs::read_dir(&temporary).unwrap().count(), 0, "{asked}");
    let code = done.status.code().unwrap_or(-1);
    (code, String::from_utf8_lossy(&text).into_owned(), rows)
}

/// However a component ends its process, and in whatever call: the call is named, and the rows before
/// it are kept.
#[test]
fn a_component_that_ends_its_process_ends_the_run_with_its_rows() {
    let fmus = packed("isolated-ends");
    plain_fmu("isolated-ends");
    #[rustfmt::skip]
    let rows = [
        ("segv step", "fmiDoStep at t = 0.3 s crashed with a segmentation fault (SIGSEGV)", 4),
        ("abort step", "fmiDoStep at t = 0.3 s called abort (SIGABRT)", 4),
        ("exit step", "fmiDoStep at t = 0.3 s called exit", 4),
        ("_exit step", "its process ended in a step (exit status: 0)", 4),
        ("stack step", "fmiDoStep at t = 0.3 s overflowed its stack (SIGSEGV)", 4),
        ("thread_segv step", "a thread that an FMU has made crashed", 4),
        ("hang step", "fmiDoStep at t = 0.3 s gave no answer within 1 s", 4),
        ("eat step", "fmiDoStep at t = 0.3 s uses", 4),
        ("segv load", "loading the library crashed with a segmentation fault", 0),
        ("hang load", "loading the library gave no answer within 1 s", 0),
        ("exit instantiate", "fmiInstantiate", 0),
        ("_exit instantiate", "its process ended in a rare call", 0),
        ("segv enter", "fmiEnterInitializationMode at t = 0 s crashed", 0),
        ("hang exit", "fmiExitInitializationMode at t = 0 s gave no answer", 0),
        ("abort terminate", "fmiTerminate at t = 1 s called abort", 11),
    ];
    let folder = scratch("isolated-ends");
    let more = ["--call-timeout", "1", "--memory-limit", "60MB"];
    for (k, fmu) in fmus.iter().enumerate() {
        for (asked, part, rows) in rows {
            let part = part.replace("fmi", &format!("fmi{}", k + 2));
            let (code, text, found) = run(&folder, fmu, asked, &more);
            assert_contains(&text, &[&part, &format!("error: h{}", k + 2)]);
            assert_eq!((code, found), (1, rows), "{asked}: {text}");
        }
    }
}

/// What changes no number of others is said, and the run goes on.
#[test]
fn what_a_component_changes_in_its_process_is_said() {
    let [fmu, _] = packed("isolated-changes");
    plain_fmu("isolated-changes");
    let folder = scratch("isolated-changes");
    for (asked, part) in [
        ("none none", "verdict: good"),
        (
            "round step",
            "h2: fmi2DoStep changed the rounding mode; it was put back",
        ),
        ("chdir instantiate", "h2: it changed the working folder"),
        ("locale enter", "h2: it changed the locale"),
        (
            "close exit",
            "h2: it changed the standard streams, which it closed",
        ),
        ("thread_log step", "h2: from a thread (7 times)"),
        ("print load", "prints: first line"),
        (
            "leave step",
            "still ran after fmi2FreeInstance; they ended with its process",
        ),
        ("segv free", "h2: fmi2FreeInstance at t = 1 s crashed"),
        ("segv unload", "h2: unloading the library crashed"),
        ("forms exit", "t = 1.5, n = 42, s = text, fmi2True"),
    ] {
        let (code, text, rows) = run(&folder, &fmu, asked, &[]);
        assert_contains(&text, &[part]);
        assert_eq!((code, rows), (0, 11), "{asked}: {text}");
    }
}

/// Ids of the processes that a process has started.
fn children(of: u32) -> Vec<u32> {
    let file = format!("/proc/{of}/task/{of}/children");
    let text = fs::read_to_string(file).unwrap_or_default();
    text.split_whitespace()
        .map(|id| id.parse().unwrap())
        .collect()
}

fn is_soon(condition: impl Fn() -> bool) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(20) {
        if condition() {
            return true;
        }
        sleep(Duration::from_millis(10));
    }
    false
}

/// Whether a process is there and is no zombie, which nobody may have waited for.
fn lives(id: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    let state = status.rsplit(')').next().unwrap_or_default();
    !matches!(state.trim().chars().next(), None | Some('Z'))
}

/// In the middle of a call that never returns, and between calls.
#[test]
fn no_process_is_left_when_the_master_is_killed() {
    let [fmu, _] = packed("isolated-killed");
    for (asked, step) in [("hang step", "0.1"), ("none none", "1e-7")] {
        let mut master: Child = Command::new(env!("CARGO_BIN_EXE_cosim"))
            .args(["run", &fmu, "--isolate", "all", "--quiet", "--step", step])
            .args(["--stop-time", "10"])
            .env("HOSTILE", asked)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        assert!(is_soon(|| !children(master.id()).is_empty()), "{asked}");
        let hosts = children(master.id());
        sleep(Duration::from_millis(200));
        assert!(hosts.iter().all(|id| lives(*id)), "{asked}");
        master.kill().unwrap();
        master.wait().unwrap();
        assert!(is_soon(|| !hosts.iter().any(|id| lives(*id))), "{asked}");
    }
}

/// A process that is killed from outside is told, too.
#[test]
fn a_killed_process_ends_the_run() {
    let [fmu, _] = packed("isolated-shot");
    let master = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["run", &fmu, "--isolate", "all", "--quiet", "--step", "1e-7"])
        .args(["--stop-time", "10"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    assert!(is_soon(|| !children(master.id()).is_empty()));
    sleep(Duration::from_millis(200));
    for id in children(master.id()) {
        let done = Command::new("kill").args(["-9", &id.to_string()]).status();
        assert!(done.unwrap().success());
    }
    let done = master.wait_with_output().unwrap();
    let error = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_contains(
        &error,
        &["error: h2", "its process ended in ", "signal: 9 (SIGKILL)"],
    );
    assert_eq!(done.status.code(), Some(1));
}

/// What cannot be isolated, and limits without a process, are refused by name.
#[test]
fn what_cannot_be_isolated_is_refused() {
    let [fmu, _] = packed("isolated-refused");
    for (words, part) in [
        (
            "--isolate x",
            "--isolate x: the system has no component of this name; it has h2",
        ),
        (
            "--call-timeout 1",
            "--call-timeout is for components in processes of their own",
        ),
        (
            "--memory-limit 1GB",
            "--memory-limit is for components in processes of their own",
        ),
        (
            "--isolate all --call-timeout 0",
            "--call-timeout 0: it must be a time greater than 0 s",
        ),
        (
            "--isolate all --memory-limit 5",
            "--memory-limit 5: it must be a size such as 500MB",
        ),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        let done = command
            .args(["run", &fmu])
            .args(words.split(' '))
            .output()
            .unwrap();
        assert_contains(&String::from_utf8_lossy(&done.stderr), &[part]);
        assert_eq!(done.status.code(), Some(1), "{words}");
    }
}
