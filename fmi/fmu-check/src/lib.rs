//! Checks whether an FMU of any tool does what importers rely on (archive, model description,
//! libraries, behaviour when called), for `fmu-check` and `cargo fmu check`. What breaks the standard
//! is a failure; what no standard asks for, but importers have trouble with, is not robust.
#![cfg_attr(doctest, doc = include_str!("../README.md"))]
#![forbid(unsafe_code)]

mod archive;
mod arguments;
mod binaries;
#[cfg(feature = "wasm")]
pub mod component;
mod functions;
mod options;
mod outcome;
mod run;
mod schema;
mod structure;
mod terminals;
mod variables;
#[cfg(feature = "wasm")]
mod wasm;

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use fmi_description::xml::Element;
use fmi_description::{Description, Version, library_among};
use output_file::TemporaryFolder;

pub use arguments::Arguments;
use fmi_description::Entries;
use fmi_import::platform;
pub use options::CheckOptions;
pub use outcome::{Outcome, Promise, Report, Row, Verdict};

const DESCRIPTION: &str = "model description";

const SCHEMA: Promise = Promise {
    text: "modelDescription.xml is UTF-8, well-formed, and valid by the schema of its version",
    why: "importers refuse the whole FMU [FMI 2.0, 2.2; FMI 3.0, 2.4]",
};
const BEYOND: Promise = Promise {
    text: "what is asked beyond the schema",
    why: "",
};
const RUNS: Promise = Promise {
    text: "what it does when it is run",
    why: "",
};

/// Checks an FMU.
///
/// # Errors
/// The file cannot be read, or no process can be started. What is wrong with the FMU is in the
/// report.
pub fn check(path: &Path, options: CheckOptions) -> Result<Report> {
    let bytes = fs::read(path).with_context(|| path.display().to_string())?;
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let mut report = Report {
        title: format!("{file} ({} kB)", bytes.len() / 1000),
        ..Report::default()
    };
    if let Some(entries) = archive::check(bytes, &mut report) {
        check_files(&entries, options, &mut report)?;
    }
    let is_wanted = |row: &Row| row.promise.text.contains(options.only);
    let is_end = |row: &&Row| matches!(row.outcome.verdict(), Verdict::Fails | Verdict::NotChecked);
    let end = report.rows.last().filter(is_end).cloned();
    report.rows.retain(is_wanted);
    if report.rows.is_empty() {
        report.rows.extend(end); // why nothing of what is wanted was checked
    }
    Ok(report)
}

fn check_files(entries: &Entries, options: CheckOptions, report: &mut Report) -> Result<()> {
    let Some(text) = entries.get("modelDescription.xml") else {
        return Ok(());
    };
    let mut schema = Outcome::default();
    if let Err(reason) = std::str::from_utf8(text) {
        schema.fail(reason.to_string());
    }
    match fmi_description::text(text) {
        Ok(text) => check_description(&text, entries, options, schema, report),
        Err(reason) => {
            schema.fail(reason.to_string());
            report.push(DESCRIPTION, SCHEMA, schema);
            Ok(())
        }
    }
}

/// Checks the text of the description, and all that needs it. `schema` has what is wrong with its
/// bytes; a description in another encoding than UTF-8 is checked nevertheless.
fn check_description(
    text: &str,
    entries: &Entries,
    options: CheckOptions,
    mut schema: Outcome,
    report: &mut Report,
) -> Result<()> {
    let text = text.trim_start_matches('\u{feff}');
    // First by the reader that all importers here use, which has limits.
    let root = Element::parse(text, "modelDescription.xml", "fmiModelDescription");
    let parsed = root.map_err(|e| e.to_string()).and_then(|root| {
        let document = uppsala::parse(text).map_err(|e| e.to_string())?;
        Ok((document, root))
    });
    let (document, root) = match &parsed {
        Ok((document, root)) => (document, root),
        Err(reason) => {
            schema.fail(reason.clone());
            report.push(DESCRIPTION, SCHEMA, schema);
            return Ok(());
        }
    };
    let version = root.get("fmiVersion").unwrap_or("");
    report.title += &title(root);
    let Outcome { fails, .. } = schema;
    let known = known_version(version);
    schema = schema::description(known, version, document);
    schema.fails.splice(..0, fails);
    // What importers here cannot read is wrong, whatever the schema says.
    let parsed = Description::parse_any(text);
    match &parsed {
        Err(e) if known.is_some() && schema.fails.is_empty() => schema.fail(e.to_string()),
        _ => {}
    }
    report.push(DESCRIPTION, SCHEMA, schema);
    if let Some(version) = known {
        let variables = variables::Variable::all(root, version);
        structure::check(root, &variables, version, report);
        variables::check(root, &variables, version, report);
        if version == Version::Fmi3 {
            terminals::check(entries, &variables, report);
        }
    } else {
        let reason =
            format!("this program knows the rules of FMI 2.0 and 3.0, not those of {version}");
        report.push(DESCRIPTION, BEYOND, Outcome::not_checked(reason));
    }
    binaries::check(
        entries,
        &structure::identifiers(root),
        |identifier| known.map(|version| functions::required(root, version, identifier)),
        report,
    );
    #[cfg(feature = "wasm")]
    if root.child("CoSimulation").is_some() {
        wasm::check(entries, &structure::identifiers(root), report);
    }
    match parsed.map_err(|e| e.to_string()).and_then(|description| {
        has_library(&description, entries)?;
        Ok(description)
    }) {
        Ok(description) => {
            let identifier = |interface| root.child(interface)?.get("modelIdentifier");
            let runs = |interface| identifier(interface) == Some(&description.identifier);
            let interfaces = ["CoSimulation", "ModelExchange"].map(runs);
            run_probes(entries, options, (description.fmi, interfaces), report)?;
        }
        Err(reason) => report.push("simulation", RUNS, Outcome::not_checked(reason)),
    }
    Ok(())
}

fn title(root: &Element) -> String {
    let get = |attribute| root.get(attribute).unwrap_or("");
    let interfaces = [
        ("CoSimulation", "co-simulation"),
        ("ModelExchange", "model exchange"),
        ("ScheduledExecution", "scheduled execution"),
    ];
    let offered = interfaces
        .iter()
        .filter(|(tag, _)| root.child(tag).is_some());
    let offered: Vec<_> = offered.map(|(_, name)| *name).collect();
    let tool = root
        .get("generationTool")
        .map_or(String::new(), |tool| format!(", made by {tool}"));
    format!(
        ": FMI {}, {}, `{}` {}{tool}",
        get("fmiVersion"),
        offered.join(" and "),
        get("modelName"),
        get("version")
    )
}

/// The version of FMI that a description names, if this program knows its rules.
fn known_version(version: &str) -> Option<Version> {
    match version {
        "2.0" => Some(Version::Fmi2),
        version if version.starts_with("3.") => Some(Version::Fmi3),
        _ => None,
    }
}

/// Why an FMU cannot be run on this machine, if it cannot.
fn has_library(description: &Description, entries: &Entries) -> Result<(), String> {
    if description.interfaces == ["Scheduled Execution"] {
        return Err("this program does not run Scheduled Execution".into());
    }
    let platform = platform::host().map_err(|e| e.to_string())?;
    let names = entries.keys().map(String::as_str);
    let found = library_among(names, description, platform);
    found.map(drop).map_err(|e| e.to_string())
}

/// `kind` is the version, and whether there are Co-Simulation and Model Exchange.
fn run_probes(
    entries: &Entries,
    options: CheckOptions,
    kind: (Version, [bool; 2]),
    report: &mut Report,
) -> Result<()> {
    let scratch = TemporaryFolder::new()?;
    let [plain, odd] = ["fmu", "an ü in it"].map(|name| scratch.path().join(name));
    for folder in [&plain, &odd] {
        unpack(entries, folder)?;
    }
    run::all(options, kind, [&plain, &odd], scratch.path(), report)
}

fn unpack(entries: &Entries, folder: &Path) -> Result<()> {
    for (name, bytes) in entries {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).with_context(|| parent.display().to_string())?;
        }
        fs::write(&path, bytes).with_context(|| path.display().to_string())?;
    }
    // Importers make this folder even if the archive has none.
    let resources = folder.join("resources");
    fs::create_dir_all(&resources).with_context(|| resources.display().to_string())
}
