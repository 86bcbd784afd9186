//! Clocks that are connected: an output clock of one component ticks an input clock of another, or
//! its own. The FMU, `ticks.c`, refuses every call that the standard does not allow, and tells of a
//! tick once.

use std::fs;
use std::path::PathBuf;

use allocation_counter::measure;
use cosim::master::{Master, Schedule, Stepping};
use cosim::run::observer::Function;
use cosim::run::simulate::{Experiment, Plan, run_plan};
use cosim::stepping::StepControl;
use cosim::structure::FmuUse;
use cosim::structure::system::System;

use super::events::{H, SCHEDULES, assert_holds, number, run};
use super::foreign::compiled;
use super::support::{load, pack, scratch, settings, stepping};

const IN: &str =
    r#"<Clock name="in" valueReference="1" causality="input" intervalVariability="triggered"/>"#;
const OUT: &str =
    r#"<Clock name="out" valueReference="2" causality="output" intervalVariability="triggered"/>"#;
/// Every 0.25 s from 0.55 s on; a run starts at 0.5 s and has steps of 0.1 s.
const OWN: &str = r#"<Clock name="own" valueReference="3" causality="input" intervalVariability="constant" intervalDecimal="0.25"
    shiftDecimal="0.05"/>"#;
const OTHERS: &str = r#"<Float64 name="u" valueReference="10" causality="input" variability="discrete" start="0" clocks="1"/>
    <Float64 name="y" valueReference="11" causality="output" variability="discrete" clocks="2"/>
    <Int32 name="ins" valueReference="12" causality="output"/><Int32 name="sum" valueReference="13" causality="output"/>
    <Int32 name="owns" valueReference="14" causality="output"/><Int32 name="outs" valueReference="15" causality="output"/>
    <Int32 name="updates" valueReference="16" causality="output"/>
    <Int32 name="mode" valueReference="20" causality="parameter" start="0"/>
    <Float64 name="event" valueReference="30" causality="parameter" start="1e9"/>
    <Int32 name="level" valueReference="31" causality="input" start="0"/>
    <Binary name="bytes" valueReference="40" causality="input" clocks="1" mimeType="application/x-ticks; version=&quot;1&quot;"/>
    <Binary name="bytes_out" valueReference="41" causality="output" clocks="2" mimeType="application/x-ticks;version=1"/>"#;
const ABLE: &str = r#"hasEventMode="true" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true" canSerializeFMUState="true""#;

/// The FMU as a file in the folder `test`, with these clocks.
fn fmu(test: &str, component: &str, clocks: &str, flags: &str) -> PathBuf {
    let folder = scratch(&format!("ticks-{test}"));
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "ticks.so", &["ticks.c"], &["-lm"]);
    let outputs: String = [11, 12, 13, 14, 15, 16, 41]
        .map(|vr| format!("<Output valueReference=\"{vr}\"/>"))
        .concat();
    let text = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="ticks" instantiationToken="t"><CoSimulation modelIdentifier="ticks" {flags}/>
        <ModelVariables>{clocks}{OTHERS}</ModelVariables><ModelStructure>{outputs}</ModelStructure></fmiModelDescription>"#
    );
    let file = folder.join(format!("{component}.fmu"));
    pack(&file, &text, "x86_64-linux", &[&library]);
    file
}

/// Components a, b and c; a has a clock that follows time.
fn try_three(test: &str, connections: &[&str], options: &FmuUse) -> anyhow::Result<System> {
    let clocks = IN.to_string() + OUT;
    let files = ["a", "b", "c"].map(|name| match name {
        "a" => fmu(test, name, &(clocks.clone() + OWN), ABLE),
        _ => fmu(test, name, &clocks, ABLE),
    });
    let connections: Vec<String> = connections.iter().map(ToString::to_string).collect();
    let system = System::from_fmus(&files, &connections, options)?;
    system.wiring()?;
    Ok(system)
}

fn three(test: &str, connections: &[&str]) -> System {
    try_three(test, connections, &FmuUse::default()).unwrap()
}

const CHAIN: [&str; 6] = [
    "a.out=b.in",
    "a.y=b.u",
    "b.out=c.in",
    "b.y=c.u",
    "a.bytes_out=b.bytes",
    "b.bytes_out=c.bytes",
];

fn master(system: &System, start: &[&str], schedule: Schedule) -> Master {
    Master::new(
        system,
        &settings(system, start).unwrap(),
        stepping(H, schedule),
    )
    .unwrap()
}

#[track_caller]
fn assert_numbers(system: &System, master: &Master, expected: &[(&str, f64)]) {
    for (name, value) in expected {
        let found = number(system, master, name);
        assert_eq!(found, *value, "{name}, {:?}", master.stepping().schedule);
    }
}

/// a ticks at 0.55, 0.8, 1.05 and 1.3 s and sends the number of its ticks; b adds 1 and ticks c
/// with that, all at the same instant: 1 + 2 + 3 + 4 = 10 arrive at b, 14 at c.
#[test]
fn a_chain_of_clocks_ticks_in_one_instant() {
    let system = three("chain", &CHAIN);
    for schedule in SCHEDULES {
        let mut master = master(&system, &[], schedule);
        run(&mut master, 9).unwrap();
        let expected = [
            ("a.owns", 4.0),
            ("a.outs", 4.0),
            ("b.ins", 4.0),
            ("c.ins", 4.0),
            ("b.sum", 10.0),
            ("c.sum", 14.0),
        ];
        assert_numbers(&system, &master, &expected);
        let sent = master.text(system.port("c.bytes").unwrap()).unwrap();
        assert_eq!(sent, "04040404", "{schedule:?}");
    }
}

/// The order of components does not matter, nor that a clock ticks in the instant after an input.
#[test]
fn clocks_tick_in_later_instants_and_against_the_order() {
    let connections = ["a.out=c.in", "a.y=c.u", "c.out=b.in", "c.y=b.u"];
    let system = three("later", &connections);
    for schedule in SCHEDULES {
        for late in [
            &[][..],
            &["a.mode=1"],
            &["c.mode=1"],
            &["a.mode=1", "c.mode=1"],
        ] {
            let mut master = master(&system, late, schedule);
            run(&mut master, 9).unwrap();
            // In a later instant c has no input any more, and sends the number of its ticks.
            let sum = if late.contains(&"c.mode=1") {
                10.0
            } else {
                14.0
            };
            let expected = [
                ("c.ins", 4.0),
                ("b.ins", 4.0),
                ("c.sum", 10.0),
                ("b.sum", sum),
            ];
            assert_numbers(&system, &master, &expected);
        }
    }
}

/// At 0.8 s an event of a is found in the step at whose end its clock ticks, too: each ticks the
/// output clock, in one instant after the other with mode 0, in the same one with mode 1, and with
/// mode 2 the event alone. None of these ticks is lost, and who is not reached by a clock stays out
/// of Event Mode with `standard`.
#[test]
fn a_tick_together_with_another_event_is_not_lost() {
    let system = three("together", &["a.out=b.in", "a.y=b.u", "a.outs=b.level"]);
    for schedule in SCHEDULES {
        for (mode, ticks) in [("a.mode=0", 5.0), ("a.mode=1", 4.0), ("a.mode=2", 1.0)] {
            let mut master = master(&system, &[mode, "a.event=0.8"], schedule);
            run(&mut master, 9).unwrap();
            let expected = [("a.owns", 4.0), ("a.outs", ticks), ("b.ins", ticks)];
            assert_numbers(&system, &master, &expected);
            let updates = number(&system, &master, "c.updates");
            assert_eq!(updates <= 1.0, schedule == Schedule::Standard, "{updates}");
        }
    }
}

/// An event that a step finds at 0.73 s is handled at its end, since ticks of a connected clock
/// would else be between the communication points of the others.
#[test]
fn an_event_within_a_step_ticks_at_its_end() {
    let connected = three("within", &["a.out=b.in", "a.y=b.u"]);
    for schedule in SCHEDULES {
        let mut master = master(&connected, &["a.mode=2", "a.event=0.73"], schedule);
        run(&mut master, 2).unwrap();
        assert_numbers(&connected, &master, &[("b.ins", 0.0)]);
        run(&mut master, 2).unwrap();
        assert_numbers(&connected, &master, &[("b.ins", 1.0), ("b.sum", 1.0)]);
    }
}

/// Where steps are repeated, the others are brought to the event of the one that found it, and the
/// clock ticks there: a row has it, and the step after it leads back to the grid. A component that
/// may not return early has its tick at 0.8 s.
#[test]
fn an_event_within_a_repeated_step_ticks_at_its_time() {
    let connected = three("repeated", &["a.out=b.in", "a.y=b.u"]);
    let settings = settings(&connected, &["a.mode=2", "a.event=0.73"]).unwrap();
    for (schedule, repeats) in SCHEDULES
        .map(|schedule| [(schedule, false), (schedule, true)])
        .concat()
    {
        let stepping = Stepping {
            repeats,
            ..stepping(H, schedule)
        };
        let master = Master::new(&connected, &settings, stepping).unwrap();
        let plan = Plan {
            control: StepControl::Repeated,
            ..Plan::to(0.9)
        };
        let mut rows = Vec::new();
        let mut observer = Function(|master: &Master| {
            let ticks = number(&connected, master, "b.ins");
            rows.push((format!("{:.6}", master.time()), ticks));
            Ok(())
        });
        run_plan(&connected, master, &plan, &|_, _| (), &mut observer).unwrap();
        let mut rows = rows.iter().map(|(time, ticks)| (&time[..], *ticks));
        let (first, end) = match repeats {
            true => ("0.730000", "0.900000"),
            false => ("0.800000", "0.900000"),
        };
        let ticked = rows.by_ref().find(|(_, ticks)| *ticks > 0.0);
        assert_eq!(ticked, Some((first, 1.0)), "{schedule:?}");
        assert_eq!(rows.next_back(), Some((end, 1.0)), "{schedule:?}");
    }
    // Nobody passes it on where steps may end early and are not repeated.
    let stepping = Stepping {
        repeats: true,
        ..stepping(H, Schedule::Standard)
    };
    let mut master = Master::new(&connected, &settings, stepping).unwrap();
    run(&mut master, 2).unwrap();
    assert_holds(
        run(&mut master, 1),
        &["its connected clock `out` ticks between two communication points"],
    );
}

/// Ticks that lead round are ended: at once, where each ticks in the next instant, and by the
/// limit of passes; a clock that ticks itself does so once an instant.
#[test]
fn loops_of_clocks_end() {
    let round = three("round", &["a.out=b.in", "b.out=a.in", "a.y=b.u"]);
    for schedule in SCHEDULES {
        let mut same = master(&round, &[], schedule);
        run(&mut same, 9).unwrap();
        assert_numbers(&round, &same, &[("a.ins", 4.0), ("b.ins", 4.0)]);
        let mut endless = master(&round, &["a.mode=1"], schedule);
        let parts = [
            "discrete states of",
            "still change after 100 passes",
            "clocks tick: a.out -> b.in",
        ];
        assert_holds(run(&mut endless, 9), &parts);
    }
}

/// The same bits in one thread, in several, and in processes; and after a state was restored, also
/// from its bytes.
#[test]
fn threads_processes_and_states_change_nothing() {
    let system = three("ways", &CHAIN);
    let isolated = FmuUse {
        isolated: vec!["b".into()],
        ..FmuUse::default()
    };
    let isolated = try_three("ways", &CHAIN, &isolated).unwrap();
    let names = ["a.outs", "b.ins", "b.sum", "c.ins", "c.sum", "b.updates"];
    for schedule in SCHEDULES {
        let mut seen = Vec::new();
        for (system, threads) in [(&system, 1), (&system, 2), (&system, 3), (&isolated, 1)] {
            let experiment = Experiment {
                threads,
                ..Experiment::new(stepping(H, schedule))
            };
            let mut master = experiment.start(system).unwrap();
            let rows = |master: &mut Master| {
                let mut rows = Vec::new();
                for _ in 0..7 {
                    master.step().unwrap();
                    rows.push(names.map(|name| number(system, master, name)));
                    rows.last_mut().unwrap()[0] += master.exchange().values.iter().sum::<f64>();
                    let bytes = master.text(system.port("c.bytes").unwrap()).unwrap();
                    rows.last_mut().unwrap()[1] += 1000.0 * bytes.len() as f64;
                }
                rows
            };
            let mut all = rows(&mut master);
            let saved = master.save().unwrap();
            let first = rows(&mut master);
            master.restore(&saved).unwrap();
            assert_eq!(rows(&mut master), first, "{schedule:?} {threads}");
            all.extend(first);
            seen.push(all);
        }
        assert!(
            seen.iter().all(|rows| *rows == seen[0]),
            "{schedule:?} {seen:?}"
        );
    }
}

#[test]
fn connections_of_clocks_that_cannot_be_are_refused_by_name() {
    let refused = |connections: &[&str], parts: &[&str]| {
        let system = try_three("refused", connections, &FmuUse::default());
        assert_holds(system.map(|_| ()), parts);
    };
    let parts = [
        "connection b.out -> a.own: the clock `a.own` ticks by time (intervalVariability constant)",
    ];
    refused(&["b.out=a.own"], &parts);
    let parts = ["c.out=b.in: this input is driven already, a.out -> b.in"];
    refused(&["a.out=b.in", "c.out=b.in"], &parts);
    refused(
        &["a.out=b.level"],
        &["b.level must be of type Clock, input"],
    );
    let clocks = IN.to_string() + OUT;
    let bare = fmu("refused", "bare", &clocks, "");
    let files = [bare, fmu("refused", "b", &clocks, ABLE)];
    let system = System::from_fmus(&files, &["bare.out=b.in".into()], &FmuUse::default());
    let parts = [
        "`bare` must be used by Co-Simulation with Event Mode (hasEventMode)",
        "clock `out`",
    ];
    assert_holds(system.and_then(|s| s.wiring().map(|_| ())), &parts);
    let mut slow = three("refused", &["a.out=b.in"]);
    slow.structure.rates.push(("b".into(), 2.0 * H));
    let started = Master::new(&slow, &[], stepping(H, Schedule::Jacobi));
    assert_holds(
        started,
        &["`b`, whose clocks are connected", "must not be longer"],
    );
    let mut fast = three("refused", &["a.out=b.in"]);
    fast.structure.rates.push(("b".into(), 0.5 * H));
    let mut started = master(&fast, &[], Schedule::Jacobi);
    run(&mut started, 9).unwrap();
    assert_numbers(&fast, &started, &[("b.ins", 4.0)]);
}

/// Connectors of the types Clock and Binary, as SSP 2.0 has them.
#[test]
fn a_structure_connects_clocks_and_bytes() {
    for name in ["a", "b"] {
        fmu("structure", name, &(IN.to_string() + OUT + OWN), ABLE);
    }
    let text = |mime: [&str; 2], clock: &str| {
        let component = |name: &str, mime: &str| {
            format!(
                r#"<ssd:Component name="{name}" source="{name}.fmu"><ssd:Connectors>
                <ssd:Connector name="in" kind="input"><ssc:{clock}/></ssd:Connector><ssd:Connector name="out" kind="output"><ssc:Clock/></ssd:Connector>
                <ssd:Connector name="bytes" kind="input"><ssc:Binary {mime}/></ssd:Connector>
                <ssd:Connector name="bytes_out" kind="output"><ssc:Binary {mime}/></ssd:Connector></ssd:Connectors></ssd:Component>"#
            )
        };
        let connection = |from: &str, to: &str| {
            format!(
                r#"<ssd:Connection startElement="a" startConnector="{from}" endElement="b" endConnector="{to}"/>"#
            )
        };
        format!(
            r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" version="2.0" name="s"><ssd:System name="s"><ssd:Elements>{}{}</ssd:Elements>
            <ssd:Connections>{}{}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"#,
            component("a", mime[0]),
            component("b", mime[1]),
            connection("out", "in"),
            connection("bytes_out", "bytes")
        )
    };
    let file = scratch("ticks-structure").join("s.ssd");
    let read = |mime: [&str; 2], clock: &str| {
        fs::write(&file, text(mime, clock)).unwrap();
        load(&file).and_then(|system| system.wiring().map(drop).map(|()| system))
    };
    let own = r#"mime-type="application/x-ticks;version=1""#;
    let system = read([own, ""], "Clock").unwrap();
    let mut started = master(&system, &[], Schedule::Standard);
    run(&mut started, 9).unwrap();
    assert_numbers(&system, &started, &[("b.ins", 4.0)]);
    let bytes = system.port("b.bytes").unwrap();
    assert_eq!(started.text(bytes).unwrap(), "04040404");
    let other = r#"mime-type="application/x-other""#;
    let parts = [
        "`a.bytes_out` has the MIME type `application/x-ticks;version=1`, `b.bytes` has `application/x-other`",
    ];
    assert_holds(read([own, other], "Clock").map(drop), &parts);
    let parts = [
        "connector b.bytes",
        "`application/x-other`",
        "`application/x-ticks; version=\"1\"`",
    ];
    assert_holds(read(["", other], "Clock").map(drop), &parts);
    let parts = ["the types differ, Clock and Real"];
    assert_holds(read(["", ""], "Float64").map(drop), &parts);
}

/// Bytes of changing lengths pass without allocations, once their buffers have grown.
#[test]
fn ticks_and_bytes_allocate_nothing() {
    let system = three("allocation", &CHAIN);
    for schedule in SCHEDULES {
        let mut master = master(&system, &[], schedule);
        run(&mut master, 40).unwrap();
        let steps = measure(|| run(&mut master, 40).unwrap());
        let ticks = number(&system, &master, "c.ins");
        assert!(ticks > 30.0, "more than four rounds of lengths");
        assert_eq!(steps.count_total, 0, "{schedule:?}");
    }
}
