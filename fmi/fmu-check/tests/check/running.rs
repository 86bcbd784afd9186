//! What an FMU does when it is run, and the mistakes of a description of FMI 2.0.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::faulty::{checked, checked_within, must_be_found};
use fmi_description::entries::Entries;
use fmu_check::{self, Verdict};
use tempfile::TempDir;

use Verdict::{Fails, NotRobust};

pub const DESCRIPTION: &str = include_str!("modelDescription.xml");
const DESCRIPTION_3: &str = include_str!("modelDescription3.xml");

/// The library with a mistake.
pub fn library(folder: &Path, mistake: &str) -> Vec<u8> {
    compiled(folder, "lag.c", mistake)
}

pub fn compiled(folder: &Path, source: &str, mistake: &str) -> Vec<u8> {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/check");
    let source = sources.join(source);
    let out = folder.join("lag.so");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_string());
    let mut cc = Command::new(compiler);
    let mistake = match mistake.starts_with("WITHOUT_") {
        true => format!("-D{mistake}"),
        false => format!("-DMISTAKE={mistake}"),
    };
    cc.args(["-shared", "-fPIC", "-s"]).args(mistake.split(' '));
    let status = cc
        .arg("-o")
        .arg(&out)
        .arg(source)
        .arg("-lm")
        .status()
        .unwrap();
    assert!(status.success());
    fs::read(out).unwrap()
}

pub fn entries(description: &str, library: &[u8]) -> Entries {
    packed(description, "linux64", library)
}

fn packed(description: &str, platform: &str, library: &[u8]) -> Entries {
    let description = ("modelDescription.xml".to_string(), description.into());
    let library = (format!("binaries/{platform}/lag.so"), library.to_vec());
    Entries::from([description, library])
}

/// The FMU of FMI 3.0 with a mistake.
fn entries_3(folder: &Path, mistake: &str) -> Entries {
    let library = compiled(folder, "lag3.c", mistake);
    packed(DESCRIPTION_3, "x86_64-linux", &library)
}

/// Check the FMU with each mistake; what is not as said.
fn mistakes(expected: &[(&str, Verdict, &str)]) {
    found(expected, |folder, mistake| {
        entries(DESCRIPTION, &library(folder, mistake))
    });
}

fn found(expected: &[(&str, Verdict, &str)], entries: impl Fn(&Path, &str) -> Entries) {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    for (mistake, verdict, promise) in expected {
        let report = checked(&entries(folder, mistake), promise);
        let verdicts: Vec<_> = report
            .rows
            .iter()
            .map(|row| row.outcome.verdict())
            .collect();
        assert_eq!(verdicts, [*verdict], "{mistake}: `{promise}`:\n{report}");
    }
}

#[test]
fn an_fmu_by_the_book_passes_every_row() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let report = checked(&entries(DESCRIPTION, &library(folder, "NONE")), "");
    assert_eq!(report.count(Verdict::Pass), report.rows.len(), "{report}");
    assert!(report.rows.len() > 45, "{report}");
}

#[test]
fn mistakes_of_loading_and_simulation_are_found() {
    mistakes(&[
        ("VERSION", Fails, "it says that it is of the version"),
        ("ANY_GUID", NotRobust, "refused for another one"),
        ("PLAIN_PATHS", Fails, "a space and an umlaut"),
        ("FREE_NULL", Fails, "an instance of NULL"),
        ("CRASH", Fails, "initializes and steps"),
        (
            "NAN_OUTPUT",
            Fails,
            "every number that it hands out is finite",
        ),
        ("EXACT_GRID", Fails, "running sum of h"),
        ("START_AT_0", NotRobust, "another time than 0"),
        ("NO_STOP", Fails, "a step to the stop time"),
        ("ONE_SIZE", Fails, "steps may differ in length"),
        ("MUTE_AT_END", Fails, "after termination"),
    ]);
}

#[test]
fn mistakes_of_values_and_instances_are_found() {
    mistakes(&[
        ("OTHER_START", Fails, "begin at the start values"),
        ("ROUNDED", NotRobust, "read back bit for bit"),
        ("FEEDTHROUGH", Fails, "list it in their dependencies"),
        ("GLOBAL", Fails, "one after the other"),
        ("SHARED", Fails, "takes turns with it"),
        ("FEW", Fails, "a dozen instances"),
        ("ONE_THREAD", NotRobust, "in four threads"),
        ("HALF_RESET", Fails, "after a reset"),
        ("HALF_STATE", Fails, "a state that is set again"),
        ("HALF_BYTES", Fails, "carry it to another instance"),
        ("NO_CHECKSUM", NotRobust, "damaged bytes are refused"),
    ]);
}

#[test]
fn mistakes_of_derivatives_misuse_and_log_are_found() {
    mistakes(&[
        ("WRONG_SLOPE", NotRobust, "are the slopes of the outputs"),
        ("NO_DERIVATIVE", Fails, "derivatives of outputs are given"),
        (
            "NO_INPUT_DERIVATIVE",
            Fails,
            "derivatives of inputs are taken",
        ),
        ("ANY_REFERENCE", NotRobust, "unknown value references"),
        ("ANY_NUMBER", NotRobust, "NaN and infinity"),
        ("WRITABLE", NotRobust, "fixed parameters cannot be set"),
        ("ANY_STEP", NotRobust, "jumps in time"),
        ("NULL_CRASH", NotRobust, "NULL instead of an instance"),
        ("ANY_ORDER", NotRobust, "calls out of order"),
        ("CATEGORY", Fails, "messages have a declared category"),
        ("CHATTER", NotRobust, "with loggingOn = false"),
        ("PRINT", NotRobust, "nothing is printed"),
    ]);
}

/// What its maker did not foresee does not keep the rest from being seen.
#[test]
fn a_check_goes_on_where_it_can() {
    const PLAIN_RUN: &str = "it initializes and steps";
    const MESSAGES: &str = "messages have a declared category";
    mistakes(&[
        ("NO_STRINGS", Verdict::Pass, PLAIN_RUN), // it has none, and is asked for none
        ("NO_STRINGS", Verdict::Pass, "calls out of order"),
        ("NO_STRINGS", Verdict::Pass, "unknown value references"),
        ("WITHOUT_STRINGS", Verdict::Pass, PLAIN_RUN),
        (
            "WITHOUT_STRINGS",
            Fails,
            "each library exports every function",
        ),
        ("OTHER_ENVIRONMENT", Fails, MESSAGES),
        ("NOWHERE", Fails, MESSAGES),
        ("NO_INSTANCE", Fails, PLAIN_RUN),
    ]);
    // By the standard an error may end the simulation.
    mistakes(&[("ENDS_AT_ERROR", NotRobust, "damaged bytes are refused")]);
    // Nothing is asked for after the stop time.
    // What FMI 2.0 does not let an importer read is not asked for, or its refusal is no fault.
    mistakes(&[
        ("STRICT_START", Verdict::Pass, "begin at the start values"),
        ("STRICT_ORDER", Verdict::Pass, "an input acts at once only"),
        (
            "STRICT_ORDER",
            Verdict::Pass,
            "are the slopes of the outputs",
        ),
        ("STRICT_ORDER", NotRobust, "read back bit for bit"),
        // The crash of a row is not that of another one.
        ("WILD_REFERENCE", NotRobust, "unknown value references"),
        ("WILD_REFERENCE", Verdict::Pass, MESSAGES),
    ]);
    found(
        &[("ENDS_AT_STOP", Verdict::Pass, PLAIN_RUN)],
        |folder, mistake| {
            let short = DESCRIPTION.replace("stopTime=\"1\"", "stopTime=\"0.2\"");
            assert_ne!(short, DESCRIPTION);
            entries(&short, &library(folder, mistake))
        },
    );
    let folder = TempDir::new().unwrap();
    let report = |mistake| checked(&entries(DESCRIPTION, &library(folder.path(), mistake)), "");
    let of = |report: &fmu_check::Report, verdict| {
        let rows = report.rows.iter();
        let rows = rows.filter(|row| row.outcome.verdict() == verdict);
        rows.map(|row| row.promise.text).collect::<Vec<_>>()
    };
    let rows = report("NONE").rows.len();
    // One row fails, and all others are there and pass.
    let number = report("NAN_OUTPUT");
    assert_eq!(number.rows.len(), rows, "{number}");
    assert_eq!(of(&number, Fails).len(), 1, "{number}");
    let nowhere = report("OTHER_ENVIRONMENT").to_string();
    let expected = "a message came with another environment than fmi2Instantiate was given: ";
    assert!(nowhere.contains(expected), "{nowhere}");
    // What fails for the same reason is said once.
    let nothing = report("NO_INSTANCE");
    assert_eq!(nothing.rows.len(), rows, "{nothing}");
    let failing = of(&nothing, Fails);
    assert_eq!(failing.len(), 1, "{nothing}");
    assert!(failing[0].starts_with(PLAIN_RUN), "{nothing}");
    assert!(of(&nothing, Verdict::NotChecked).len() > 25, "{nothing}");
}

#[test]
fn all_probes_together_have_a_limit() {
    let folder = TempDir::new().unwrap();
    let entries = entries(DESCRIPTION, &library(folder.path(), "HANG"));
    let clock = std::time::Instant::now();
    let report = checked_within(&entries, "", Duration::from_secs(2)).to_string();
    assert!(clock.elapsed() < Duration::from_secs(20), "{report}");
    assert!(
        report.contains("? no answer when the time for all probes was up, 2 s"),
        "{report}"
    );
    assert!(
        report.contains("all probes together may take 2 s (--timeout)"),
        "{report}"
    );
    // Where nothing hangs, the limit itself ends it.
    let sound = sound_entries(folder.path());
    let report = checked_within(&sound, "", Duration::ZERO).to_string();
    let expected = "all probes together may take 0 s (--timeout)";
    assert!(report.contains(expected), "{report}");
}

pub fn sound_entries(folder: &Path) -> Entries {
    entries(DESCRIPTION, &library(folder, "NONE"))
}

/// An identifier with a hyphen, a library of another name, and a description in another encoding
/// are faults, but it can be run.
#[test]
fn what_is_named_or_written_wrongly_is_run_all_the_same() {
    let folder = TempDir::new().unwrap();
    let library = library(folder.path(), "NONE");
    let hyphen = DESCRIPTION.replace("modelIdentifier=\"lag\"", "modelIdentifier=\"l-ag\"");
    let latin = DESCRIPTION.replace("encoding=\"UTF-8\"", "encoding=\"ISO-8859-1\"");
    let latin = latin.replacen("modelName=\"", "modelName=\"\u{e4}", 1);
    assert!(latin != DESCRIPTION && hyphen != DESCRIPTION);
    let latin: Vec<u8> = latin.chars().map(|c| u8::try_from(c).unwrap()).collect();
    for (description, row) in [
        (hyphen.as_bytes(), "named after the model identifier"),
        (&latin, "is UTF-8, well-formed"),
    ] {
        let mut files = entries(DESCRIPTION, &library);
        files.insert("modelDescription.xml".into(), description.to_vec());
        let verdict = |only| {
            let report = checked(&files, only);
            assert_eq!(report.rows.len(), 1, "{report}");
            report.rows[0].outcome.verdict()
        };
        assert_eq!(verdict(row), Fails, "{row}");
        assert_eq!(verdict("it initializes and steps"), Verdict::Pass, "{row}");
    }
}

#[test]
fn an_fmu_of_fmi_3_by_the_book_passes_every_row() {
    let folder = TempDir::new().unwrap();
    let report = checked(&entries_3(folder.path(), "NONE"), "");
    assert_eq!(report.count(Verdict::Pass), report.rows.len(), "{report}");
    assert!(report.rows.len() > 50, "{report}");
}

/// Without Event Mode nothing is read in Step Mode between a set and the next step: the library
/// refuses that, as the standard has it.
#[test]
fn an_fmu_of_fmi_3_without_event_mode_passes_what_can_be_seen() {
    let folder = TempDir::new().unwrap();
    let library = compiled(folder.path(), "lag3.c", "NO_EVENTS");
    let description = DESCRIPTION_3.replace("hasEventMode=\"true\"", "hasEventMode=\"false\"");
    assert_ne!(description, DESCRIPTION_3);
    let report = checked(&packed(&description, "x86_64-linux", &library), "");
    let others = report.rows.iter();
    let others = others.filter(|row| row.outcome.verdict() != Verdict::Pass);
    let promises: Vec<_> = others
        .map(|row| (row.outcome.verdict(), row.promise.text))
        .collect();
    let [acting, slopes] = &promises[..] else {
        panic!("{report}");
    };
    assert_eq!([acting.0, slopes.0], [Verdict::NotChecked; 2], "{report}");
    assert!(acting.1.starts_with("an input acts at once"), "{report}");
    assert!(slopes.1.contains("slopes of the outputs"), "{report}");
    assert!(!report.to_string().contains("fmi2"), "{report}");
}

#[test]
fn mistakes_of_simulation_are_found_in_fmi_3() {
    const LAST_TIME: &str = "a step tells how it ended";
    found(
        &[
            ("VERSION", Fails, "it says that it is of the version"),
            ("ANY_GUID", NotRobust, "refused for another one"),
            ("PLAIN_PATHS", Fails, "a space and an umlaut"),
            ("FREE_NULL", Fails, "an instance of NULL"),
            ("CRASH", Fails, "initializes and steps"),
            (
                "NAN_OUTPUT",
                Fails,
                "every number that it hands out is finite",
            ),
            ("EXACT_GRID", Fails, "running sum of h"),
            ("START_AT_0", NotRobust, "another time than 0"),
            ("NO_STOP", Fails, "a step to the stop time"),
            ("ONE_SIZE", Fails, "steps may differ in length"),
            ("MUTE_AT_END", Fails, "after termination"),
            ("UNASKED_RETURN", Fails, LAST_TIME),
            ("WRONG_TIME", Fails, LAST_TIME),
        ],
        entries_3,
    );
}

#[test]
fn mistakes_of_values_and_instances_are_found_in_fmi_3() {
    found(
        &[
            ("OTHER_START", Fails, "begin at the start values"),
            ("ROUNDED", NotRobust, "read back bit for bit"),
            ("FEEDTHROUGH", Fails, "list it in their dependencies"),
            ("GLOBAL", Fails, "one after the other"),
            ("SHARED", Fails, "takes turns with it"),
            ("FEW", Fails, "a dozen instances"),
            ("HALF_RESET", Fails, "after a reset"),
            ("HALF_STATE", Fails, "a state that is set again"),
            ("HALF_BYTES", Fails, "carry it to another instance"),
            ("NO_CHECKSUM", NotRobust, "damaged bytes are refused"),
        ],
        entries_3,
    );
}

#[test]
fn mistakes_of_derivatives_misuse_and_log_are_found_in_fmi_3() {
    found(
        &[
            ("WRONG_SLOPE", NotRobust, "are the slopes of the outputs"),
            ("WRONG_TRANSPOSE", Fails, "the directional ones transposed"),
            (
                "HIDDEN_DEPENDENCY",
                Fails,
                "dependencies of elements are those",
            ),
            ("ANY_ELEMENT", Fails, "dependencies of elements are those"),
            ("NO_DERIVATIVE", Fails, "derivatives of outputs are given"),
            ("ANY_REFERENCE", NotRobust, "unknown value references"),
            ("ANY_NUMBER", NotRobust, "NaN and infinity"),
            (
                "ANY_COUNT",
                NotRobust,
                "a number of values that does not fit",
            ),
            ("WRITABLE", NotRobust, "fixed parameters cannot be set"),
            ("ANY_STEP", NotRobust, "jumps in time"),
            ("NULL_CRASH", NotRobust, "NULL instead of an instance"),
            ("ANY_ORDER", NotRobust, "calls out of order"),
            ("CATEGORY", Fails, "messages have a declared category"),
            ("CHATTER", Fails, "with loggingOn = false"),
            ("PRINT", NotRobust, "nothing is printed"),
        ],
        entries_3,
    );
}

/// One change of the model description each, and the row that must fail.
#[test]
fn mistakes_of_the_description_are_found() {
    let changes = [
        (
            "causality=\"input\"",
            "causality=\"inlet\"",
            "valid by the schema",
        ),
        ("</ModelStructure>", "", "valid by the schema"),
        ("name=\"z\"", "name=\"y\"", "names are unique"),
        ("name=\"z\"", "name=\"2z\"", "follow their grammar"),
        (
            "valueReference=\"2\"",
            "valueReference=\"0\"",
            "one value reference is one quantity",
        ),
        (" start=\"2\"", "", "start is given where it must be"),
        (
            "<Real unit=\"m\"/></ScalarVariable>",
            "<Real unit=\"m\" start=\"1\"/></ScalarVariable>",
            "start is given where it must be",
        ),
        (
            "causality=\"parameter\" variability=\"fixed\"",
            "causality=\"parameter\" variability=\"continuous\"",
            "variability and initial go together",
        ),
        ("min=\"0.1\"", "min=\"0.7\"", "min ≤ start ≤ max"),
        (
            "min=\"0.1\"",
            "min=\"0.1\" max=\"0.05\"",
            "min ≤ start ≤ max",
        ),
        (
            "declaredType=\"Length\"",
            "declaredType=\"Width\"",
            "declared types exist",
        ),
        (
            "unit=\"s\"",
            "unit=\"h\"",
            "units and display units are defined",
        ),
        (
            "<Unknown index=\"4\" dependencies=\"\"/>",
            "",
            "Outputs lists every output",
        ),
        (
            "<Unknown index=\"4\"",
            "<Unknown index=\"3\"",
            "Outputs lists every output",
        ),
        (
            "<Unknown index=\"5\" dependencies=\"1 3\"/>",
            "<Unknown index=\"4\"/>",
            "InitialUnknowns lists exactly",
        ),
        (
            "dependencies=\"1 3\" d",
            "dependencies=\"1 9\" d",
            "dependencies and derivatives name variables",
        ),
        (
            "dependenciesKind=\"dependent dependent\"",
            "dependenciesKind=\"dependent\"",
            "one word for each",
        ),
        (
            "modelIdentifier=\"lag\"",
            "modelIdentifier=\"l-g\"",
            "identity, default experiment",
        ),
    ];
    must_be_found(DESCRIPTION, &changes, |changed, promise| {
        // No library: nothing is run, which the last row says.
        let without = [("modelDescription.xml".to_string(), changed.into())];
        checked(&Entries::from(without), promise)
    });
}
