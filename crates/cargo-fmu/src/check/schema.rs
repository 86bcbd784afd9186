//! The model description against the schema files of the standard, which lie in `schema/` as they are published.

use uppsala::{Document, XsdValidator};

use super::outcome::Outcome;

macro_rules! files {
    ($folder:literal: $($name:literal),*) => {
        [$(include_str!(concat!("../../schema/", $folder, "/", $name, ".xsd"))),*]
    };
}

const FMI2: [&str; 7] = files!["fmi2": "fmi2Annotation", "fmi2AttributeGroups", "fmi2ModelDescription", "fmi2ScalarVariable",
    "fmi2Type", "fmi2Unit", "fmi2VariableDependency"];
/// What the schema of a version of FMI says about a model description.
pub fn description(version: &str, document: &Document) -> Outcome {
    match version {
        "2.0" => validate(&FMI2, document),
        version => Outcome::not_checked(format!(
            "the schema of FMI {version} is not at hand; that of 2.0 is"
        )),
    }
}

fn validate(files: &[&str], document: &Document) -> Outcome {
    let schema = merged(files);
    let schema = uppsala::parse(&schema).expect("the schema files are well-formed");
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

/// The files as one: what each holds inside its `xs:schema`, without the includes of each other.
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

    fn fails(version: &str, text: &str) -> Vec<String> {
        description(version, &uppsala::parse(text).unwrap()).fails
    }

    #[test]
    fn the_schema_of_fmi_2_is_kept() {
        assert_eq!(fails("2.0", SMALL), [""; 0]);
        for (was, is) in [
            ("causality=\"input\"", "causality=\"inputs\""),
            ("<ModelStructure/>", ""),
            ("valueReference=\"0\"", "valueReference=\"-1\""),
            ("<Real start=\"1\"/>", "<Real begin=\"1\"/>"),
            ("<CoSimulation modelIdentifier=\"Lag\"/>", "<Foo/>"),
        ] {
            assert_ne!(fails("2.0", &SMALL.replace(was, is)), [""; 0], "{is}");
        }
    }

    #[test]
    fn other_versions_are_not_checked() {
        let outcome = description("3.0", &uppsala::parse(SMALL).unwrap());
        assert!(
            outcome
                .not_checked
                .unwrap()
                .starts_with("the schema of FMI 3.0")
        );
    }
}
