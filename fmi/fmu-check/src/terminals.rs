//! Checks `terminalsAndIcons.xml` of FMI 3.0 (section 2.4.9), for `fmu_check::check`.

use std::collections::BTreeSet;

use fmi_description::xml::Element;

use super::outcome::{Outcome, Promise, Report};
use super::schema;
use super::variables::Variable;
use fmi_description::Entries;

const AREA: &str = "terminals";
const FILE: &str = "terminalsAndIcons/terminalsAndIcons.xml";
const SCHEMA: Promise = Promise {
    text: "terminalsAndIcons.xml, if there is one, is UTF-8, well-formed, and valid by its schema",
    why: "importers ignore the file, or refuse the whole FMU [FMI 3.0, 2.4.9]",
};
const MEMBERS: Promise = Promise {
    text: "terminals and their members have names of their own; members are variables that are there; icons are files",
    why: "importers connect all members of two terminals at once, by name [FMI 3.0, 2.4.9.2]",
};

/// Checks the terminals, if there are any.
pub fn check(entries: &Entries, variables: &[Variable], report: &mut Report) {
    let Some(bytes) = entries.get(FILE) else {
        return;
    };
    let text = std::str::from_utf8(bytes).map_err(|e| e.to_string());
    let parsed = text.and_then(|text| {
        let text = text.trim_start_matches('\u{feff}');
        let document = uppsala::parse(text).map_err(|e| e.to_string())?;
        let root = Element::parse(text, FILE, "fmiTerminalsAndIcons").map_err(|e| e.to_string())?;
        Ok((document, root))
    });
    let (document, root) = match parsed {
        Ok(parsed) => parsed,
        Err(reason) => return report.push(AREA, SCHEMA, Outcome::failed(reason)),
    };
    report.push(AREA, SCHEMA, schema::terminals(&document));
    let Some(list) = root.child("Terminals") else {
        return;
    };
    let mut outcome = Outcome::default();
    let known: BTreeSet<_> = variables.iter().flat_map(Variable::names).collect();
    terminals(list, entries, &known, &mut outcome);
    report.push(AREA, MEMBERS, outcome);
}

/// Checks the terminals in an element, and those nested in them.
fn terminals(list: &Element, entries: &Entries, known: &BTreeSet<&str>, outcome: &mut Outcome) {
    let mut names = BTreeSet::new();
    for terminal in list.all("Terminal") {
        let name = terminal.get("name").unwrap_or("");
        if !names.insert(name) {
            outcome.fail(format!("terminal `{name}` is there twice"));
        }
        let variables = [
            ("TerminalMemberVariable", "variableName"),
            ("TerminalStreamMemberVariable", "inStreamVariableName"),
            ("TerminalStreamMemberVariable", "outStreamVariableName"),
        ];
        for (tag, attribute) in variables {
            let named = terminal.all(tag).filter_map(|m| m.get(attribute));
            for variable in named.filter(|v| !known.contains(v)) {
                outcome.fail(format!(
                    "terminal `{name}`: there is no variable `{variable}`"
                ));
            }
        }
        let mut members = BTreeSet::new();
        let is_by_name = matches!(terminal.get("matchingRule"), Some("plug" | "bus"));
        for member in terminal.all("TerminalMemberVariable") {
            match member.get("memberName") {
                Some(member) if !members.insert(member) => {
                    outcome.fail(format!(
                        "terminal `{name}`: member `{member}` is there twice"
                    ));
                }
                None if is_by_name => outcome.fail(format!(
                    "terminal `{name}`: `{}` must have a memberName, by which it is connected",
                    member.get("variableName").unwrap_or("")
                )),
                _ => {}
            }
        }
        let picture = terminal.child("TerminalGraphicalRepresentation");
        if let Some(icon) = picture.and_then(|p| p.get("iconBaseName")) {
            let file = format!("terminalsAndIcons/{icon}.png");
            if !entries.contains_key(&file) {
                outcome.fail(format!("terminal `{name}`: there is no {file}"));
            }
        }
        terminals(terminal, entries, known, outcome);
    }
}
