//! What FMUs are told of a run, and what users of other tools expect of its options: tiny steps,
//! names of every form, one FMU twice, FMUs without outputs, what may be set. `told.c` shows it.

use std::fs;

use cosim::structure::FmuUse;
use cosim::structure::system::System;

use super::foreign::compiled;
use super::program::cosim;
use super::support::{assert_contains, pack, scratch, settings};

/// Experiment of most tests.
const EXPERIMENT: &str = r#"startTime="0.2" stopTime="0.5" stepSize="0.1" tolerance="3e-5""#;
const VARIES: &str = r#"canHandleVariableCommunicationStepSize="true""#;

/// An output of the version with the value reference `k`.
fn output(version: u32, name: &str, k: usize) -> String {
    variable(version, name, k, r#"causality="output""#, "")
}

fn variable(version: u32, name: &str, k: usize, role: &str, start: &str) -> String {
    let name = name.replace('&', "&amp;").replace('<', "&lt;");
    let name = name.replace('"', "&quot;");
    match version {
        2 => format!(
            r#"<ScalarVariable name="{name}" valueReference="{k}" {role}><Real {start}/></ScalarVariable>"#
        ),
        _ => format!(r#"<Float64 name="{name}" valueReference="{k}" {role} {start}/>"#),
    }
}

/// What the FMU was told.
fn outputs(version: u32) -> String {
    let names = ["start", "stop", "tolerance", "logging", "steps", "h", "end"];
    let all = names.iter().enumerate();
    all.map(|(k, name)| output(version, name, k)).collect()
}

/// Packs `told.c` as the file `NAME.fmu` of a test; returns its path.
fn fmu(
    test: &str,
    name: &str,
    version: u32,
    [flags, experiment, variables]: [&str; 3],
    more: &[&str],
) -> String {
    let folder = scratch(test);
    fs::create_dir_all(&folder).unwrap();
    let defined: &[&str] = if version == 3 { &["-DFMI3"] } else { &[] };
    let library = compiled(&folder, "told.so", &["told.c"], &[defined, more].concat());
    let (token, platform) = match version {
        2 => ("guid", "linux64"),
        _ => ("instantiationToken", "x86_64-linux"),
    };
    let text = format!(
        r#"<fmiModelDescription fmiVersion="{version}.0" modelName="told" {token}="t"><CoSimulation modelIdentifier="told" {flags}/>
        <DefaultExperiment {experiment}/><ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>"#
    );
    let file = folder.join(format!("{name}.fmu"));
    pack(&file, &text, platform, &[&library]);
    file.display().to_string()
}

/// Runs with a CSV file; returns its lines, and what is printed.
#[track_caller]
fn lines(test: &str, arguments: &[&str]) -> (Vec<String>, String) {
    let csv = scratch(test).join("out.csv").display().to_string();
    let all = [&["run", "--quiet", "--csv", &csv][..], arguments].concat();
    let (code, text, error) = cosim(&all);
    assert_eq!(code, 0, "{error}");
    let rows = fs::read_to_string(&csv).unwrap();
    let rows = rows.lines().map(String::from).collect();
    (rows, text + &error)
}

/// The numbers of the last row, without the time.
fn last(lines: &[String]) -> Vec<f64> {
    let cells = lines.last().unwrap().split(',').skip(1);
    cells.map(|cell| cell.parse().unwrap()).collect()
}

/// Start, stop and tolerance come from the options, else from the description; no step passes the
/// stop time, although 0.2 + 3 · 0.1 is more than 0.5 in binary; nothing is logged unasked.
#[test]
fn fmus_are_told_start_stop_and_tolerance() {
    for version in [2, 3] {
        let test = format!("told-{version}");
        let file = fmu(
            &test,
            "X",
            version,
            [VARIES, EXPERIMENT, &outputs(version)],
            &[],
        );
        for schedule in ["standard", "jacobi", "gauss-seidel"] {
            let (rows, text) = lines(&test, &[&file, "--schedule", schedule]);
            let told = last(&rows);
            assert_eq!(told[0], 0.2);
            assert!((told[1] - 0.5).abs() < 1e-15, "{told:?}");
            assert_eq!(told[2..5], [3e-5, 0.0, 3.0], "{version} {schedule}");
            assert!(!text.contains("a step is made"), "{text}");
            let more = [
                "--start-time",
                "5",
                "--stop-time",
                "5.3",
                "--tolerance",
                "1e-9",
            ];
            let told = last(
                &lines(
                    &test,
                    &[&[&*file, "--schedule", schedule][..], &more].concat(),
                )
                .0,
            );
            assert_eq!((told[0], told[2]), (5.0, 1e-9));
            assert!((told[1] - 5.3).abs() < 1e-14 && told[4] == 3.0, "{told:?}");
        }
        let none = fmu(
            &test,
            "Y",
            version,
            [VARIES, r#"stopTime="1""#, &outputs(version)],
            &[],
        );
        assert_eq!(
            last(&lines(&test, &[&none, "--step", "0.1"]).0)[..3],
            [0.0, 1.0, -1.0]
        );
        for (option, value, part) in [
            ("--tolerance", "0", "above 0 and below 1"),
            ("--start-time", "NaN", "a finite time in s"),
        ] {
            let (code, _, error) = cosim(&["run", &none, option, value]);
            assert_eq!(code, 1);
            assert_contains(&error, &[option, part]);
        }
    }
}

/// The start of a system that declares none is that of its FMUs.
#[test]
fn a_structure_without_a_start_has_that_of_its_fmus() {
    fmu("told-ssd", "X", 2, [VARIES, EXPERIMENT, &outputs(2)], &[]);
    let file = scratch("told-ssd").join("s.ssd");
    let run = |experiment: &str| {
        let text = format!(
            r#"<ssd:SystemStructureDescription xmlns:ssd="d" version="1.0" name="s"><ssd:System name="s"><ssd:Elements>
            <ssd:Component name="x" source="X.fmu"/></ssd:Elements></ssd:System>{experiment}</ssd:SystemStructureDescription>"#
        );
        fs::write(&file, text).unwrap();
        last(&lines("told-ssd", &[&file.display().to_string()]).0)
    };
    assert_eq!(run("")[0], 0.2);
    let own = r#"<ssd:DefaultExperiment startTime="0.1" stopTime="0.4"/>"#;
    assert_eq!((run(own)[0], run(own)[2]), (0.1, 3e-5));
}

/// A tiny step becomes a multiple with at most 10⁵ steps where the FMU can vary its step; it is
/// kept where it cannot, or has an internal step, and the number of steps is said.
#[test]
fn tiny_steps_are_taken_only_where_they_must() {
    let tiny = r#"stopTime="0.01" stepSize="1e-8""#;
    let file = |version: u32, name: &str, flags: &str, experiment: &str| {
        let parts = [flags, experiment, &outputs(version)];
        fmu(
            "tiny",
            &format!("{name}{version}"),
            version,
            parts,
            &["-DSILENT"],
        )
    };
    let chosen = |files: &[&str], span: f64| {
        let files: Vec<_> = files.iter().map(Into::into).collect();
        let system = System::from_fmus(&files, &[], &FmuUse::default()).unwrap();
        let chosen = system.default_step(span).unwrap();
        ((chosen.step * 1e8).round(), chosen.text)
    };
    for version in [2, 3] {
        let varies = file(version, "V", VARIES, tiny);
        let (step, text) = chosen(&[&varies], 0.01);
        assert_eq!(step, 10.0);
        assert_contains(
            &text,
            &[
                "10 times the 1e-8 s that `V",
                "100000 steps instead of 1000000",
            ],
        );
        assert_eq!(chosen(&[&varies], 1e-3).0, 1.0);
        let cannot = file(version, "C", "", r#"stepSize="3e-8""#);
        let (step, text) = chosen(&[&cannot], 0.03);
        assert_eq!(step, 3.0);
        assert_contains(&text, &["asks, which cannot vary its step: 1000000 steps"]);
        // Together the one that cannot vary its step decides, unless the other is slower still.
        assert_eq!(chosen(&[&varies, &cannot], 0.01).0, 3.0);
        assert_eq!(chosen(&[&varies, &cannot], 0.002).0, 2.0);
        // Not tiny, though there are many.
        let many = file(version, "M", VARIES, r#"stopTime="150" stepSize="1e-3""#);
        assert_eq!(chosen(&[&many], 150.0).0, 1e5);
    }
    let fixed = format!(r#"{VARIES} fixedInternalStepSize="1e-8""#);
    let (step, text) = chosen(&[&file(3, "F", &fixed, tiny)], 0.01);
    assert_eq!(step, 1.0);
    assert_contains(&text, &["whose internal step is fixed: 1000000 steps"]);
    let varies = file(2, "V", VARIES, tiny);
    let (rows, text) = lines("tiny", &[&varies, "--interval", "1e-3"]);
    assert_eq!((rows.len(), last(&rows)[4]), (12, 1e5));
    // It is said before the run, and in the verdict.
    assert_eq!(text.matches("10 times").count(), 2, "{text}");
    let (rows, text) = lines("tiny", &[&varies, "--step", "1e-4"]);
    assert!(last(&rows)[4] == 100.0 && !text.contains("times"), "{text}");
}

/// Names that other tools give.
const NAMES: [&str; 9] = [
    "x[1,2]", "der(y,2)", "'a\"b'", "c d", "a,b", "a=b", "p*q", "a=b=c", "é<&",
];

/// For each name an output, an input and a parameter.
fn named(version: u32) -> String {
    let all = NAMES.iter().enumerate().map(|(k, name)| {
        let input = variable(
            version,
            &format!("u.{name}"),
            18 + k,
            r#"causality="input""#,
            r#"start="0""#,
        );
        let role = r#"causality="parameter" variability="fixed""#;
        let parameter = variable(version, &format!("p.{name}"), 28 + k, role, r#"start="1""#);
        output(version, name, 8 + k) + &input + &parameter
    });
    all.collect()
}

/// Each name can be said in each option, alone and among others; columns stand in the order asked.
#[test]
fn every_name_can_be_said_in_every_option() {
    for version in [2, 3] {
        let test = format!("names-{version}");
        let file = fmu(
            &test,
            "X",
            version,
            [VARIES, EXPERIMENT, &named(version)],
            &[],
        );
        let [a, b] = ["a", "b"].map(|name| format!("{name}={file}"));
        for name in NAMES {
            let [set, connect] = [format!("a.p.{name}=7"), format!("a.{name}=b.u.{name}")];
            let [other, fault] = ["override:3", "bias:1"].map(|what| format!("b.u.{name}={what}"));
            let noise = format!("b.u.{name}=0");
            let signals = format!("b.u.{name},a.{name},a.p*,a.u.{name}");
            let run = [
                &*a,
                &b,
                "--set",
                &set,
                "--connect",
                &connect,
                "--fault",
                &other,
                "--fault",
                &fault,
                "--noise",
                &noise,
                "--schedule",
                "jacobi",
                "--signals",
                &signals,
            ];
            // A pattern may match several names, and a name that it is counts alone.
            let run: Vec<&str> = run.to_vec();
            let (rows, text) = lines(&test, &run);
            let quoted = |name: String| match name.contains([',', '"']) {
                true => format!("\"{}\"", name.replace('"', "\"\"")),
                false => name,
            };
            let head = [format!("b.u.{name}"), format!("a.{name}")]
                .map(quoted)
                .join(",");
            assert!(
                rows[0].starts_with(&format!("time,{head},")),
                "{name}: {}",
                rows[0]
            );
            assert!(
                rows[0].ends_with(&quoted(format!("a.u.{name}"))),
                "{name}: {}",
                rows[0]
            );
            assert!(rows[1].starts_with("0.2,4.0,0.0"), "{name}: {}", rows[1]);
            assert_contains(
                &text,
                &[&format!(
                    "on the wire a.{name} -> b.u.{name}: override by 3"
                )],
            );
            let input = scratch(&test).join("in.csv");
            fs::write(&input, "time,k=1\n0,5\n").unwrap();
            let column = format!("b.u.{name}=k=1");
            let input = input.display().to_string();
            let run = [
                &*a,
                &b,
                "--input",
                &input,
                "--input-column",
                &column,
                "--signals",
                &signals,
            ];
            assert!(lines(&test, &run).0[1].starts_with("0.2,5.0,0.0"), "{name}");
        }
    }
}

/// An array by its name is all its elements: in FMI 2.0 by their names, in FMI 3.0 one variable.
#[test]
fn an_array_is_named_as_a_whole() {
    let dimensions = r#"<Dimension start="2"/><Dimension start="2"/></Float64>"#;
    for version in [2, 3] {
        let test = format!("whole-{version}");
        let array = |name: &str, k: usize, role: &str, start: &str| match version {
            2 => {
                let indices = ["[1,1]", "[1,2]", "[2,1]", "[2,2]"].iter().zip(k..);
                let each = indices.map(|(i, k)| variable(2, &format!("{name}{i}"), k, role, start));
                each.collect()
            }
            _ => variable(3, name, k, role, start).replace("/>", ">") + dimensions,
        };
        let role = r#"causality="parameter" variability="fixed""#;
        let variables = array("y", 8, r#"causality="output""#, "")
            + &array("u", 12, r#"causality="input""#, r#"start="0""#)
            + &array("p", 16, role, r#"start="0""#);
        let file = fmu(&test, "X", version, [VARIES, EXPERIMENT, &variables], &[]);
        let [a, b] = ["a", "b"].map(|name| format!("{name}={file}"));
        let run = [
            &*a,
            &b,
            "--connect",
            "a.y=b.u",
            "--fault",
            "b.u=bias:2",
            "--signals",
            "b.u,a.y",
            "--schedule",
            "jacobi",
        ];
        let (rows, _) = lines(&test, &run);
        let names = r#"time,"b.u[1,1]","b.u[1,2]","b.u[2,1]","b.u[2,2]","a.y[1,1]""#;
        assert!(rows[0].starts_with(names), "{}", rows[0]);
        assert_eq!(last(&rows), [2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
        let system = System::from_fmus(&[a.into()], &[], &FmuUse::default()).unwrap();
        let of = |text: &str| -> anyhow::Result<Vec<String>> {
            Ok(settings(&system, &[text])?
                .into_iter()
                .map(|s| s.value)
                .collect())
        };
        assert_eq!(of("p=1 2 3 4").unwrap(), ["1", "2", "3", "4"]);
        assert_eq!(of("a.p = 5").unwrap(), ["5"; 4]);
        assert_contains(
            &of("a.p=1 2").unwrap_err().to_string(),
            &["`a.p` has 4 elements", "2 are given"],
        );
        let input = scratch(&test).join("in.csv");
        fs::write(
            &input,
            "time,m,\"k[1,1]\",\"k[1,2]\",\"k[2,1]\",\"k[2,2]\"\n0,9,1,2,3,4\n",
        )
        .unwrap();
        let input = input.display().to_string();
        for (column, expected) in [("b.u=m", [9.0; 4]), ("b.u=k", [1.0, 2.0, 3.0, 4.0])] {
            let run = [
                &*b,
                "--input",
                &input,
                "--input-column",
                column,
                "--signals",
                "b.u",
            ];
            assert_eq!(last(&lines(&test, &run).0), expected);
        }
    }
}

/// One library, two components; two of one name are refused with a way out.
#[test]
fn one_fmu_runs_twice_under_names() {
    let file = fmu("twice", "X", 2, [VARIES, EXPERIMENT, &named(2)], &[]);
    let (rows, _) = lines(
        "twice",
        &[&format!("a={file}"), &file, "--set", "X.p.c d=2"],
    );
    assert_contains(&rows[0], &["a.c d", "X.c d"]);
    let (code, _, error) = cosim(&["run", &file, &file]);
    assert_eq!(code, 1);
    assert_contains(&error, &["two FMUs are named `X`", "a="]);
}

/// Of FMUs without outputs the local variables are recorded, and that is said.
#[test]
fn fmus_without_outputs_show_their_local_variables() {
    for version in [2, 3] {
        let test = format!("silent-{version}");
        let role = r#"causality="local" variability="continuous""#;
        let variables = variable(version, "x", 4, role, "")
            + &variable(
                version,
                "p",
                8,
                r#"causality="parameter" variability="fixed""#,
                r#"start="1""#,
            );
        let file = fmu(&test, "X", version, [VARIES, EXPERIMENT, &variables], &[]);
        for more in [&[][..], &["--signals", "*"]] {
            let (rows, text) = lines(&test, &[&[&*file], more].concat());
            assert_eq!((&*rows[0], last(&rows)), ("time,X.x", vec![3.0]));
            assert_contains(&text, &["`X` has no outputs: 1 of its other variables"]);
        }
    }
}

/// Constants and what is calculated are refused by name, with what may be set; in a parameter set
/// they are left out, with a remark.
#[test]
fn constants_and_calculated_values_are_not_set() {
    for version in [2, 3] {
        let test = format!("settable-{version}");
        let row = |name: &str, k, role: &str, start| variable(version, name, k, role, start);
        let start = r#"start="1""#;
        let variables = row(
            "p",
            8,
            r#"causality="parameter" variability="fixed""#,
            start,
        ) + &row(
            "pi",
            9,
            r#"causality="local" variability="constant" initial="exact""#,
            start,
        ) + &row(
            "q",
            10,
            r#"causality="calculatedParameter" variability="fixed" initial="calculated""#,
            "",
        ) + &row("y", 11, r#"causality="output" initial="calculated""#, "")
            + &row("l", 12, r#"causality="local""#, "")
            + &row("x0", 13, r#"causality="local" initial="exact""#, start)
            + &row("g", 14, r#"causality="local" initial="approx""#, start)
            + &row(
                "time",
                15,
                r#"causality="independent" variability="continuous""#,
                "",
            )
            + &row("u", 16, r#"causality="input""#, start);
        let file = fmu(&test, "X", version, [VARIES, EXPERIMENT, &variables], &[]);
        for (name, why) in [
            ("pi", "is a constant"),
            ("q", "is calculated from parameters"),
            ("y", "is calculated by its FMU"),
            ("l", "is calculated by its FMU"),
            ("time", "is the independent variable"),
        ] {
            let (code, _, error) = cosim(&["run", &file, "--set", &format!("X.{name}=2")]);
            assert_eq!(code, 1);
            assert_contains(
                &error,
                &[&format!("`X.{name}` {why}"), "can be set: p, x0, g, u"],
            );
        }
        for name in ["p", "x0", "g", "u"] {
            lines(&test, &[&file, "--set", &format!("{name}=2")]);
        }
        let system = scratch(&test).join("s.ssd");
        let text = r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssv="v" version="1.0" name="s"><ssd:System name="s"><ssd:Elements>
            <ssd:Component name="x" source="X.fmu"><ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="1.0" name="x">
            <ssv:Parameters><ssv:Parameter name="pi"><ssv:Real value="3"/></ssv:Parameter><ssv:Parameter name="p"><ssv:Real value="4"/></ssv:Parameter>
            </ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings></ssd:Component></ssd:Elements></ssd:System>
            </ssd:SystemStructureDescription>"#;
        fs::write(&system, text).unwrap();
        let (_, text) = lines(&test, &[&system.display().to_string()]);
        assert_contains(
            &text,
            &[
                "verdict: good",
                "`x.pi` is a constant: its value 3 is left out",
            ],
        );
    }
}

/// An FMU that can be made only with loggingOn off is asked once more for its reason.
#[test]
fn an_fmu_that_logs_only_when_asked_says_why_it_fails() {
    for version in [2, 3] {
        let parts = [VARIES, EXPERIMENT, &outputs(version)];
        let file = fmu(
            &format!("refused-{version}"),
            "X",
            version,
            parts,
            &["-DREFUSED"],
        );
        let (code, _, error) = cosim(&["run", &file]);
        assert_eq!(code, 1);
        assert_contains(&error, &["could not be instantiated", "the key is lost"]);
    }
}

/// `info` lists what cannot be run here: other interfaces, FMI 1.0, sources without libraries.
#[test]
fn info_lists_every_fmu() {
    let folder = scratch("listed");
    fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, xml: &str, more: &[&str]| {
        let mut files = vec![("modelDescription.xml".to_string(), xml.as_bytes().to_vec())];
        files.extend(more.iter().map(|name| (name.to_string(), Vec::new())));
        let file = folder.join(name);
        super::support::write_zip(fs::File::create(&file).unwrap(), &files);
        file.display().to_string()
    };
    let x = variable(2, "x", 0, r#"causality="output""#, "");
    let two = |interfaces: &str| {
        format!(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="two" guid="t">{interfaces}<ModelVariables>{x}</ModelVariables></fmiModelDescription>"#
        )
    };
    let exchange = write(
        "me.fmu",
        &two(r#"<ModelExchange modelIdentifier="two"/>"#),
        &["binaries/linux64/two.so"],
    );
    let both =
        two(r#"<CoSimulation modelIdentifier="two"/><ModelExchange modelIdentifier="two"/>"#);
    let sources = write("c.fmu", &both, &["sources/all.c"]);
    let one = r#"<fmiModelDescription fmiVersion="1.0" modelName="one" modelIdentifier="one" guid="t"><ModelVariables>
        <ScalarVariable name="h" valueReference="0" causality="output"><Real/></ScalarVariable></ModelVariables>"#;
    let alone = format!(
        "{one}<Implementation><CoSimulation_StandAlone/></Implementation></fmiModelDescription>"
    );
    let [one, alone] = [format!("{one}</fmiModelDescription>"), alone].map(|xml| {
        write(
            &format!("{}.fmu", xml.len()),
            &xml,
            &["binaries/win32/one.dll"],
        )
    });
    let (code, text, error) = cosim(&["info", &exchange, &sources, &one, &alone]);
    assert_eq!(code, 0, "{error}");
    assert_contains(
        &text,
        &[
            "two, FMI 2.0\n  interfaces: Model Exchange\n  platforms: linux64",
            "interfaces: Co-Simulation, Model Exchange\n  platforms: none (C sources only)",
            "x: output",
            "one, FMI 1.0\n  interfaces: Model Exchange\n  platforms: win32",
            "one, FMI 1.0\n  interfaces: Co-Simulation",
        ],
    );
    let (_, text, _) = cosim(&["info", "--json", &exchange, &sources, &alone]);
    let list: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(list[0]["interfaces"][0], "Model Exchange");
    assert_eq!(list[1]["sources_only"], true);
    assert_eq!(
        (&list[2]["fmi"], &list[2]["variables"][0]["name"]),
        (&"1.0".into(), &"h".into())
    );
    let nothing = write("no.fmu", &two(""), &[]);
    let (code, _, error) = cosim(&["run", &nothing]);
    assert_eq!(code, 1);
    let expected = "offers no interface, no Co-Simulation or Model Exchange";
    assert_contains(&error, &[expected]);
    let (_, _, error) = cosim(&["run", &sources]);
    assert_contains(&error, &["it has C sources only"]);
}
