//! Arrays whose sizes are structural parameters of FMI 3.0, set in Configuration Mode before a run.

use std::fs;
use std::path::PathBuf;

use cosim::Experiment;
use cosim::exchange::faults::Faults;
use cosim::master::{Master, Schedule};
use cosim::structure::FmuUse;
use cosim::structure::system::System;

use super::foreign::compiled;
use super::loops::numbers;
use super::program::cosim;
use super::support::{assert_contains, pack, scratch, settings, stepping};

const SCHEDULES: [Schedule; 3] = [Schedule::Standard, Schedule::Jacobi, Schedule::GaussSeidel];

/// The FMU of `sizes.c` as files `a.fmu` and `b.fmu` in a folder of the test.
fn fmus(test: &str) -> [PathBuf; 2] {
    let folder = scratch(&format!("sizes_{test}"));
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "sizes.so", &["sizes.c"], &[]);
    let array = |tag: &str, name: &str, vr: u32, more: &str| {
        format!(
            r#"<{tag} name="{name}" valueReference="{vr}" {more}><Dimension valueReference="1"/>"#
        ) + match tag {
            "String" | "Binary" => r#"<Start value="41"/><Start value="42"/><Start value="43"/>"#,
            _ => "",
        } + &format!("</{tag}>")
    };
    let given = r#"causality="parameter" variability="fixed""#;
    let parameter = |tag: &str, name: &str, vr: u32, start: &str| {
        array(tag, name, vr, &format!("{given} {start}"))
    };
    let variables = [
        r#"<UInt64 name="n" valueReference="1" causality="structuralParameter" start="3" min="0" max="8"/>"#.to_string(),
        r#"<Boolean name="hides" valueReference="2" causality="structuralParameter" start="false"/>"#.to_string(),
        parameter("Float64", "x0", 3, r#"start="10 20 30""#),
        array("Float64", "u", 4, r#"causality="input" start="1 2 3""#),
        array("Float64", "x", 5, r#"causality="output""#),
        r#"<Float64 name="entered" valueReference="6" causality="output"/>"#.to_string(),
        parameter("Float32", "single", 10, r#"start="0""#),
        parameter("Int64", "whole", 11, r#"start="0""#),
        parameter("Boolean", "truth", 12, r#"start="false false false""#),
        parameter("String", "text", 13, ""),
        parameter("Binary", "bytes", 14, ""),
        parameter("Int8", "small", 15, r#"start="0 0 0""#),
    ];
    let text = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="sizes" instantiationToken="t">
        <CoSimulation modelIdentifier="sizes" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true" canSerializeFMUState="true"/>
        <ModelVariables>{}</ModelVariables><ModelStructure><Output valueReference="5" dependencies=""/>
        <Output valueReference="6" dependencies=""/></ModelStructure></fmiModelDescription>"#,
        variables.concat()
    );
    ["a", "b"].map(|name| {
        let file = folder.join(format!("{name}.fmu"));
        pack(&file, &text, "x86_64-linux", &[&library]);
        file
    })
}

fn sized(files: &[PathBuf], connections: &[&str], given: &[&str]) -> anyhow::Result<System> {
    let connections: Vec<String> = connections.iter().map(ToString::to_string).collect();
    let given: Vec<String> = given.iter().map(ToString::to_string).collect();
    let system = System::from_fmus(files, &connections, &FmuUse::default())?.with_sizes(
        None,
        &[],
        &given,
    )?;
    system.check_fit()?;
    Ok(system)
}

fn of(name: &str, n: usize) -> Vec<String> {
    (1..=n).map(|k| format!("{name}[{k}]")).collect()
}

/// `x_b' = x_a`, `x_a' = u`, of five elements and of one: forward Euler in closed form. What is not
/// given keeps the values that the FMU has at this size, also where a part of the array is given.
#[test]
fn whole_arrays_are_wired_at_other_sizes() {
    let files = fmus("wired");
    for n in [5, 1, 8] {
        let size = [format!("a.n={n}"), format!("b.n={n}"), "a.x0[1]=7".into()];
        let texts = size.each_ref().map(String::as_str);
        let system = sized(&files, &["a.x=b.u"], &texts).unwrap();
        assert_eq!(system.wiring().unwrap().links.len(), n);
        for (schedule, threads) in SCHEDULES.into_iter().flat_map(|s| [(s, 1), (s, 2)]) {
            let experiment = Experiment {
                stepping: stepping(0.5, schedule),
                threads,
                stop: None,
                tolerance: None,
                settings: settings(&system, &texts).unwrap(),
                faults: Faults::default(),
                inputs: None,
                nonfinite: Vec::new(),
            };
            let mut master = experiment.start(&system).unwrap();
            (0..2).for_each(|_| master.step().unwrap());
            let saved = master.save().unwrap();
            master.step().unwrap();
            master.restore(&saved).unwrap();
            let check = |master: &Master| {
                for (k, (x, y)) in (1..).zip(of("a.x", n).iter().zip(of("b.x", n))) {
                    let (u, x0) = (f64::from(k), if k == 1 { 7.0 } else { 10.0 * f64::from(k) });
                    let [a, b] = numbers(&system, master, [x, &y]);
                    assert_eq!(a, x0 + u, "{schedule:?}");
                    // Stepped after `a`, `b` gets the end of the step.
                    let late = b - (10.0 * u + x0) - 0.25 * u;
                    assert!(
                        late == 0.0 || late == 0.5 * u,
                        "{schedule:?} {threads} {late}"
                    );
                }
            };
            check(&master);
            assert_eq!(numbers(&system, &master, ["a.entered"]), [1.0]);
        }
    }
}

/// Each type, whole and by element; a size of 0 leaves no elements.
#[test]
fn arrays_of_each_type_take_values_at_other_sizes() {
    let [file, _] = fmus("types");
    let file = [file];
    let given = [
        "n=4",
        "single=0.5",
        "single[4]=0.25",
        "whole=1 2 3 -9007199254740993",
        "truth[4]=true",
        "text[4]=four",
        "text[1]=one",
        "bytes[4]=00FF",
        "small[2]=-128",
    ];
    let system = sized(&file, &[], &given).unwrap();
    let settings = settings(&system, &given).unwrap();
    let master = Master::new(&system, &settings, stepping(0.5, Schedule::Standard)).unwrap();
    let value = |name: &str| master.text(system.port(name).unwrap()).unwrap();
    for (array, expected) in [
        ("whole", ["1", "2", "3", "-9007199254740993"]),
        ("truth", ["0", "0", "0", "1"]),
        ("text", ["one", "", "", "four"]),
        ("bytes", ["", "", "", "00FF"]),
        ("small", ["0", "-128", "0", "0"]),
    ] {
        let found: Vec<String> = of(array, 4).iter().map(|name| value(name)).collect();
        assert_eq!(found, expected, "{array}");
    }
    let single = numbers(&system, &master, ["single[1]", "single[4]"]);
    assert_eq!(single, [0.5, 0.25]);
    let none = sized(&file, &[], &["n=0"]).unwrap();
    assert!(none.port("x[1]").is_err());
    let mut master = Master::new(&none, &[], stepping(0.5, Schedule::Standard)).unwrap();
    master.step().unwrap();
    assert_eq!(numbers(&none, &master, ["entered"]), [1.0]);
    // The declared size needs no Configuration Mode.
    let same = sized(&file, &[], &["n=3"]).unwrap();
    let master = Master::new(&same, &[], stepping(0.5, Schedule::Standard)).unwrap();
    assert_eq!(numbers(&same, &master, ["entered", "x[3]"]), [0.0, 30.0]);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let files = fmus("refused");
    let wires = &["a.x=b.u"][..];
    for (connections, given, parts) in [
        (
            &[][..],
            &["a.n=9"][..],
            &["a.n=9: `a.n`: `9` is not a whole number from 0 to 8"][..],
        ),
        (
            &[],
            &["a.n=-1"],
            &["`-1` is not a whole number from 0 to 8"],
        ),
        (
            &[],
            &["a.n=2.5"],
            &["`2.5` is not a whole number from 0 to 8"],
        ),
        (
            wires,
            &["a.n=5"],
            &["--connect a.x=b.u: `a.x` has 5 elements, and `b.u` has 3"],
        ),
        (&["a.x[5]=b.u[1]"], &["a.n=4"], &["a.x[5]"]),
        (
            &["a.x[1]=b.n"],
            &[],
            &["structural parameter `b.n`", "give it as a start value"],
        ),
    ] {
        let error = sized(&files, connections, given).map(drop).unwrap_err();
        assert_contains(&format!("{error:#}"), parts);
    }
    // A size that none of the start values gave when the system was loaded, and one during a run.
    let system = sized(&files, &[], &["a.n=4"]).unwrap();
    let late = settings(&system, &["a.n=5"]).unwrap();
    let start = |settings: &[_]| Master::new(&system, settings, stepping(0.5, Schedule::Standard));
    let error = format!("{:#}", start(&late).map(drop).unwrap_err());
    assert_contains(&error, &["`a.n` = 5", "here 4", "--set"]);
    let master = start(&settings(&system, &["a.n=4"]).unwrap()).unwrap();
    let error = master.instances()[0].set_from_text("n", "2").unwrap_err();
    assert_contains(&format!("{error:#}"), &["`a.n` = 2", "before the run"]);
    // Some elements of an array, of which the FMU does not tell the others.
    let hidden = ["a.n=4", "a.hides=true", "a.x0[2]=1"];
    let system = sized(&files, &[], &hidden).unwrap();
    let some = settings(&system, &hidden).unwrap();
    let error = Master::new(&system, &some, stepping(0.5, Schedule::Standard)).map(drop);
    let parts = ["`a.x0[1]`", "1 of 4 have start values", "give all of them"];
    assert_contains(&format!("{:#}", error.unwrap_err()), &parts);
    let all = settings(&system, &["a.n=4", "a.hides=true", "a.x0=5"]).unwrap();
    let master = Master::new(&system, &all, stepping(0.5, Schedule::Standard)).unwrap();
    assert_eq!(numbers(&system, &master, ["a.x[4]"]), [5.0]);
}

/// A structure whose connectors have another size than the FMU declares: its own parameter set, and
/// a mapped name, say it.
#[test]
fn a_structure_and_its_parameter_sets_give_sizes() {
    let [file, _] = fmus("structure");
    let folder = file.parent().unwrap();
    let set = |n: u32, name: &str| {
        format!(
            r#"<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="p"><ssv:Parameters>
            <ssv:Parameter name="{name}"><ssv:Integer value="{n}"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"#
        )
    };
    let component = |name: &str, kind: &str, connector: &str| {
        format!(
            r#"<ssd:Component name="{name}" source="a.fmu"><ssd:Connectors><ssd:Connector name="{connector}" kind="{kind}"><ssc:Float64/>
            <ssc:Dimension size="5"/></ssd:Connector></ssd:Connectors><ssd:ParameterBindings><ssd:ParameterBinding source="p.ssv"/>
            </ssd:ParameterBindings></ssd:Component>"#
        )
    };
    let text = format!(
        r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" xmlns:ssv="v" version="2.0" name="s"><ssd:System name="s"><ssd:Elements>
        {}{}</ssd:Elements><ssd:Connections><ssd:Connection startElement="a" startConnector="x" endElement="b" endConnector="u"/>
        </ssd:Connections></ssd:System></ssd:SystemStructureDescription>"#,
        component("a", "output", "x"),
        component("b", "input", "u")
    );
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    write("s.ssd", &text);
    write("p.ssv", &set(5, "n"));
    let structure = folder.join("s.ssd");
    let system = super::support::load(&structure).unwrap();
    system.check_fit().unwrap();
    assert_eq!(system.wiring().unwrap().links.len(), 5);
    // Parameter sets and --set override it; the connectors then fit no more.
    write("p.ssv", &set(2, "n"));
    write("more.ssv", &set(5, "a.n"));
    let [file, set, csv] =
        ["s.ssd", "more.ssv", "s.csv"].map(|f| folder.join(f).display().to_string());
    let run = [
        "run",
        "--quiet",
        &file,
        "--stop-time",
        "1",
        "--step",
        "0.5",
        "--csv",
        &csv,
    ];
    let (code, _, error) = cosim(&run);
    assert_eq!(code, 1);
    assert_contains(
        &error,
        &["`a.x` is declared with 5 elements, but its FMU has 2"],
    );
    let more = ["--parameters", &set, "--set", "b.n=5", "--signals", "*.x*"];
    let (code, _, error) = cosim(&[&run[..], &more].concat());
    assert_eq!(code, 0, "{error}");
    let rows = fs::read_to_string(&csv).unwrap();
    assert!(
        rows.starts_with("time,a.x[1],a.x[2],a.x[3],a.x[4],a.x[5],b.x[1]"),
        "{rows}"
    );
}

/// A snapshot belongs to its sizes.
#[test]
fn a_snapshot_is_resumed_with_the_same_sizes_only() {
    let [file, _] = fmus("snapshot");
    let folder = file.parent().unwrap().to_path_buf();
    let [file, snapshot, csv] =
        ["a.fmu", "s.bin", "s.csv"].map(|f| folder.join(f).display().to_string());
    let at = format!("0.5={snapshot}");
    let run = [
        "run",
        "--quiet",
        &file,
        "--step",
        "0.5",
        "--set",
        "x0[1]=-1",
        "--csv",
        &csv,
        "--signals",
        "x",
        "--set",
    ];
    let saving = ["n=6", "--stop-time", "1", "--snapshot", &at];
    let (code, _, error) = cosim(&[&run[..], &saving].concat());
    assert_eq!(code, 0, "{error}");
    let whole = fs::read_to_string(&csv).unwrap();
    assert!(
        whole
            .lines()
            .last()
            .unwrap()
            .starts_with("1.0,0.0,22.0,33.0,44.0,55.0,66.0"),
        "{whole}"
    );
    let resumed = ["--stop-time", "1", "--resume", &snapshot];
    let (code, _, error) = cosim(&[&run[..], &["n=6"], &resumed].concat());
    assert_eq!(code, 0, "{error}");
    let rows = fs::read_to_string(&csv).unwrap();
    assert_eq!(rows.lines().last(), whole.lines().last());
    let (code, _, error) = cosim(&[&run[..], &["n=5"], &resumed].concat());
    assert_eq!(code, 1);
    assert_contains(
        &error,
        &["another run", "`a.n` is 6 in the snapshot and 5 here"],
    );
}
