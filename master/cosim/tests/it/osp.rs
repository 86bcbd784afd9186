//! Systems of the Open Simulation Platform: what their functions, groups and steps compute, and what
//! is refused.

use std::fs;
use std::path::PathBuf;

use cosim::exchange::faults::Faults;
use cosim::io::scenario;
use cosim::master::{Master, Schedule, Stepping};
use cosim::structure::system::System;

use super::foreign::compiled;
use super::program::cosim;
use super::support::{assert_contains, load, pack, scratch};

const H: f64 = 0.0625;
const START: f64 = 0.5;

const GROUPS: &str = r#"<OspModelDescription xmlns="https://open-simulation-platform.com/OspModelDescription/1.0.1" version="1.0">
  <UnitDefinitions><Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit></UnitDefinitions>
  <VariableGroups>
    <Generic name="last two"><Force name="second"><Variable ref="y2" unit="N"/></Force><Variable ref="y3"/></Generic>
    <Generic name="inputs"><Force name="input of the second"><Variable ref="u2" unit="N"/></Force><Variable ref="u3"/></Generic>
    <Generic name="first"><Variable ref="y1"/></Generic><Generic name="all"><Variable ref="y1"/><Variable ref="y2"/><Variable ref="y3"/></Generic>
  </VariableGroups></OspModelDescription>"#;

/// The system that the tests edit: a Sum over three components, a VectorSum over groups in groups, a
/// transformation, a group, a component with steps of its own.
const GOOD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1">
  <StartTime>0.5</StartTime>
  <EndTime>3.5</EndTime>
  <BaseStepSize>0.0625</BaseStepSize>
  <Algorithm>fixedStep</Algorithm>
  <Simulators>
    <Simulator name="one" source="../fmus/Lags.fmu"><InitialValues>
      <InitialValue variable="k"><Real value="1.7"/></InitialValue>
      <InitialValue variable="start"><Real value="0.3"/></InitialValue></InitialValues></Simulator>
    <Simulator name="number two" source="file:../fmus/Lags.fmu" stepSize="0.13"><InitialValues>
      <InitialValue variable="start"><Real value="-0.7"/></InitialValue>
      <InitialValue variable="integerIn"><Integer value="4"/></InitialValue>
      <InitialValue variable="booleanIn"><Boolean value="true"/></InitialValue></InitialValues></Simulator>
    <Simulator name="three" source="../fmus/Lags.fmu"/>
  </Simulators>
  <Functions>
    <LinearTransformation name="scaled" factor="-0.5" offset="0.25"/>
    <Sum name="sum" inputCount="3"/>
    <VectorSum name="vector" inputCount="2" dimension="2"/>
  </Functions>
  <Connections>
    <VariableConnection>
      <Variable simulator="number two" name="u1"/>
      <Variable simulator="one" name="y1"/>
    </VariableConnection>
    <VariableGroupConnection>
      <VariableGroup simulator="number two" name="last two"/>
      <VariableGroup simulator="one" name="inputs"/>
    </VariableGroupConnection>
    <SignalConnection><Variable simulator="one" name="y2"/><Signal function="scaled" name="in"/></SignalConnection>
    <SignalConnection><Signal function="scaled" name="out"/><Variable simulator="number two" name="u2"/></SignalConnection>
    <SignalConnection><Variable simulator="one" name="y1"/><Signal function="sum" name="in[0]"/></SignalConnection>
    <SignalConnection><Variable simulator="number two" name="y3"/><Signal function="sum" name="in[1]"/></SignalConnection>
    <SignalConnection><Variable simulator="three" name="y1"/><Signal function="sum" name="in[2]"/></SignalConnection>
    <SignalConnection><Signal function="sum" name="out"/><Variable simulator="three" name="u1"/></SignalConnection>
    <SignalGroupConnection><VariableGroup simulator="one" name="last two"/><SignalGroup function="vector" name="in[0]"/></SignalGroupConnection>
    <SignalGroupConnection><VariableGroup simulator="number two" name="last two"/><SignalGroup function="vector" name="in[1]"/></SignalGroupConnection>
    <SignalGroupConnection><SignalGroup function="vector" name="out"/><VariableGroup simulator="three" name="inputs"/></SignalGroupConnection>
  </Connections>
</OspSystemStructure>
"#;

/// The connections of the same system in SSP: `one` and `number two` give to each other and to
/// `three`.
fn connections() -> String {
    let link = |from: (&str, &str), to: (&str, &str), content: &str| {
        format!(
            r#"<ssd:Connection startElement="{}" startConnector="{}" endElement="{}" endConnector="{}" suppressUnitConversion="true">{content}</ssd:Connection>"#,
            from.0, from.1, to.0, to.1
        )
    };
    let sum = r#"<ssd:Annotations><ssc:Annotation type="io.github.hdrm-fmu.sum"><Sum/></ssc:Annotation></ssd:Annotations>"#;
    let two = "number two";
    [
        link(("one", "y1"), (two, "u1"), ""),
        link((two, "y2"), ("one", "u2"), ""),
        link((two, "y3"), ("one", "u3"), ""),
        link(
            ("one", "y2"),
            (two, "u2"),
            r#"<ssc:LinearTransformation factor="-0.5" offset="0.25"/>"#,
        ),
        link(("one", "y1"), ("three", "u1"), sum),
        link((two, "y3"), ("three", "u1"), sum),
        link(("three", "y1"), ("three", "u1"), sum),
        link(("one", "y2"), ("three", "u2"), sum),
        link((two, "y2"), ("three", "u2"), sum),
        link(("one", "y3"), ("three", "u3"), sum),
        link((two, "y3"), ("three", "u3"), sum),
    ]
    .concat()
}

fn ssp() -> String {
    let component = |name: &str, values: &[(&str, &str, &str)], more: &str| {
        let connectors = [1, 2, 3].map(|k| {
            format!(
                r#"<ssd:Connector name="u{k}" kind="input"><ssc:Real/></ssd:Connector><ssd:Connector name="y{k}" kind="output"><ssc:Real/></ssd:Connector>"#
            )
        });
        let values = values.iter().map(|(name, kind, value)| {
            format!(r#"<ssv:Parameter name="{name}"><ssv:{kind} value="{value}"/></ssv:Parameter>"#)
        });
        format!(
            r#"<ssd:Component name="{name}" source="../fmus/Lags.fmu"><ssd:Connectors>{}</ssd:Connectors><ssd:ParameterBindings><ssd:ParameterBinding>
            <ssd:ParameterValues><ssv:ParameterSet version="1.0" name="v"><ssv:Parameters>{}</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues>
            </ssd:ParameterBinding></ssd:ParameterBindings>{more}</ssd:Component>"#,
            connectors.concat(),
            values.collect::<String>()
        )
    };
    let rate = r#"<ssd:Annotations><ssc:Annotation type="io.github.hdrm-fmu.rate"><Rate step="0.125"/></ssc:Annotation></ssd:Annotations>"#;
    let one = component("one", &[("k", "Real", "1.7"), ("start", "Real", "0.3")], "");
    let two = [
        ("start", "Real", "-0.7"),
        ("integerIn", "Integer", "4"),
        ("booleanIn", "Boolean", "true"),
    ];
    let (two, three) = (
        component("number two", &two, rate),
        component("three", &[], ""),
    );
    format!(
        r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" xmlns:ssv="v" version="1.0" name="s"><ssd:System name="s">
        <ssd:Elements>{one}{two}{three}</ssd:Elements><ssd:Connections>{}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"#,
        connections()
    )
}

/// The FMU in `fmus`, its groups next to it, and `text` in `config`; returns the path of the
/// latter.
fn written(name: &str, file: &str, text: &str) -> PathBuf {
    let folder = scratch(name);
    for part in ["fmus", "config"] {
        fs::create_dir_all(folder.join(part)).unwrap();
    }
    let library = compiled(&folder, "lags.so", &["lags.c"], &[]);
    let description = include_str!("../fmus/lags.xml");
    pack(
        &folder.join("fmus/Lags.fmu"),
        description,
        "linux64",
        &[&library],
    );
    fs::write(folder.join("fmus/Lags_OspModelDescription.xml"), GROUPS).unwrap();
    let path = folder.join("config").join(file);
    fs::write(&path, text).unwrap();
    path
}

const SHOWN: [&str; 9] = [
    "one.y1",
    "one.y2",
    "one.y3",
    "number two.y1",
    "number two.y2",
    "number two.y3",
    "three.y1",
    "three.y2",
    "three.y3",
];

/// All outputs at all communication points.
fn rows(system: &System, schedule: Schedule, threads: usize) -> Vec<[f64; 9]> {
    let stepping = Stepping::new(START, H, schedule);
    let mut master = Master::with_threads(system, &[], stepping, threads).unwrap();
    let ports = SHOWN.map(|name| system.port(name).unwrap());
    let mut rows = vec![ports.map(|port| master.number(port).unwrap())];
    for _ in 0..48 {
        master.step().unwrap();
        rows.push(ports.map(|port| master.number(port).unwrap()));
    }
    rows
}

/// The system by hand: values pass once a step, those of `number two` every other one.
fn by_hand() -> Vec<[f64; 9]> {
    let (k, starts) = ([1.7, 1.0, 1.0], [0.3, -0.7, 0.0]);
    let mut x = starts.map(|start: f64| [start, start * 2.0, start * 3.0]);
    let (mut two, mut u_two, mut rows) = (x[1], [0.0; 3], vec![x.concat().try_into().unwrap()]);
    for n in 0..48 {
        let [one, _, three] = x;
        if n % 2 == 0 {
            two = x[1];
            u_two = [one[0], -0.5 * one[1] + 0.25, 0.0];
        }
        let u = [
            [0.0, two[1], two[2]],
            u_two,
            [one[0] + two[2] + three[0], one[1] + two[1], one[2] + two[2]],
        ];
        for (i, h) in [(0, H), (1, 2.0 * H), (2, H)] {
            if i == 1 && n % 2 == 1 {
                continue;
            }
            for j in 0..3 {
                x[i][j] += h * (u[i][j] - k[i] * x[i][j]);
            }
        }
        let shown = if n % 2 == 1 { x[1] } else { two };
        rows.push([x[0], shown, x[2]].concat().try_into().unwrap());
    }
    rows
}

/// Rounding: 48 steps of at most 6 operations on numbers below 10, 48·6·10·ε/2 = 3e-13.
#[test]
fn sums_groups_and_steps_are_those_of_the_platform() {
    let system = load(&written("osp-good", "OspSystemStructure.xml", GOOD)).unwrap();
    let (found, expected) = (rows(&system, Schedule::Standard, 1), by_hand());
    for (n, (a, b)) in found.iter().zip(&expected).enumerate() {
        for (k, (a, b)) in a.iter().zip(b).enumerate() {
            assert!((a - b).abs() < 3e-13, "step {n}, {}: {a} and {b}", SHOWN[k]);
        }
    }
    let [n, b] = ["integerOut", "booleanOut"].map(|name| format!("number two.{name}"));
    let master = Master::new(&system, &[], Stepping::new(START, H, Schedule::Standard)).unwrap();
    let number = |name: &str| master.number(system.port(name).unwrap()).unwrap();
    assert_eq!((number(&n), number(&b)), (4.0, 1.0));
    let s = &system.structure;
    assert_eq!(
        (s.start_time, s.stop_time, s.step),
        (0.5, Some(3.5), Some(H))
    );
    let remarks = s.remarks.join("\n");
    let parts = [
        "simulator `number two` has steps of 0.125 s instead of stepSize = 0.13 s",
        "connection number two.y3 -> one.u3: the units differ, `deg` and `rad`; values pass unchanged",
    ];
    assert_contains(&remarks, &parts);
}

/// The same system as SSP, written by hand and converted, has the same bits, whatever the schedule
/// and the threads.
#[test]
fn a_system_of_the_platform_is_the_same_as_ssp() {
    let own = written("osp-same", "OspSystemStructure.xml", GOOD);
    let by_hand = load(&written("osp-same", "hand.ssd", &ssp())).unwrap();
    let folder = own.parent().unwrap();
    let packed = scratch("osp-same").join("packed.ssp");
    let _ = fs::remove_file(&packed);
    let arguments = [
        "convert",
        &folder.display().to_string(),
        "--output",
        &packed.display().to_string(),
    ];
    let (code, output, error) = cosim(&arguments);
    assert_eq!(code, 0, "{error}");
    assert_contains(
        &output,
        &["packed system written to", "instead of stepSize"],
    );
    let systems = [
        load(&own).unwrap(),
        load(folder).unwrap(),
        load(&packed).unwrap(),
    ];
    for schedule in [Schedule::Standard, Schedule::Jacobi, Schedule::GaussSeidel] {
        let expected = rows(&by_hand, schedule, 1);
        for system in &systems {
            assert_eq!(system.structure.components.len(), 3);
            for threads in [1, 2] {
                assert_eq!(
                    rows(system, schedule, threads),
                    expected,
                    "{schedule:?}, {threads}"
                );
            }
        }
    }
    let file = own.display().to_string();
    for arguments in [
        &["info", &file][..],
        &["wiring", "--system", &file],
        &["run", &file, "--quiet"],
    ] {
        let (code, output, error) = cosim(arguments);
        assert_eq!(code, 0, "{arguments:?}: {output}{error}");
    }
}

/// An input that is the sum of an output and of one that depends on it at once: it is set after
/// both. y1 decays from 0.3 by 1 − 1.7 H a step.
#[test]
fn a_sum_waits_for_its_last_term() {
    let relayed = GOOD.replace(
        "<Variable simulator=\"number two\" name=\"y3\"/><Signal function=\"sum\"",
        "<Variable simulator=\"number two\" name=\"realOut\"/><Signal function=\"sum\"",
    );
    let relayed = relayed.replace(
        "<Variable simulator=\"three\" name=\"y1\"/><Signal",
        "<Variable simulator=\"one\" name=\"y1\"/><Signal",
    );
    let relayed = relayed.replace(
        "<Variable simulator=\"number two\" name=\"u1\"/>",
        "<Variable simulator=\"number two\" name=\"realIn\"/>",
    );
    let relayed = relayed.replace(
        "<Variable simulator=\"three\" name=\"u1\"/>",
        "<Variable simulator=\"three\" name=\"realIn\"/>",
    );
    let relayed = relayed.replace(" stepSize=\"0.13\"", "");
    let system = load(&written("osp-relayed", "OspSystemStructure.xml", &relayed)).unwrap();
    for schedule in [Schedule::Jacobi, Schedule::GaussSeidel] {
        let mut master = Master::new(&system, &[], Stepping::new(START, H, schedule)).unwrap();
        let mut expected = 0.3;
        for n in 0..4 {
            let port = |name| system.port(name).unwrap();
            let [y, u] = ["one.y1", "three.realOut"].map(|name| master.number(port(name)).unwrap());
            assert!((y - expected).abs() < 1e-15, "step {n}: {y}");
            assert_eq!(u, y + y + y, "step {n}, {schedule:?}");
            master.step().unwrap();
            expected += H * (0.0 - 1.7 * expected);
        }
    }
}

/// A fault of an output alters one term of the sum, one of the input the whole sum.
#[test]
fn faults_alter_terms_and_sums() {
    let text = GOOD.replace(
        "<Variable simulator=\"three\" name=\"u1\"/>",
        "<Variable simulator=\"three\" name=\"realIn\"/>",
    );
    let system = load(&written("osp-faults", "OspSystemStructure.xml", &text)).unwrap();
    let sum_with = |fault: Option<&str>| {
        let stepping = Stepping::new(START, H, Schedule::Jacobi);
        let mut master = Master::new(&system, &[], stepping).unwrap();
        let mut faults = Faults::default();
        if let Some(fault) = fault {
            faults.add(&system, fault).unwrap();
        }
        master.apply_faults(&system, &faults).unwrap();
        master
            .number(system.port("three.realOut").unwrap())
            .unwrap()
    };
    let plain = sum_with(None);
    // 0.3 + 3·(−0.7) + 0
    assert!((plain + 1.8).abs() < 1e-15, "{plain}");
    for (fault, expected) in [
        ("number two.y3=bias:0.5", plain + 0.5),
        ("one.y1=bias:0.25", plain + 0.25),
        ("three.realIn=override:7", 7.0),
    ] {
        let found = sum_with(Some(fault));
        assert!(
            (found - expected).abs() < 1e-14,
            "{fault}: {found} {expected}"
        );
    }
}

/// A scenario in YAML is the same as in JSON; what is wrong in it is named.
#[test]
fn scenarios_in_yaml_are_those_in_json() {
    let system = load(&written("osp-yaml", "OspSystemStructure.xml", GOOD)).unwrap();
    let stepping = Stepping::new(START, H, Schedule::Standard);
    let read = |name: &str, text: &str| {
        let file = scratch("osp-yaml").join(name);
        fs::write(&file, text).unwrap();
        let mut faults = Faults::default();
        let line = scenario::add(&file, &system, stepping, &mut faults);
        line.map(|_| format!("{:?}", faults.list))
    };
    let yaml = "---\n# a comment\ndefaults:\n  model: number two\n  action: override\nevents:\n  - time: 0.5\n    variable: u1\n    action: bias\n    \
                value: 1.001\n  - {time: 0.2, variable: y1, value: -1}\n  - time: 0.75\n    variable: booleanIn\n    value: false\nend: 1\n";
    let json = r#"{"defaults": {"model": "number two", "action": "override"}, "events": [
        {"time": 0.5, "variable": "u1", "action": "bias", "value": 1.001}, {"time": 0.2, "variable": "y1", "value": -1},
        {"time": 0.75, "variable": "booleanIn", "value": false}], "end": 1}"#;
    let expected = read("s.json", json).unwrap();
    assert_eq!(read("s.yml", yaml).unwrap(), expected);
    assert_eq!(read("s.YAML", json).unwrap(), expected);
    for (text, parts) in [
        ("events: [", &["s.yaml", "it is no YAML"][..]),
        (
            "events:\n  - time: soon\n    variable: u1\n    model: one\n    action: reset",
            &["event 1", "`time` = \"soon\""],
        ),
        (
            "events:\n  - time: 1\n    time: 2",
            &["it is no YAML", "duplicate"],
        ),
    ] {
        let error = format!("{:#}", read("s.yaml", text).unwrap_err());
        assert_contains(&error, parts);
    }
}

/// Each bad system is refused with its line and what is wrong.
#[test]
fn bad_systems_of_the_platform_are_named() {
    let signal_in =
        "<Variable simulator=\"one\" name=\"y2\"/><Signal function=\"scaled\" name=\"in\"/>";
    for (old, new, parts) in [
        (
            "version=\"0.1\"",
            "version=\"0.2\"",
            &["line 2: version `0.2` is not supported"][..],
        ),
        (
            "<BaseStepSize>0.0625",
            "<BaseStepSize>-1",
            &["line 5: BaseStepSize is -1 s; it must be above 0"],
        ),
        (
            "<StartTime>0.5",
            "<StartTime>soon",
            &["line 3: StartTime is `soon`; it must be a finite number"],
        ),
        (
            "<EndTime>3.5",
            "<EndTime>0.25",
            &["line 4: EndTime is 0.25 s, before the start at 0.5 s"],
        ),
        (
            "fixedStep",
            "gaussSeidel",
            &["line 6: Algorithm is `gaussSeidel`; it must be fixedStep or ecco"],
        ),
        (
            "<Simulators>",
            "<Plots/>\n<Simulators>",
            &["line 7: the element Plots is not known here"],
        ),
        (
            "\"../fmus/Lags.fmu\"><",
            "\"proxyfmu://host:9090?file=Lags.fmu\"><",
            &[
                "line 8: simulator `one`: the source `proxyfmu://host:9090?file=Lags.fmu`",
                "--fmu SIMULATOR=FILE",
                "proxy-fmu",
            ],
        ),
        (
            "\"../fmus/Lags.fmu\"><",
            "\"https://example.org/Lags.fmu\"><",
            &["line 8: simulator `one`", "`https:`", "download the FMU"],
        ),
        (
            "\"../fmus/Lags.fmu\"><",
            "\"ftp://example.org/Lags.fmu\"><",
            &["has the scheme `ftp:`"],
        ),
        (
            "\"../fmus/Lags.fmu\"><",
            "\"Lugs.fmu\"><",
            &["line 8: simulator `one`", "Lugs.fmu` cannot be read"],
        ),
        (
            "name=\"three\" source",
            "name=\"one\" source",
            &["line 15: two simulators are named `one`"],
        ),
        (
            "stepSize=\"0.13\"",
            "stepSize=\"0\"",
            &["line 11: Simulator has stepSize = 0 s; it must be above 0 (of `number two`)"],
        ),
        (
            "variable=\"k\"",
            "variable=\"kk\"",
            &["line 9: simulator `one`", "`kk`"],
        ),
        (
            "<Real value=\"1.7\"/>",
            "<Real value=\"x\"/>",
            &["line 9: Real has value = `x`"],
        ),
        (
            "<Integer value=\"4\"/>",
            "<Real value=\"4.5\"/>",
            &["`number two.integerIn` = 4.5: given as Real, but its FMU has it as Integer"],
        ),
        (
            "<Sum name=\"sum\" inputCount=\"3\"/>",
            "<Product name=\"sum\"/>",
            &["line 19: the element Product is not known here"],
        ),
        (
            "inputCount=\"3\"",
            "inputCount=\"4\"",
            &["line 19: Sum has no connection to its signal `in[3]` (of `sum`)"],
        ),
        (
            "inputCount=\"3\"",
            "inputCount=\"2\"",
            &["line 35: no function `sum` has a signal `in[2]`"],
        ),
        (
            "dimension=\"2\"",
            "dimension=\"3\"",
            &[
                "line 37: signal `in[0]` of the VectorSum `vector` takes 3 variables, as a SignalGroup; this has 2",
            ],
        ),
        (
            "<Variable simulator=\"one\" name=\"y1\"/>\n",
            "<Variable simulator=\"four\" name=\"y1\"/>\n",
            &["line 25: the system has no simulator `four`, only one, number two, three"],
        ),
        (
            "<Variable simulator=\"one\" name=\"y1\"/>\n",
            "<Variable simulator=\"one\" name=\"u1\"/>\n",
            &[
                "line 23: `one.u1` is input and `number two.u1` is input; a connection needs an output and an input",
            ],
        ),
        (
            "<Variable simulator=\"one\" name=\"y1\"/>\n",
            "<Variable simulator=\"one\" name=\"booleanOut\"/>\n",
            &["line 23: `one.booleanOut` is Boolean and `number two.u1` is Real; both ends"],
        ),
        (
            "<Variable simulator=\"one\" name=\"y1\"/>\n",
            "",
            &["line 23: VariableConnection must have two ends, Variable and Variable"],
        ),
        (
            signal_in,
            &signal_in.replace("y2", "integerOut"),
            &[
                "line 31: `one.integerOut` is Integer and `number two.u2` is Real; functions are for Reals",
            ],
        ),
        (
            "simulator=\"one\" name=\"inputs\"",
            "simulator=\"one\" name=\"input\"",
            &["line 29: simulator `one` has no group `input`, only last two, second, inputs"],
        ),
        (
            "simulator=\"one\" name=\"inputs\"",
            "simulator=\"one\" name=\"first\"",
            &[
                "line 27: the groups `last two` of `number two` and `first` of `one` differ in the number",
            ],
        ),
        (
            "<Variable simulator=\"number two\" name=\"u2\"/></SignalConnection>",
            "<Variable simulator=\"number two\" name=\"u1\"/></SignalConnection>",
            &["input `number two.u1` has two connections"],
        ),
        (
            "name=\"out\"/><Variable simulator=\"three\" name=\"u1\"/>",
            "name=\"out\"/><Variable simulator=\"three\" name=\"u2\"/>",
            &["line 39: input `three.u2` has two connections"],
        ),
    ] {
        assert!(GOOD.contains(old), "{old}");
        let path = written(
            "osp-bad",
            "OspSystemStructure.xml",
            &GOOD.replacen(old, new, 1),
        );
        let error = load(&path).and_then(|system| {
            let schedule = Stepping::new(START, H, Schedule::Standard);
            Master::new(&system, &[], schedule).map(|_| ())
        });
        let Err(error) = error else {
            panic!("{new} is not refused")
        };
        assert_contains(&format!("{error:#}"), parts);
    }
    let folder = scratch("osp-bad").join("fmus").display().to_string();
    let (code, _, error) = cosim(&["run", &folder]);
    assert_eq!(code, 1);
    assert_contains(&error, &["is a folder without OspSystemStructure.xml"]);
    fs::remove_file(scratch("osp-bad").join("fmus/Lags_OspModelDescription.xml")).unwrap();
}

/// An FMU that is given instead of one behind `proxyfmu:` is taken, and groups in the FMU's archive
/// are found.
#[test]
fn an_fmu_may_be_given_and_have_its_groups_inside() {
    let text = GOOD.replace("../fmus/Lags.fmu", "proxyfmu://host:9090?file=Lags.fmu");
    let text = text.replace("file:proxyfmu", "proxyfmu");
    let path = written("osp-given", "OspSystemStructure.xml", &text);
    let folder = scratch("osp-given");
    fs::remove_file(folder.join("fmus/Lags_OspModelDescription.xml")).unwrap();
    let mut entries = fmi_description::entries::read(&folder.join("fmus/Lags.fmu")).unwrap();
    let name = "extra/Lags_OspModelDescription.xml".to_string();
    entries.insert(name, GROUPS.as_bytes().to_vec());
    let given = folder.join("Given.fmu");
    let _ = fs::remove_file(&given);
    fmi_description::entries::write(&given, &entries).unwrap();
    let given = given.display().to_string();
    let path = path.display().to_string();
    let fmus = ["one", "number two", "three"].map(|name| format!("{name}={given}"));
    let [a, b, c] = fmus.each_ref().map(|text| &**text);
    let run = ["run", &path, "--quiet", "--fmu", a, "--fmu", b, "--fmu", c];
    let (code, output, error) = cosim(&run);
    assert_eq!(code, 0, "{output}{error}");
}
