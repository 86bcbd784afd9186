//! FMUs of FMI 3.0 that need Event Mode, for clocks or for discrete inputs. The FMU, `events.c`,
//! refuses every call that the standard does not allow.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use cosim::io::input_table::{Column, InputTable, Table};
use cosim::master::{Master, Schedule};
use cosim::run::signals::Inputs;
use cosim::structure::FmuUse;
use cosim::structure::system::System;

use super::foreign::compiled;
use super::support::{assert_contains, pack, scratch, settings, stepping};

pub const H: f64 = 0.1;
pub const SCHEDULES: [Schedule; 3] = [Schedule::Standard, Schedule::Jacobi, Schedule::GaussSeidel];

/// Every 0.25 s.
pub const PERIODIC: &str = r#"<Clock name="clock" valueReference="1" causality="input" intervalVariability="constant" intervalDecimal="0.25"
    shiftDecimal="0.05"/>"#;
pub const CLOCKED: &str = r#"<Float64 name="u" valueReference="10" causality="input" variability="discrete" start="0" clocks="1"/>
    <Float64 name="y" valueReference="11" causality="output" variability="discrete" clocks="1"/>
    <Int32 name="ticks" valueReference="12" causality="output" clocks="1"/>"#;
const COUNTDOWN: &str = r#"<Clock name="late" valueReference="2" causality="input" intervalVariability="countdown"/>
    <Int32 name="late_ticks" valueReference="13" causality="output" clocks="2"/>"#;
const OTHERS: &str = r#"<Float64 name="period" valueReference="6" causality="parameter" start="0.25"/>
    <Float64 name="delay" valueReference="7" causality="parameter" start="0.1"/>
    <Float64 name="early" valueReference="8" causality="parameter" start="1e9"/>
    <Float64 name="shift" valueReference="9" causality="parameter" start="0"/>
    <Int32 name="level" valueReference="20" causality="input" start="0"/>
    <Int32 name="seen" valueReference="21" causality="output"/>
    <Float64 name="x" valueReference="22" causality="output"/>
    <Int32 name="steps" valueReference="23" causality="output"/>
    <Int64 name="whole" valueReference="30" causality="input" start="0"/><Int64 name="whole_out" valueReference="31" causality="output"/>
    <UInt64 name="natural" valueReference="32" causality="input" start="0"/><UInt64 name="natural_out" valueReference="33" causality="output"/>
    <Int32 name="small" valueReference="34" causality="input" start="0"/><Int32 name="small_out" valueReference="35" causality="output"/>
    <String name="text" valueReference="40" causality="input"><Start value=""/></String>
    <String name="text_out" valueReference="41" causality="output"/>
    <Binary name="bytes" valueReference="42" causality="input"/><Binary name="bytes_out" valueReference="43" causality="output"/>
    <Float64 name="T" valueReference="50" causality="input" start="0" unit="degC"/>
    <Float64 name="dT_out" valueReference="51" causality="output" unit="K" relativeQuantity="true"/>
    <Float64 name="T_out" valueReference="52" causality="output" unit="K"/>
    <Float64 name="v" valueReference="60" causality="input" start="0 0"><Dimension start="2"/></Float64>
    <Float64 name="v_out" valueReference="61" causality="output"><Dimension start="2"/></Float64>"#;

/// The FMU as a file `component.fmu` in the folder `test`, with these clocks; `flags` are further
/// attributes of its `CoSimulation`.
pub fn fmu(test: &str, component: &str, clocks: &str, flags: &str) -> PathBuf {
    let folder = scratch(test);
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "events.so", &["events.c"], &["-lm"]);
    let outputs = clocks.to_string() + OTHERS;
    let outputs = outputs
        .split("<")
        .filter(|v| v.contains("causality=\"output\""));
    let outputs: String = outputs
        .map(|v| {
            v.split("valueReference=\"")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
        })
        .map(|reference| format!("<Output valueReference=\"{reference}\" dependencies=\"\"/>"))
        .collect();
    let text = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="events" instantiationToken="t">
        <CoSimulation modelIdentifier="events" {flags}/><UnitDefinitions><Unit name="K"><BaseUnit K="1"/></Unit>
        <Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit></UnitDefinitions>
        <ModelVariables>{clocks}{OTHERS}</ModelVariables><ModelStructure>{outputs}</ModelStructure></fmiModelDescription>"#
    );
    let file = folder.join(format!("{component}.fmu"));
    pack(&file, &text, "x86_64-linux", &[&library]);
    file
}

pub const ABLE: &str = r#"hasEventMode="true" canHandleVariableCommunicationStepSize="true""#;

pub fn alone(test: &str, clocks: &str) -> System {
    System::from_fmus(&[fmu(test, "a", clocks, ABLE)], &[], &FmuUse::default()).unwrap()
}

pub fn two(test: &str, clocks: &str, connections: &[&str]) -> anyhow::Result<System> {
    let files = ["a", "b"].map(|name| fmu(test, name, clocks, ABLE));
    let connections: Vec<String> = connections.iter().map(ToString::to_string).collect();
    System::from_fmus(&files, &connections, &FmuUse::default())
}

pub fn master(system: &System, start: &[&str], schedule: Schedule) -> anyhow::Result<Master> {
    Master::new(system, &settings(system, start)?, stepping(H, schedule))
}

pub fn run(master: &mut Master, steps: usize) -> anyhow::Result<()> {
    (0..steps).try_for_each(|_| master.step())
}

pub fn number(system: &System, master: &Master, name: &str) -> f64 {
    master.number(system.port(name).unwrap()).unwrap()
}

#[track_caller]
pub fn assert_holds(result: anyhow::Result<impl Sized>, parts: &[&str]) {
    assert_contains(&format!("{:#}", result.err().unwrap()), parts);
}

/// From 0.5 s on in steps of 0.1 s; ticks at 0.55 s, 0.8 s, 1.05 s, 1.3 s: the first and the third
/// are between communication points, so that two of ten steps are made in two parts.
#[test]
fn a_periodic_clock_ticks_and_splits_the_step() {
    let system = alone("periodic", &(PERIODIC.to_string() + CLOCKED));
    for schedule in SCHEDULES {
        let mut master = master(&system, &["a.u=3"], schedule).unwrap();
        let mut seen = Vec::new();
        for _ in 0..10 {
            seen.push(number(&system, &master, "a.ticks"));
            master.step().unwrap();
        }
        assert_eq!(
            seen,
            [0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0],
            "{schedule:?}"
        );
        assert_eq!(number(&system, &master, "a.steps"), 12.0, "{schedule:?}");
        assert_eq!(number(&system, &master, "a.y"), 6.0, "{schedule:?}");
        assert_eq!(master.steps(), 10);
    }
}

/// What is remembered of clocks and of clocked and discrete variables belongs to a saved state.
#[test]
fn a_restored_run_ticks_as_it_did() {
    let clocks = PERIODIC.to_string() + CLOCKED + COUNTDOWN;
    let flags = format!("{ABLE} canGetAndSetFMUState=\"true\"");
    let able = System::from_fmus(
        &[fmu("restored", "a", &clocks, &flags)],
        &[],
        &FmuUse::default(),
    )
    .unwrap();
    for schedule in SCHEDULES {
        let mut master = master(&able, &["a.u=3", "a.early=0.97"], schedule).unwrap();
        let mut level = Inputs::new(&able, &[able.port("a.level").unwrap()]).unwrap();
        let mut seen = |master: &mut Master, from: u32| {
            let names = ["a.ticks", "a.y", "a.x", "a.late_ticks", "a.steps", "a.seen"];
            let mut all = Vec::new();
            for k in from..from + 10 {
                level.set(master, &[f64::from(k / 4)]).unwrap();
                master.step().unwrap();
                all.push(names.map(|name| number(&able, master, name)));
            }
            all
        };
        seen(&mut master, 0);
        let saved = master.save().unwrap();
        let first = seen(&mut master, 10);
        assert!(
            first[0] != first[9] && first[9][3] > first[0][3],
            "{first:?}"
        );
        master.restore(&saved).unwrap();
        assert_eq!(seen(&mut master, 10), first, "{schedule:?}");
    }
    let unable = alone("not_restored", &clocks);
    let master = master(&unable, &[], Schedule::Jacobi).unwrap();
    assert_holds(master.save(), &["a (FMU `", "cannot save its state"]);
}

/// The same clock where the FMU says in Initialization Mode how long its period is, and a clock of
/// which it says so at each event: 0.2 s after the level changes.
#[test]
fn intervals_are_asked_for_as_the_kind_of_clock_has_it() {
    for (kind, ticks) in [("fixed", 4.0), ("tunable", 4.0), ("changing", 1.0)] {
        let clock = PERIODIC
            .replace("constant", kind)
            .replace("intervalDecimal=\"0.25\"", "");
        let system = alone(&format!("kind-{kind}"), &(clock + CLOCKED));
        for schedule in SCHEDULES {
            let start = ["a.period=0.3", "a.shift=0.05"];
            let mut master = master(&system, &start, schedule).unwrap();
            run(&mut master, 10).unwrap();
            assert_eq!(
                number(&system, &master, "a.ticks"),
                ticks,
                "{kind} {schedule:?}"
            );
        }
    }
    let system = alone("countdown", COUNTDOWN);
    let level = [system.port("a.level").unwrap()];
    for schedule in SCHEDULES {
        let mut master = master(&system, &["a.delay=0.25"], schedule).unwrap();
        let mut inputs = Inputs::new(&system, &level).unwrap();
        run(&mut master, 2).unwrap();
        assert_eq!(
            number(&system, &master, "a.late_ticks"),
            0.0,
            "{schedule:?}"
        );
        inputs.set(&master, &[7.0]).unwrap();
        run(&mut master, 2).unwrap();
        assert_eq!(
            number(&system, &master, "a.late_ticks"),
            0.0,
            "{schedule:?}"
        );
        run(&mut master, 1).unwrap();
        assert_eq!(
            number(&system, &master, "a.late_ticks"),
            1.0,
            "0.95 s, {schedule:?}"
        );
        assert_eq!(number(&system, &master, "a.steps"), 6.0, "{schedule:?}");
    }
    // At once: at the event itself.
    let mut master = master(&system, &["a.delay=0", "a.level=2"], Schedule::Standard).unwrap();
    run(&mut master, 1).unwrap();
    assert_eq!(number(&system, &master, "a.late_ticks"), 1.0);
}

/// y = 2 u at each tick goes to the other one at the same tick, or at its next one.
#[test]
fn clocked_values_pass_at_ticks() {
    let clocks = PERIODIC.to_string() + CLOCKED;
    let system = two("clocked", &clocks, &["a.y=b.u"]).unwrap();
    for schedule in SCHEDULES {
        let mut master = master(&system, &["a.u=3"], schedule).unwrap();
        run(&mut master, 4).unwrap();
        assert_eq!(number(&system, &master, "b.y"), 12.0, "{schedule:?}");
        assert_eq!(number(&system, &master, "b.ticks"), 2.0, "{schedule:?}");
    }
}

/// A level that changes at an event of one becomes an event of the other; x, the integral of 1, is
/// not touched.
#[test]
fn discrete_inputs_change_in_event_mode() {
    let system = two("discrete-inputs", "", &["a.seen=b.level"]).unwrap();
    let level = [system.port("a.level").unwrap()];
    for schedule in SCHEDULES {
        let mut master = master(&system, &[], schedule).unwrap();
        let mut inputs = Inputs::new(&system, &level).unwrap();
        run(&mut master, 2).unwrap();
        inputs.set(&master, &[5.0]).unwrap();
        run(&mut master, 3).unwrap();
        assert_eq!(number(&system, &master, "b.seen"), 5.0, "{schedule:?}");
        let x = number(&system, &master, "b.x");
        assert!((x - 0.5).abs() < 10.0 * f64::EPSILON, "{x}");
        master.terminate().unwrap();
    }
}

/// What the events of a communication point change is in the values of that point, also if one
/// event follows another: `level` goes through a, b and c in the order of the system or against it.
/// With `standard` a value that goes through a component arrives a step later.
#[test]
fn events_of_a_point_are_complete_before_it_is_seen() {
    for links in [
        ["a.seen=b.level", "b.seen=c.level"],
        ["c.seen=b.level", "b.seen=a.level"],
    ] {
        let files = ["a", "b", "c"].map(|name| fmu("complete", name, "", ABLE));
        let links = links.map(String::from);
        let system = System::from_fmus(&files, &links, &FmuUse::default()).unwrap();
        let [first, last] = [&links[0][..1], &links[1][7..8]];
        for schedule in SCHEDULES {
            for threads in [1, 2] {
                let mut master =
                    Master::with_threads(&system, &[], stepping(H, schedule), threads).unwrap();
                let column = Column {
                    name: format!("{first}.level"),
                    unit: None,
                    values: vec![0.0, 0.0, 5.0, 5.0],
                };
                let table = Table {
                    times: vec![0.0, 0.7, 0.7, 2.0],
                    columns: vec![column],
                };
                let read = InputTable::new(&system, &table).unwrap();
                master.feed(read).unwrap();
                let mut seen = Vec::new();
                for _ in 0..6 {
                    seen.push(number(&system, &master, &format!("{last}.seen")));
                    master.step().unwrap();
                }
                // 0.5 s, 0.6 s, 0.7 s, ...
                let late = if schedule == Schedule::Standard { 3 } else { 0 };
                let expected: Vec<f64> = (0..6)
                    .map(|k| if k >= 2 + late { 5.0 } else { 0.0 })
                    .collect();
                assert_eq!(seen, expected, "{links:?} {schedule:?} {threads}");
            }
        }
    }
}

/// The rate doubles at an event in the middle of a step, at 0.63 s: x = 0.13 + 2 · 0.37 at 1 s.
#[test]
fn an_early_return_is_obeyed() {
    let system = alone("early", "");
    for schedule in SCHEDULES {
        let mut master = master(&system, &["a.early=0.63"], schedule).unwrap();
        run(&mut master, 5).unwrap();
        let x = number(&system, &master, "a.x");
        assert!((x - 0.87).abs() < 10.0 * f64::EPSILON, "{schedule:?} {x}");
        assert_eq!(number(&system, &master, "a.steps"), 6.0);
    }
}

/// No shortened last step where one of them cannot make it, and a step that an internal one does
/// not divide is remarks; a second instance is refused where there may be one only.
#[test]
fn what_an_fmu_cannot_do_is_obeyed_or_said() {
    let flags = r#"hasEventMode="true" fixedInternalStepSize="0.04" canBeInstantiatedOnlyOncePerProcess="true""#;
    let system =
        System::from_fmus(&[fmu("limits", "a", "", flags)], &[], &FmuUse::default()).unwrap();
    assert_eq!(
        system.default_step(1.0).map(|chosen| chosen.step),
        Some(0.04)
    );
    let started = master(&system, &[], Schedule::Standard).unwrap();
    let second = master(&system, &[], Schedule::Standard);
    assert_holds(
        second,
        &["a: FMU `", "allows only one instance per process"],
    );
    let outcome =
        cosim::run::simulate::run(&system, started, 0.95, &|_, _| (), |_| Ok(())).unwrap();
    let verdict = outcome.verdict.to_string();
    assert_contains(
        &verdict,
        &[
            "the last step is not shortened to end at 0.95 s, because `a` cannot vary its step",
            "the communication step of 0.1 s is no multiple of the fixed internal step of `a`, 0.04 s",
        ],
    );
    assert!(
        (outcome.simulated - 0.4).abs() < 1e-12,
        "{}",
        outcome.simulated
    );
    master(&system, &[], Schedule::Standard).unwrap();
}

#[test]
fn clocks_that_cannot_be_served_are_refused() {
    let clocks = PERIODIC.to_string() + CLOCKED;
    let of = |name: &str, clocks: &str, flags: &str| {
        System::from_fmus(
            &[fmu("refused", name, clocks, flags)],
            &[],
            &FmuUse::default(),
        )
        .unwrap()
    };
    let fixed = of("fixed", &clocks, "hasEventMode=\"true\"");
    let mut started = master(&fixed, &[], Schedule::Standard).unwrap();
    let parts = [
        "`fixed` cannot vary its step",
        "its clock `clock` ticks at 0.55 s, between",
    ];
    assert_holds(run(&mut started, 1), &parts);
    let bare = of("bare", &clocks, "");
    let parts = ["FMU `", "has the clock `clock` but no Event Mode"];
    assert_holds(master(&bare, &[], Schedule::Standard), &parts);
    let endless = clocks.replace("0.25", "0");
    let parts = ["its clock `clock` has the interval 0 s"];
    assert_holds(
        master(&of("endless", &endless, ABLE), &[], Schedule::Standard),
        &parts,
    );
    let triggered = clocks.replace("constant", "triggered");
    let gaps = of("triggered", &triggered, ABLE)
        .find_gaps(&BTreeSet::new())
        .unwrap();
    let is_clock = |name: &String| name.ends_with("clock");
    assert!(!gaps.unmentioned_inputs.iter().any(is_clock));
    let remarks = gaps.remarks;
    let is_reported = |r: &String| r.contains("clock `clock` is triggered from outside");
    assert!(remarks.iter().any(is_reported), "{remarks:?}");
}
