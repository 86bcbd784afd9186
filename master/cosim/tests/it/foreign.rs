//! FMUs as other tools make them: attributes that nobody asked for, libraries of other names,
//! functions that are missing, nothing said of dependencies.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use cosim::cli::RunArgs;
use cosim::exchange::{Exchange, Order};
use cosim::fmu::Fmu;
use cosim::master::{Master, Schedule};
use cosim::run::simulate;
use cosim::structure::system::System;

use super::support::{
    assert_contains, edited, fmu, link, load, oscillator, oscillator_links, pack, scratch,
    settings, ssd, stepping,
};

/// A library of the C sources `sources` in the folder `folder`.
#[cfg(unix)]
pub fn compiled(folder: &Path, library: &str, sources: &[&str], more: &[&str]) -> PathBuf {
    let file = folder.join(library);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fmus");
    let done = Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .arg(&file)
        .args(sources.iter().map(|source| root.join(source)))
        .args(more)
        .status();
    assert!(done.expect("a C compiler").success());
    file
}

const PLAIN: &str = r#"<?xml version="1.0" encoding="ISO-8859-1"?>
<fmiModelDescription xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="x" fmiVersion="2.0"
  modelName="plain" guid="{1}"><CoSimulation modelIdentifier="plain-c" needsExecutionTool="true"/><ModelVariables>
  <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
  <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
  <ScalarVariable name="n" valueReference="2" causality="parameter" variability="fixed"><Integer start="1"/></ScalarVariable>
  </ModelVariables><ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure></fmiModelDescription>"#;

/// A system of one such FMU, with further files beside its library.
#[cfg(unix)]
fn plain(name: &str, libraries: &[&Path]) -> System {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    pack(&folder.join("plain.fmu"), PLAIN, "linux64", libraries);
    let structure = r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" version="1.0" name="s"><ssd:System name="s">
        <ssd:Elements><ssd:Component name="plain" source="plain.fmu"><ssd:Connectors><ssd:Connector name="u" kind="input"/>
        <ssd:Connector name="y" kind="output"/></ssd:Connectors></ssd:Component></ssd:Elements></ssd:System>
        </ssd:SystemStructureDescription>"#;
    let file = folder.join("plain.ssd");
    fs::write(&file, structure).unwrap();
    load(&file).unwrap()
}

fn run_args() -> RunArgs {
    RunArgs {
        step: Some(0.1),
        stop_time: Some(1.0),
        settings: vec!["plain.u=21".into()],
        ..RunArgs::default()
    }
}

/// The FMU alone, `plain.fmu` in the folder `name`.
#[cfg(unix)]
pub fn plain_fmu(name: &str) {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "plain-c.so", &["plain.c"], &[]);
    drop(plain(name, &[&library]));
}

/// A hyphen in the identifier, a library of another name, namespaces on the root, an encoding, and
/// a library that lacks half of the functions: it runs, and what is odd is told.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn an_fmu_written_by_hand_runs_with_remarks() {
    let folder = scratch("plain-c");
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "watertank.so", &["plain.c"], &[]);
    let system = plain("plain-c", &[&library]);
    let args = run_args();
    let experiment = args.experiment(&system).unwrap();
    let remarks = args.judge_gaps(&system, &experiment).unwrap().to_string();
    assert_contains(&remarks, &["plain-c", "watertank.so", "needsExecutionTool"]);
    let mut master = experiment.start(&system).unwrap();
    master.step().unwrap();
    let y = system.port("plain.y").unwrap();
    assert_eq!(master.number(y).unwrap(), 42.0);
    // It discards the step beyond 1 s: the last successful time is told, and what it said though it
    // says not who it is.
    let mut args = run_args();
    args.stop_time = Some(2.0);
    let experiment = args.experiment(&system).unwrap();
    let started = experiment.start(&system).unwrap();
    let error = simulate::run(&system, started, 2.0, &|_, _| (), |_| Ok(())).unwrap_err();
    let text = format!("{error:#}");
    assert_contains(
        &text,
        &[
            "last successful time of plain",
            "fmi2Discard",
            "stopped by hand at 42 percent",
        ],
    );
    // What a library lacks is missed when it is asked for.
    let mut args = run_args();
    args.settings = vec!["plain.n=3".into()];
    let error = args
        .experiment(&system)
        .unwrap()
        .start(&system)
        .err()
        .unwrap();
    assert!(
        error
            .to_string()
            .contains("its library does not export fmi2SetInteger"),
        "{error:#}"
    );
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn steps_in_the_background_are_refused() {
    let folder = scratch("pending");
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "plain-c.so", &["plain.c"], &["-DPENDING"]);
    let system = plain("pending", &[&library]);
    let mut master = run_args()
        .experiment(&system)
        .unwrap()
        .start(&system)
        .unwrap();
    let error = format!("{:#}", master.step().unwrap_err());
    assert_contains(
        &error,
        &[
            "plain (FMU `",
            "at t = 0 s",
            "fmi2Pending",
            "in the background are not supported",
        ],
    );
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_library_beside_the_own_one_is_found() {
    let folder = scratch("helped");
    fs::create_dir_all(&folder).unwrap();
    let helper = compiled(
        &folder,
        "libhelper.so",
        &["helper.c"],
        &["-Wl,-soname,libhelper.so"],
    );
    let (own, path) = ("plain-c.so", folder.display().to_string());
    let library = compiled(
        &folder,
        own,
        &["plain.c"],
        &["-DNEEDS_HELPER", "-L", &path, "-lhelper"],
    );
    let system = plain("helped", &[&library, &helper]);
    let master = run_args()
        .experiment(&system)
        .unwrap()
        .start(&system)
        .unwrap();
    assert_eq!(
        master.number(system.port("plain.y").unwrap()).unwrap(),
        42.0
    );
}

/// The oscillator with descriptions that say nothing of dependencies.
fn undeclared(name: &str, structure: &str, which: &[&str]) -> System {
    edited(name, structure, |example, text| {
        let mut text = text.to_string();
        while which.contains(&example)
            && let Some(start) = text.find(" dependencies=\"")
        {
            let end = start + 15 + text[start + 15..].find('"').unwrap() + 1;
            text.replace_range(start..end, "");
        }
        text
    })
    .unwrap()
}

fn start() -> [&'static str; 5] {
    [
        "spring.k=23",
        "spring.d=0.9",
        "mass.m=1.7",
        "mass.x_start=0.31",
        "mass.x_dot_start=-0.83",
    ]
}

/// Position and velocity after 100 steps of 0.01 s.
fn states(system: &System, schedule: Schedule) -> Vec<u64> {
    let settings = settings(system, &start()).unwrap();
    let mut master = Master::new(system, &settings, stepping(0.01, schedule)).unwrap();
    let ports = ["mass.x", "mass.x_dot"].map(|name| system.port(name).unwrap());
    (0..100)
        .flat_map(|_| {
            master.step().unwrap();
            ports.map(|port| master.number(port).unwrap().to_bits())
        })
        .collect()
}

/// A force whose dependencies nobody declares is that of the motion one step before, as with the
/// schedule `standard`; where it is said that it may be read again, all is as if the dependencies
/// were declared.
#[test]
fn outputs_without_declared_dependencies_are_read_right_after_the_step() {
    let declared = super::support::system("declared", &oscillator()).unwrap();
    let mut spring = undeclared("undeclared", &oscillator(), &["spring"]);
    assert_eq!(spring.read_once(true).unwrap(), ["spring.F"]);
    let shown = |system: &System| {
        let wiring = system.wiring().unwrap();
        let exchange = Exchange::new(&wiring, Order::Stages, |_| true).unwrap();
        exchange.describe(&wiring)
    };
    let once = "right after the step, before any input is set\n  get 1 value, spring.F\nstage 1\n";
    assert!(shown(&spring).starts_with(once), "{}", shown(&spring));
    assert!(shown(&declared).starts_with("stage 1\n"));
    for schedule in [Schedule::Standard, Schedule::Jacobi] {
        assert_eq!(
            states(&spring, schedule),
            states(&declared, Schedule::Standard),
            "{schedule:?}"
        );
    }
    spring.structure.feedthrough.push("spring".into());
    for schedule in [Schedule::Jacobi, Schedule::GaussSeidel] {
        assert_eq!(
            states(&spring, schedule),
            states(&declared, schedule),
            "{schedule:?}"
        );
    }
    assert_ne!(
        states(&declared, Schedule::Jacobi),
        states(&declared, Schedule::Standard)
    );
    // The same said in the structure.
    let said = "<ssd:Annotations><ssc:Annotation type=\"io.github.hdrm-fmu.feedthrough\"/></ssd:Annotations></ssd:Component>";
    let annotated = oscillator().replacen("</ssd:Component>", said, 1);
    let annotated = undeclared("annotated", &annotated, &["spring"]);
    assert_eq!(annotated.structure.feedthrough, ["spring"]);
    assert_eq!(
        states(&annotated, Schedule::Jacobi),
        states(&declared, Schedule::Jacobi)
    );
}

/// Nothing is declared at all, so that all may be one loop: initialization passes the values until
/// nothing changes.
#[test]
fn initialization_settles_loops_that_nobody_declared() {
    let both = undeclared("both", &oscillator(), &["spring", "mass"]);
    let declared = super::support::system("declared-too", &oscillator()).unwrap();
    for schedule in [Schedule::Standard, Schedule::Jacobi, Schedule::GaussSeidel] {
        let read = |system: &System| {
            let settings = settings(system, &start()).unwrap();
            let master = Master::new(system, &settings, stepping(0.01, schedule)).unwrap();
            ["spring.F_mean", "mass.x_ddot"]
                .map(|name| master.number(system.port(name).unwrap()).unwrap().to_bits())
        };
        assert_eq!(read(&both), read(&declared), "{schedule:?}");
    }
    assert_eq!(
        states(&both, Schedule::Standard),
        states(&declared, Schedule::Standard)
    );
}

/// F = −k x − m_s x_ddot with x_ddot = F/m: each pass divides the error by −m/m_s, so that it never
/// comes to rest; and a loop that is declared is refused by the staged schedules, while `standard`
/// takes it where it comes to rest.
#[test]
fn what_does_not_settle_is_named() {
    let links = oscillator_links("", "", "") + &link(("mass", "x_ddot"), ("spring", "x_ddot"), "");
    let system = undeclared("restless", &ssd(&links), &["spring", "mass"]);
    let mut texts = start().to_vec();
    let start = |texts: &[&str], system: &System, schedule| {
        let settings = settings(system, texts).unwrap();
        Master::new(system, &settings, stepping(0.01, schedule)).map(|_| ())
    };
    start(&texts, &system, Schedule::Standard).unwrap();
    texts.push("spring.m=0.5");
    let error = start(&texts, &system, Schedule::Standard)
        .unwrap_err()
        .to_string();
    assert_contains(
        &error,
        &[
            "in initialization mass.x_ddot still change",
            "after 5 passes",
        ],
    );
    let declared = super::support::system("declared-loop", &ssd(&links)).unwrap();
    let refused = start(&texts[..5], &declared, Schedule::Jacobi)
        .unwrap_err()
        .to_string();
    assert!(refused.contains("algebraic loop"), "{refused}");
    start(&texts[..5], &declared, Schedule::Standard).unwrap();
}

/// Nothing is odd about an FMU that our kit made.
#[test]
fn our_fmu_has_no_remarks() {
    let ours = Fmu::load("Spring.fmu", fmu("spring")).unwrap();
    assert!(ours.remarks.is_empty(), "{:?}", ours.remarks);
}
