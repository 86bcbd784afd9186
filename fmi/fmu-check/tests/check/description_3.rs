//! `cargo fmu check` on a description of FMI 3.0 by the book, with a construct of each kind, and on
//! that description with one mistake at a time: each mistake must be found in the row of the rule
//! that it breaks.

use fmi_description::Entries;
use fmu_check::{Report, Verdict};

const DESCRIPTION: &str = include_str!("rich3.xml");
const TERMINALS: &str = include_str!("terminals.xml");

/// Without a library: nothing is run.
fn checked(description: &str, terminals: &str, only: &str) -> Report {
    let files = [
        ("modelDescription.xml", description),
        ("terminalsAndIcons/terminalsAndIcons.xml", terminals),
        ("terminalsAndIcons/rod.png", ""),
    ];
    let files = files.map(|(name, text)| (name.to_string(), text.as_bytes().to_vec()));
    crate::faulty::checked(&Entries::from(files), only)
}

/// What is found of changes of the description: text, what stands there instead, the row that must
/// fail.
fn must_be_found(changes: &[(&str, &str, &str)]) {
    crate::faulty::must_be_found(DESCRIPTION, changes, |changed, promise| {
        checked(changed, TERMINALS, promise)
    });
}

#[test]
fn a_description_by_the_book_passes() {
    let report = checked(DESCRIPTION, TERMINALS, "");
    let areas = ["model description", "variables", "terminals"];
    let rows = report.rows.iter().filter(|row| areas.contains(&row.area));
    let rows: Vec<_> = rows.map(|row| row.outcome.verdict()).collect();
    assert_eq!(rows, [Verdict::Pass; 15], "{report}");
}

#[test]
fn mistakes_of_names_and_roles_are_found() {
    const NAMES: &str = "names are unique";
    const REFERENCES: &str = "each value reference is that of one variable";
    const ROLES: &str = "variability and initial go together";
    must_be_found(&[
        ("<Alias name=\"v\"", "<Alias name=\"f\"", NAMES),
        ("name=\"i16\"", "name=\"1i\"", NAMES),
        (
            "name=\"f\" valueReference=\"3\"",
            "name=\"f\" valueReference=\"2\"",
            REFERENCES,
        ),
        ("causality=\"independent\"", "causality=\"local\"", ROLES),
        ("<Float64 name=\"time\"", "<Int64 name=\"time\"", ROLES),
        (
            "<Float64 name=\"time\" valueReference=\"0\"",
            "<Float64 name=\"time\" valueReference=\"0\" start=\"0\"",
            ROLES,
        ),
        (
            "name=\"der(x)\" valueReference=\"16\"",
            "name=\"der(x)\" valueReference=\"16\" causality=\"independent\"",
            ROLES,
        ),
        (
            "causality=\"input\" start=\"1\"",
            "causality=\"input\"",
            ROLES,
        ),
        (
            "causality=\"input\" start=\"1\"",
            "causality=\"input\" initial=\"calculated\"",
            ROLES,
        ),
        (
            "causality=\"input\" start=\"1\"",
            "causality=\"input\" variability=\"fixed\" start=\"1\"",
            ROLES,
        ),
        (
            "variability=\"tunable\" start=\"3\"",
            "variability=\"discrete\" start=\"3\"",
            ROLES,
        ),
        (
            "<Int16 name=\"i16\"",
            "<Int16 variability=\"continuous\" name=\"i16\"",
            ROLES,
        ),
        (
            "<Int16 name=\"i16\"",
            "<Int16 start=\"4\" name=\"i16\"",
            ROLES,
        ),
        ("<Start value=\"a\"/><Start value=\"b\"/>", "", ROLES),
    ]);
}

#[test]
fn mistakes_of_values_and_arrays_are_found() {
    const NUMBERS: &str = "min ≤ start ≤ max";
    const TYPES: &str = "declared types exist";
    const UNITS: &str = "units and display units are defined";
    const ARRAYS: &str = "dimensions are fixed sizes";
    must_be_found(&[
        ("start=\"1 2 3\"", "start=\"1 2 10\"", NUMBERS),
        ("start=\"1 2\"", "start=\"1 3\"", NUMBERS),
        ("start=\"-3\"", "start=\"-4\"", NUMBERS),
        ("max=\"9\"", "max=\"9\" min=\"10\"", NUMBERS),
        ("declaredType=\"B\"", "declaredType=\"A\"", TYPES),
        ("declaredType=\"B\"", "declaredType=\"L\"", TYPES),
        ("unit=\"m\" max", "unit=\"km\" max", UNITS),
        (
            "declaredType=\"L\" displayUnit=\"mm\"",
            "declaredType=\"L\" displayUnit=\"cm\"",
            UNITS,
        ),
        ("nominal=\"10\"", "displayUnit=\"mm\"", UNITS),
        ("start=\"1 2 3\"", "start=\"1 2\"", ARRAYS),
        (
            "<Start value=\"b\"/>",
            "<Start value=\"b\"/><Start value=\"c\"/>",
            ARRAYS,
        ),
        (
            "variability=\"tunable\" start=\"3\"",
            "variability=\"tunable\" start=\"0\"",
            ARRAYS,
        ),
        (
            "<Dimension valueReference=\"1\"/>",
            "<Dimension valueReference=\"99\"/>",
            ARRAYS,
        ),
        (
            "<Dimension valueReference=\"1\"/>",
            "<Dimension valueReference=\"5\"/>",
            ARRAYS,
        ),
        (
            "<Dimension valueReference=\"1\"/>",
            "<Dimension valueReference=\"1\" start=\"3\"/>",
            ARRAYS,
        ),
        (
            "<Dimension start=\"2\"/>",
            "<Dimension start=\"0\"/>",
            ARRAYS,
        ),
        (
            "variability=\"tunable\" start=\"3\"/>",
            "variability=\"tunable\" start=\"3\"><Dimension start=\"1\"/></UInt64>",
            ARRAYS,
        ),
    ]);
}

#[test]
fn mistakes_of_clocks_are_found() {
    const CLOCKS: &str = "clocks have the interval";
    must_be_found(&[
        ("clocks=\"10\"", "clocks=\"12\"", CLOCKS),
        ("clocks=\"10\"", "clocks=\"99\"", CLOCKS),
        (
            "variability=\"discrete\" clocks=\"10\"",
            "clocks=\"10\"",
            CLOCKS,
        ),
        (
            "intervalVariability=\"fixed\" intervalDecimal=\"0.1\"",
            "intervalVariability=\"constant\"",
            CLOCKS,
        ),
        ("intervalDecimal=\"0.1\"", "intervalDecimal=\"0\"", CLOCKS),
        ("intervalDecimal=\"0.1\"", "intervalCounter=\"3\"", CLOCKS),
        (
            "intervalDecimal=\"0.1\"",
            "intervalDecimal=\"1\" shiftDecimal=\"-1\"",
            CLOCKS,
        ),
        (
            "causality=\"input\" intervalVariability=\"triggered\"",
            "causality=\"parameter\" intervalVariability=\"triggered\"",
            CLOCKS,
        ),
        ("previous=\"13\"", "previous=\"99\"", CLOCKS),
        ("previous=\"13\"", "previous=\"12\"", CLOCKS),
        ("previous=\"13\"", "previous=\"14\"", CLOCKS),
        ("clocks=\"10\" previous=\"13\"", "previous=\"13\"", CLOCKS),
    ]);
}

#[test]
fn mistakes_of_the_structure_are_found() {
    const OUTPUTS: &str = "Outputs lists every output";
    const INITIAL: &str = "InitialUnknowns lists exactly";
    const DEPENDENCIES: &str = "dependencies and derivatives name variables";
    const WHOLE: &str = "identity, default experiment";
    must_be_found(&[
        ("<Output valueReference=\"14\"/>", "", OUTPUTS),
        (
            "<Output valueReference=\"14\"/>",
            "<Output valueReference=\"13\"/>",
            OUTPUTS,
        ),
        (
            "<Output valueReference=\"14\"/>",
            "<Output valueReference=\"15\"/>",
            OUTPUTS,
        ),
        (
            "<InitialUnknown valueReference=\"14\" dependencies=\"2\"/>",
            "",
            INITIAL,
        ),
        ("<InitialUnknown valueReference=\"16\"/>", "", INITIAL),
        (
            "<InitialUnknown valueReference=\"16\"/>",
            "<InitialUnknown valueReference=\"15\"/>",
            INITIAL,
        ),
        (
            "dependencies=\"2 3\"",
            "dependencies=\"2 99\"",
            DEPENDENCIES,
        ),
        ("dependencies=\"2 3\"", "dependencies=\"2\"", DEPENDENCIES),
        (
            "\"dependent constant\"",
            "\"dependent always\"",
            DEPENDENCIES,
        ),
        (
            "<EventIndicator valueReference=\"16\"/>",
            "<EventIndicator valueReference=\"99\"/>",
            DEPENDENCIES,
        ),
        (" derivative=\"15\"", "", DEPENDENCIES),
        (" derivative=\"15\"", " derivative=\"99\"", DEPENDENCIES),
        (
            "instantiationToken=\"{1}\"",
            "instantiationToken=\"\"",
            WHOLE,
        ),
        (
            "modelIdentifier=\"R\" has",
            "modelIdentifier=\"1-R\" has",
            WHOLE,
        ),
        (
            "<Category name=\"l\"/>",
            "<Category name=\"l\"/><Category name=\"l\"/>",
            WHOLE,
        ),
    ]);
}

#[test]
fn mistakes_of_terminals_are_found() {
    let schema = "terminalsAndIcons.xml, if there is one";
    let members = "terminals and their members";
    let changes = [
        (" matchingRule=\"bus\"", "", schema),
        ("</Terminals>", "", schema),
        ("variableName=\"v\"", "variableName=\"w\"", members),
        ("variableName=\"f\"", "variableName=\"g\"", members),
        ("memberName=\"force\"", "memberName=\"length\"", members),
        ("memberName=\"force\"", "", members),
        ("name=\"bus\"", "name=\"rod\"", members),
        ("iconBaseName=\"rod\"", "iconBaseName=\"rope\"", members),
    ];
    crate::faulty::must_be_found(TERMINALS, &changes, |changed, promise| {
        checked(DESCRIPTION, changed, promise)
    });
}
