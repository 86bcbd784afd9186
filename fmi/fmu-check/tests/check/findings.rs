//! What a check says of what it finds: which of it breaks the standard, in which call and for which
//! variable, and with which exit code; and what it finds in Model Exchange.

use std::fs;
use std::process::Command;

use crate::faulty::checked;
use crate::running::{DESCRIPTION, compiled, entries, library, sound_entries};
use fmi_description::entries::{self, Entries};
use fmu_check::Verdict;
use tempfile::TempDir;

use Verdict::{Fails, NotRobust};

/// A crash or a hang names the call, and the variable if one is read or set.
#[test]
fn the_call_that_ends_a_process_is_named() {
    let folder = TempDir::new().unwrap();
    let report = |mistake, only| {
        checked(
            &entries(DESCRIPTION, &library(folder.path(), mistake)),
            only,
        )
        .to_string()
    };
    for (mistake, only, part) in [
        (
            "CRASH",
            "it initializes and steps",
            "! fmi2DoStep at t = 0 s crashed with a",
        ),
        (
            "CRASH_AT_Z",
            "it initializes and steps",
            "! fmi2GetReal of `z` at t = 0.01 s crashed",
        ),
        (
            "WILD_REFERENCE",
            "unknown value references",
            "~ fmi2GetReal of the value reference 5, which no variable has, at t = 0.1 s crashed",
        ),
        (
            "NULL_CRASH",
            "NULL instead of",
            "~ NULL: fmi2EnterInitializationMode crashed with a",
        ),
    ] {
        let report = report(mistake, only);
        assert!(report.contains(part), "{mistake}: {report}");
    }
}

const EXCHANGE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Swing" guid="{1}">
  <ModelExchange modelIdentifier="lag"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="x" valueReference="2" initial="exact"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="v" valueReference="3" initial="exact"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="der(x)" valueReference="4"><Real derivative="3"/></ScalarVariable>
    <ScalarVariable name="der(v)" valueReference="5"><Real derivative="4"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies="3"/></Outputs>
    <Derivatives><Unknown index="5" dependencies="1 4"/><Unknown index="6" dependencies="3"/></Derivatives>
    <InitialUnknowns><Unknown index="2"/><Unknown index="5"/><Unknown index="6"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>"#;

#[test]
fn a_dependency_that_is_not_declared_is_found_in_model_exchange() {
    const MOVING: &str = "derivatives and outputs move at once only with";
    let folder = TempDir::new().unwrap();
    let library = compiled(folder.path(), "exchange.c", "NONE");
    let report = |description: &str, only: &str| {
        let report = checked(&entries(description, &library), only);
        assert_eq!(report.rows.len(), 1, "{report}");
        (report.rows[0].outcome.verdict(), report.to_string())
    };
    for only in [MOVING, "an importer integrates it"] {
        let (verdict, text) = report(EXCHANGE, only);
        assert_eq!(verdict, Verdict::Pass, "{text}");
    }
    for (was, is, fault) in [
        (
            "\"1 4\"",
            "\"4\"",
            "`u` acts on `der(x)`, which does not list it",
        ),
        (
            "\"1 4\"",
            "\"1\"",
            "`v` acts on `der(x)`, which does not list it",
        ),
        (
            "\"2\" dependencies=\"3\"",
            "\"2\" dependencies=\"\"",
            "`x` acts on `y`, which does not list it",
        ),
    ] {
        let (verdict, text) = report(&EXCHANGE.replacen(was, is, 1), MOVING);
        assert_eq!(verdict, Fails, "{text}");
        assert!(text.contains(fault), "{text}");
    }
}

/// No vector of length 0 is asked for.
#[test]
fn model_exchange_without_states_passes() {
    let folder = TempDir::new().unwrap();
    let library = compiled(folder.path(), "exchange.c", "WITHOUT_STATES -DSTATES=0");
    let (head, rest) = EXCHANGE
        .split_once("    <ScalarVariable name=\"x\"")
        .unwrap();
    let (_, structure) = rest.split_once("  </ModelVariables>").unwrap();
    let (outputs, _) = structure.split_once("    <Derivatives>").unwrap();
    let outputs = outputs.replace("dependencies=\"3\"", "dependencies=\"1\"");
    let description = format!(
        "{head}  </ModelVariables>{outputs}    <InitialUnknowns><Unknown index=\"2\"/></InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>"
    );
    for only in ["move at once only with", "an importer integrates it"] {
        let report = checked(&entries(&description, &library), only);
        assert_eq!(report.count(Verdict::Pass), 1, "{report}");
    }
}

#[test]
fn options_that_select_nothing_are_refused() {
    let folder = TempDir::new().unwrap();
    let fmu = folder.path().join("lag.fmu");
    entries::write(&fmu, &sound_entries(folder.path())).unwrap();
    let run = |options: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_fmu-check"));
        let output = program.args(options).arg(&fmu).output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    for (options, part) in [
        (
            ["--timeout", "0"],
            "invalid value '0' for '--timeout <SECONDS>'",
        ),
        (["--timeout", "-1"], "unexpected argument '-1'"),
        (
            ["--timeout", "1e3"],
            "invalid value '1e3' for '--timeout <SECONDS>'",
        ),
        (
            ["--only", "typo"],
            "--only 'typo': no promise that applies to it",
        ),
        (["--only", ""], "a value is required for '--only <WORDS>'"),
    ] {
        let (code, text) = run(&options);
        assert_eq!(code, Some(2), "{options:?}: {text}");
        assert!(text.contains(part), "{options:?}: {text}");
    }
    // What FMI 3.0 alone promises is not checked in FMI 2.0.
    let (code, text) = run(&["--only", "dimensions are fixed sizes"]);
    assert_eq!(code, Some(2), "{text}");
    assert_eq!(run(&["--only", "the library loads"]).0, Some(0));
    // An archive that cannot be opened does not pass because of what was asked for.
    fs::write(&fmu, b"text").unwrap();
    assert_eq!(run(&["--only", "the library loads"]).0, Some(1));
}

/// The standard does not ask for it (FMI 2.0 ignores display units that are not defined).
#[test]
fn what_no_standard_asks_of_a_description_is_not_robust() {
    for (was, is, promise) in [
        (
            "displayUnit=\"mm\"",
            "displayUnit=\"cm\"",
            "units and display units are defined",
        ),
        ("stopTime=\"1\"", "stopTime=\"-1\"", "default experiment"),
        (
            "min=\"0.1\"",
            "min=\"0.1\" nominal=\"0\"",
            "min ≤ start ≤ max",
        ),
    ] {
        let changed = DESCRIPTION.replacen(was, is, 1);
        assert_ne!(changed, DESCRIPTION);
        let files = Entries::from([("modelDescription.xml".to_string(), changed.into())]);
        let report = checked(&files, promise);
        let verdicts: Vec<_> = report
            .rows
            .iter()
            .map(|row| row.outcome.verdict())
            .collect();
        assert_eq!(verdicts[0], NotRobust, "{report}");
    }
}

#[test]
fn the_exit_code_tells_whether_it_passes() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let run = |mistake: &str, options: &[&str]| {
        let fmu = folder.join("lag.fmu");
        entries::write(&fmu, &entries(DESCRIPTION, &library(folder, mistake))).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_fmu-check"));
        program.args(options).arg(fmu);
        let output = program.output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap(),
        )
    };
    let (code, table) = run("ANY_GUID", &[]);
    assert_eq!(code, Some(0), "{table}");
    assert!(
        table.contains("0 failed (the standard is broken), 1 not robust (no standard asks for it), 0 not checked"),
        "{table}"
    );
    assert_eq!(run("ANY_GUID", &["--strict"]).0, Some(1));
    assert_eq!(run("VERSION", &[]).0, Some(1));
    // A crash that no standard forbids.
    assert_eq!(run("NULL_CRASH", &[]).0, Some(0));
    assert_eq!(run("NULL_CRASH", &["--strict"]).0, Some(1));
}
