//! The program `cosim` as its user calls it.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use super::support::{assert_contains, edited, fmu, oscillator, scratch, ssd, system};

/// Exit code, standard output and standard error.
pub fn cosim(arguments: &[&str]) -> (i32, String, String) {
    let done = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(arguments)
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        done.status.code().unwrap(),
        text(done.stdout),
        text(done.stderr),
    )
}

/// Spring.fmu and Mass.fmu in a folder of their own.
pub fn fmus(name: &str) -> [String; 2] {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    ["spring", "mass"].map(|example| {
        let file = folder.join(format!("{example}.fmu"));
        fs::write(&file, fmu(example)).unwrap();
        file.display().to_string()
    })
}

pub fn packed(name: &str) -> String {
    system(name, &oscillator()).unwrap();
    scratch(name).join("system.ssp").display().to_string()
}

#[track_caller]
fn refused(arguments: &[&str], parts: &[&str]) {
    let (code, _, error) = cosim(arguments);
    assert_eq!(code, 1, "{error}");
    assert_contains(&error, parts);
}

#[test]
fn mistakes_on_the_command_line_are_named() {
    let (file, [spring, _]) = (packed("program"), fmus("program-fmus"));
    let run = |more: &[&str], parts: &[&str]| {
        let mut arguments = vec!["run", "--quiet", "--system", &file];
        arguments.extend(more);
        refused(&arguments, parts);
    };
    run(
        &["--step", "-0.001"],
        &["--step -0.001: the communication step must be greater than 0 s"],
    );
    run(&["--stop-time", "-1"], &["from 0.5 s to -1 s"]);
    run(
        &["--set", "mass.x_strat=1"],
        &["`mass.x_strat`", "did you mean `mass.x_start`?"],
    );
    run(
        &["--set", "mas.x_start=1"],
        &["did you mean `mass.x_start`?"],
    );
    run(
        &["--feedthrough", "rope"],
        &["--feedthrough rope: the system has no component"],
    );
    refused(
        &["run", "--system", &spring],
        &["is an FMU, not a system structure"],
    );
}

/// Two FMUs without a structure are the oscillator: the same file, bit for bit, as of the package
/// with the same connections.
#[test]
fn fmus_run_without_a_structure() {
    let ([spring, mass], file) = (fmus("bare"), packed("bare-packed"));
    let out = |name: &str| scratch(name).display().to_string();
    let common = [
        "--step",
        "0.01",
        "--stop-time",
        "1",
        "--schedule",
        "jacobi",
        "--signals",
        "mass.x,spring.F",
        "--set",
        "spring.k=7",
    ];
    let (by_hand, by_package) = (out("bare.csv"), out("package.csv"));
    let start = [
        "--connect",
        "mass.x=spring.x",
        "--connect",
        "mass.x_dot=spring.x_dot",
        "--connect",
        "spring.F=mass.f",
    ];
    let mut arguments = vec!["run", &spring, &mass, "--csv", &by_hand, "--quiet"];
    arguments.extend(start);
    arguments.extend(common);
    let (code, text, error) = cosim(&arguments);
    assert_eq!(code, 0, "{error}");
    assert!(text.contains("1.000 s simulated"), "{text}");
    let mut arguments = vec!["run", &file, "--csv", &by_package, "--quiet"];
    arguments.extend(common);
    assert_eq!(cosim(&arguments).0, 0);
    let rows = |path: &str| {
        let text = fs::read_to_string(path).unwrap();
        let rows: Vec<String> = text
            .lines()
            .map(|l| l.split_once(',').unwrap().1.to_string())
            .collect();
        rows
    };
    let (by_hand, by_package) = (rows(&by_hand), rows(&by_package));
    // The package starts at 0.5 s, FMUs by themselves at 0 s: the motion is the same.
    assert_eq!(by_hand[..by_package.len()], by_package[..]);
    refused(
        &["run", &spring, &mass, "--connect", "mass.x=spring.y"],
        &["--connect mass.x=spring.y", "`spring.y`"],
    );
    let (code, text, _) = cosim(&["info", &spring]);
    assert_eq!(code, 0);
    assert_contains(
        &text,
        &[
            "Spring, FMI 2.0",
            "x: input, continuous Real, m",
            "depends at once on x, x_dot",
        ],
    );
}

/// F = −k x for x from a file: linear between rows for the elongation, steps for the Boolean that
/// switches it off.
#[test]
fn inputs_come_from_a_file() {
    let [spring, _] = fmus("fed");
    let file = |text: &str| -> PathBuf {
        let file = scratch("fed.in.csv");
        fs::write(&file, text).unwrap();
        file
    };
    let out = scratch("fed.csv").display().to_string();
    let run = |text: &str| {
        let input = file(text).display().to_string();
        let arguments = [
            "run",
            &spring,
            "--input",
            &input,
            "--csv",
            &out,
            "--quiet",
            "--step",
            "0.25",
            "--stop-time",
            "1",
        ];
        let more = [
            "--signals",
            "spring.F",
            "--set",
            "spring.k=2",
            "--schedule",
            "jacobi",
        ];
        cosim(&[&arguments[..], &more[..]].concat())
    };
    let (code, _, error) = run("time,spring.x,spring.off\n0,1,false\n0.5,3,true\n2,3,0\n");
    assert_eq!(code, 0, "{error}");
    let text = fs::read_to_string(&out).unwrap();
    assert_eq!(
        text,
        "time,spring.F\n0.0,-2.0\n0.25,-4.0\n0.5,0.0\n0.75,0.0\n1.0,0.0\n"
    );
    for (text, part) in [
        (
            "time;spring.x\n0;1\n",
            "row 1: columns are separated by `;`",
        ),
        ("t,spring.x\n0,1\n", "row 1: the first column is `t`"),
        ("time,spring.y\n0,1\n", "row 1, column `spring.y`"),
        (
            "time,spring.F\n0,1\n",
            "is no input that takes numbers; it is of type Real, output",
        ),
        (
            "time,spring.x,spring.x\n0,1,1\n",
            "two columns are named `spring.x`",
        ),
        (
            "time,spring.x\n0,1\n1,soft\n",
            "row 3, column `spring.x`: `soft` is not a finite number",
        ),
        (
            "time,spring.x\n0,1\n0,2\n0,3\n",
            "row 4: the time 0 s stands in three rows",
        ),
        (
            "time,spring.x\n0,1,2\n",
            "row 2 has 3 columns; it must have 2",
        ),
        ("time,spring.x\n", "it has no rows of numbers"),
        ("", "it is empty"),
    ] {
        let (code, _, error) = run(text);
        assert!(
            code == 1 && error.contains(part) && error.contains("fed.in.csv"),
            "{text:?}: {error}"
        );
    }
    let package = packed("fed-packed");
    let input = file("time,spring.x\n0,1\n").display().to_string();
    refused(
        &["run", &package, "--input", &input, "--quiet"],
        &["column `spring.x`: the connection from `mass.x` drives it"],
    );
}

/// A banner that an FMU prints when it is made is named as its, and is not in what the program
/// prints.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn what_an_fmu_prints_is_named() {
    super::foreign::plain_fmu("banner");
    let file = scratch("banner").join("plain.fmu").display().to_string();
    let (code, text, error) =
        cosim(&["run", &file, "--quiet", "--step", "0.1", "--stop-time", "1"]);
    assert_eq!(code, 0, "{error}");
    assert!(
        text.contains("1.000 s simulated") && !text.contains("plain: "),
        "{text}"
    );
    assert!(
        error.starts_with("plain (FMU `") && error.contains("prints: plain: licensed to nobody"),
        "{error}"
    );
}

/// The step that the structure asks for counts where the command line names none, and is told.
#[test]
fn the_step_is_that_of_the_structure_or_of_the_fmus() {
    let structure = oscillator().replace(
        "stopTime=\"2.5\"/>",
        "stopTime=\"2.5\"><ssd:Annotations><ssc:Annotation type=\"com.opensimulationplatform\"><osp:Algorithm>\
         <osp:FixedStepAlgorithm baseStepSize=\"0.02\"/></osp:Algorithm></ssc:Annotation></ssd:Annotations></ssd:DefaultExperiment>",
    );
    system("based", &structure).unwrap();
    let file = scratch("based").join("system.ssp").display().to_string();
    let (code, text, error) = cosim(&["run", &file, "--quiet"]);
    assert_eq!(code, 0, "{error}");
    assert!(
        text.contains("the communication step is 0.02 s, as the system structure asks"),
        "{text}"
    );
    let (_, text, _) = cosim(&["run", &file, "--quiet", "--step", "0.01"]);
    assert!(!text.contains("communication step is"), "{text}");
}

/// Inputs of the outermost system feed components, converted to their units; a value that matches
/// nothing is told, and refused with `--strict`.
#[test]
fn inputs_of_the_system_are_set_by_name() {
    let outer = ssd("")
        .replace(
            "<ssd:Elements>",
            "<ssd:Connectors><ssd:Connector name=\"stretch\" kind=\"input\"><ssc:Real unit=\"mm\"/></ssd:Connector>\
             <ssd:Connector name=\"force\" kind=\"output\"/></ssd:Connectors><ssd:ParameterBindings><ssd:ParameterBinding>\
             <ssd:ParameterValues><ssv:ParameterSet version=\"1.0\" name=\"p\"><ssv:Parameters><ssv:Parameter name=\"spring.kk\">\
             <ssv:Real value=\"1\"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding>\
             </ssd:ParameterBindings><ssd:Elements>",
        )
        .replace(
            "<ssd:Connections>",
            "<ssd:Connections><ssd:Connection startConnector=\"stretch\" endElement=\"spring\" endConnector=\"x\"/>\
             <ssd:Connection startElement=\"spring\" startConnector=\"F\" endConnector=\"force\"/>",
        )
        .replace(
            "</ssd:System>",
            "</ssd:System><ssd:Units><ssc:Unit name=\"mm\"><ssc:BaseUnit m=\"1\" factor=\"0.001\"/></ssc:Unit></ssd:Units>",
        );
    edited("outer", &outer, |_, text| text.to_string()).unwrap();
    let file = scratch("outer").join("system.ssp").display().to_string();
    let out = scratch("outer.csv").display().to_string();
    let arguments = [
        "run",
        &file,
        "--quiet",
        "--step",
        "0.5",
        "--set",
        "stretch=250",
        "--set",
        "spring.k=8",
        "--csv",
        &out,
    ];
    let (code, text, error) = cosim(&[&arguments[..], &["--signals", "spring.F"]].concat());
    assert_eq!(code, 0, "{error}");
    assert!(
        text.contains("parameter values that match no variable are ignored: `spring.kk`"),
        "{text}"
    );
    let rows = fs::read_to_string(&out).unwrap();
    assert_eq!(rows.lines().nth(1), Some("0.5,-2.0"), "8 N/m times 0.25 m");
    refused(
        &[&arguments[..], &["--set", "strech=1"]].concat(),
        &["--set strech=1", "did you mean `stretch`?"],
    );
    refused(
        &[&arguments[..], &["--strict"]].concat(),
        &[
            "--strict",
            "parameter values that match no variable",
            "`spring.kk`",
        ],
    );
}

/// A mass whose names and units are its own, in the place of the mass: with a mapping it is the
/// same oscillator, bit for bit.
#[test]
fn an_fmu_with_names_of_its_own_takes_the_place_of_another() {
    let own = |example: &str, text: &str| match example {
        "mass" => text
            .replace("name=\"x\"", "name=\"position\"")
            .replace("name=\"f\"", "name=\"push\""),
        _ => text.to_string(),
    };
    edited("own-names", &oscillator(), own).unwrap();
    let package = packed("own-names-other");
    let folder = scratch("own-names");
    let bytes = fs::read(folder.join("system.ssp")).unwrap();
    let mut archive = fmi_description::Archive::open(bytes).unwrap();
    let fmu = folder.join("Own.fmu");
    fs::write(&fmu, archive.file("resources/Mass.fmu").unwrap().unwrap()).unwrap();
    let map = folder.join("own.ssm");
    let entry = |source: &str, target: &str, factor: &str| {
        format!(
            "<ssm:MappingEntry source=\"{source}\" target=\"{target}\"><ssc:LinearTransformation factor=\"{factor}\"/></ssm:MappingEntry>"
        )
    };
    let mapping = |entries: &str| {
        let text = format!(
            "<ssm:ParameterMapping xmlns:ssm=\"m\" xmlns:ssc=\"c\" version=\"1.0\">{entries}</ssm:ParameterMapping>"
        );
        fs::write(&map, text).unwrap();
    };
    mapping(&(entry("x", "position", "1") + &entry("f", "push", "1")));
    let (fmu, map) = (format!("mass={}", fmu.display()), map.display().to_string());
    let out = |name: &str| scratch(name).display().to_string();
    let (a, b) = (out("own-a.csv"), out("own-b.csv"));
    let run = |signals: &str, out: &str, more: &[&str]| {
        let common = [
            "run",
            &package,
            "--quiet",
            "--step",
            "0.01",
            "--set",
            "spring.k=9",
            "--csv",
            out,
            "--signals",
            signals,
        ];
        cosim(&[&common[..], more].concat())
    };
    let rows = |path: &str| {
        let text = fs::read_to_string(path).unwrap();
        text.lines().skip(1).map(str::to_string).collect::<Vec<_>>()
    };
    assert_eq!(run("mass.x,spring.F", &a, &[]).0, 0);
    let replaced = ["--fmu", &fmu, "--map", &map];
    let (code, _, error) = run("mass.position,spring.F", &b, &replaced);
    assert_eq!(code, 0, "{error}");
    assert_eq!(rows(&a), rows(&b));
    // Half the force is another motion.
    mapping(&(entry("x", "position", "1") + &entry("f", "push", "0.5")));
    assert_eq!(run("mass.position,spring.F", &b, &replaced).0, 0);
    assert_ne!(rows(&a), rows(&b));
    // What the mapping names but the FMU does not have is refused; what it leaves out is said.
    mapping(&entry("x", "place", "1"));
    let (code, _, error) = run("spring.F", &b, &replaced);
    assert!(
        code == 1 && error.contains("own.ssm") && error.contains("no variable `place`"),
        "{error}"
    );
    mapping(&entry("x", "position", "1"));
    let (code, text, _) = run("spring.F", &b, &replaced);
    assert!(
        code == 0 && text.contains("not connected: spring.F -> mass.f"),
        "{text}"
    );
}

/// A parameter of the system reaches the parameters of its components before the run; a unit at one
/// end only passes with a remark.
#[test]
fn parameters_of_the_system_and_lone_units() {
    let structure = oscillator()
        .replace(
            "<ssd:Elements>",
            "<ssd:Connectors><ssd:Connector name=\"stiffness\" kind=\"parameter\"/></ssd:Connectors><ssd:Elements>",
        )
        .replacen(
            "<ssd:Connector name=\"x\" kind=\"input\">",
            "<ssd:Connector name=\"k\" kind=\"parameter\"/><ssd:Connector name=\"x\" kind=\"input\">",
            1,
        )
        .replace(
            "<ssd:Connections>",
            "<ssd:Connections><ssd:Connection startConnector=\"stiffness\" endElement=\"spring\" endConnector=\"k\"/>",
        );
    let bare = |example: &str, text: &str| match example {
        "mass" => text.replace("unit=\"m\"", ""),
        _ => text.to_string(),
    };
    edited("lone", &structure, bare).unwrap();
    let file = scratch("lone").join("system.ssp").display().to_string();
    let out = scratch("lone.csv").display().to_string();
    let (code, text, error) = cosim(&[
        "run",
        &file,
        "--quiet",
        "--step",
        "0.5",
        "--csv",
        &out,
        "--signals",
        "spring.F",
        "--set",
        "stiffness=4",
        "--set",
        "mass.x_start=0.5",
    ]);
    assert_eq!(code, 0, "{error}");
    assert!(
        text.contains(
            "connection mass.x -> spring.x: only one end has a unit, `m`; values pass unchanged"
        ),
        "{text}"
    );
    let rows = fs::read_to_string(&out).unwrap();
    assert_eq!(rows.lines().nth(1), Some("0.5,-2.0"), "4 N/m times 0.5 m");
}
