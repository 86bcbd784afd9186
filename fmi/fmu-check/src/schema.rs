//! Validates model descriptions and (for `terminals`) `terminalsAndIcons.xml` by the schema files
//! of the standard, which are in `schema/` as they were published; `fmu_check::check` reports it.

mod rewriting;

use fmi_description::Version;
use uppsala::{Document, XsdValidator};

use super::outcome::Outcome;

macro_rules! files {
    ($folder:literal: $($name:literal),*) => {
        [$(include_str!(concat!("../schema/", $folder, "/", $name, ".xsd"))),*]
    };
}

const FMI2: [&str; 7] = files!["fmi2": "fmi2Annotation", "fmi2AttributeGroups", "fmi2ModelDescription", "fmi2ScalarVariable",
    "fmi2Type", "fmi2Unit", "fmi2VariableDependency"];
const FMI3: [&str; 8] = files!["fmi3": "fmi3Annotation", "fmi3AttributeGroups", "fmi3InterfaceType", "fmi3ModelDescription",
    "fmi3Type", "fmi3Unit", "fmi3Variable", "fmi3VariableDependency"];
const TERMINALS: [&str; 3] =
    files!["fmi3": "fmi3Annotation", "fmi3Terminal", "fmi3TerminalsAndIcons"];

/// Validates a model description by the schema of its version, which it `names`.
pub fn description(version: Option<Version>, names: &str, document: &Document) -> Outcome {
    match version {
        Some(Version::Fmi2) => validate(&FMI2, document),
        Some(Version::Fmi3) => validate(&FMI3, document),
        None => Outcome::not_checked(format!(
            "the schema of FMI {names} is not at hand; those of 2.0 and 3.0 are"
        )),
    }
}

/// Validates `terminalsAndIcons.xml` by the schema of FMI 3.0.
pub fn terminals(document: &Document) -> Outcome {
    validate(&TERMINALS, document)
}

fn validate(files: &[&str], document: &Document) -> Outcome {
    let schema = merged(files);
    let mut schema = uppsala::parse(&schema).expect("the schema files are well-formed");
    rewriting::rewrite(&mut schema);
    let validator = XsdValidator::from_schema(&schema).expect("the schema files are a schema");
    let errors = validator.validate(document);
    let fails = errors.iter().map(|e| match e.line {
        Some(line) => format!("line {line}: {}", e.message),
        None => e.message.clone(),
    });
    Outcome {
        fails: fails.collect(),
        ..Outcome::default()
    }
}

/// The schema files in one: the content of each `xs:schema`, without includes.
fn merged(files: &[&str]) -> String {
    let bodies = files.iter().filter_map(|file| {
        let (_, opened) = file.split_once("<xs:schema")?;
        let (_, body) = opened.split_once('>')?;
        Some(body.rsplit_once("</xs:schema>")?.0)
    });
    let lines = bodies.flat_map(str::lines);
    let lines: Vec<_> = lines.filter(|line| !line.contains("<xs:include")).collect();
    format!(
        "<xs:schema xmlns:xs=\"http://www.w3.org/2001/XMLSchema\" elementFormDefault=\"qualified\" \
         attributeFormDefault=\"unqualified\">{}</xs:schema>",
        lines.join("\n")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{1}">
  <CoSimulation modelIdentifier="Lag"/>
  <ModelVariables><ScalarVariable name="u" valueReference="0" causality="input"><Real start="1"/></ScalarVariable></ModelVariables>
  <ModelStructure/>
</fmiModelDescription>"#;

    fn fails(version: Version, text: &str) -> Vec<String> {
        description(Some(version), "", &uppsala::parse(text).unwrap()).fails
    }

    #[test]
    fn the_schema_of_fmi_2_is_kept() {
        assert_eq!(fails(Version::Fmi2, SMALL), [""; 0]);
        for (was, is) in [
            ("causality=\"input\"", "causality=\"inputs\""),
            ("<ModelStructure/>", ""),
            ("valueReference=\"0\"", "valueReference=\"-1\""),
            ("<Real start=\"1\"/>", "<Real begin=\"1\"/>"),
            ("<CoSimulation modelIdentifier=\"Lag\"/>", "<Foo/>"),
        ] {
            assert_ne!(
                fails(Version::Fmi2, &SMALL.replace(was, is)),
                [""; 0],
                "{is}"
            );
        }
    }

    /// A description with a construct of each kind of the schema: array, alias, texts, items,
    /// clock, annotations.
    const RICH: &str = include_str!("../tests/check/rich3.xml");

    #[test]
    fn the_schema_of_fmi_3_is_kept() {
        assert_eq!(fails(Version::Fmi3, RICH), [""; 0]);
        for (was, is) in [
            ("<Dimension start=\"2\"/>", "<Dimension start=\"-2\"/>"),
            ("<Dimension valueReference=\"1\"/>", "<Dimensions/>"),
            ("<Alias name=\"v\"", "<Alias"),
            ("<Start value=\"b\"/>", "<Start text=\"b\"/>"),
            ("<Item name=\"b\" value=\"2\"/>", "<Item name=\"b\"/>"),
            (" declaredType=\"E\"", ""),
            ("start=\"true false\"", "start=\"true 2\""),
            (
                "intervalVariability=\"triggered\"",
                "intervalVariability=\"never\"",
            ),
            ("<Output ", "<Outputs "),
            ("<Int8 ", "<Int7 "),
            ("instantiationToken=\"{1}\"", ""),
            ("hasEventMode=\"true\"", "hasEventMode=\"yes\""),
        ] {
            assert_ne!(
                fails(Version::Fmi3, &RICH.replacen(was, is, 1)),
                [""; 0],
                "{is}"
            );
        }
    }

    #[test]
    fn the_schema_of_terminals_is_kept() {
        const TEXT: &str = r#"<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals>
  <Terminal name="a" matchingRule="plug"><TerminalMemberVariable variableName="x" memberName="x" variableKind="signal"/></Terminal>
  <Terminal name="b" matchingRule="bus"/>
</Terminals></fmiTerminalsAndIcons>"#;
        let fails = |text: &str| terminals(&uppsala::parse(text).unwrap()).fails;
        assert_eq!(fails(TEXT), [""; 0]);
        for (was, is) in [
            (" matchingRule=\"bus\"", ""),
            ("TerminalMemberVariable", "Member"),
            ("fmiVersion=\"3.0\"", "fmiVersion=\"2.0\""),
        ] {
            assert_ne!(fails(&TEXT.replace(was, is)), [""; 0], "{is}");
        }
    }

    #[test]
    fn other_versions_are_not_checked() {
        let outcome = description(None, "1.0", &uppsala::parse(SMALL).unwrap());
        let reason = outcome.not_checked.unwrap();
        assert!(reason.starts_with("the schema of FMI 1.0"), "{reason}");
    }
}
