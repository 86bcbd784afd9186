//! `terminalsAndIcons.xml`: groups of variables that are wired together (FMI 3.0.2, section 2.4.9).

use crate::Model;
use crate::border::description::{Xml, empty, text as text_of};
use crate::core::info::Terminal;
use crate::core::layout::Layout;
use std::collections::BTreeSet;
use std::io;

/// The first thing that is wrong with the model's terminals.
pub(crate) fn check<M: Model>(layout: &Layout<M>) -> Result<(), String> {
    let mut names = BTreeSet::new();
    for terminal in M::INFO.terminals {
        let name = terminal.name;
        if name.is_empty() || !names.insert(name) {
            return Err(format!("terminal `{name}` must have a name of its own"));
        }
        let mut members = BTreeSet::new();
        for (member, variable) in terminal.members {
            if !members.insert(*member) {
                return Err(format!("terminal `{name}` has the member `{member}` twice"));
            }
            let is_known = layout.blocks().any(|number| {
                let (run, first, _) = layout.block(number).expect("of the layout");
                match run.is_array() {
                    true => run.row.name == *variable,
                    false => run.row.element_name(first) == *variable,
                }
            });
            if !is_known {
                return Err(format!(
                    "terminal `{name}`, member `{member}`: `{variable}` must be a variable of the table"
                ));
            }
        }
    }
    Ok(())
}

/// The text of the file; None without terminals.
pub(crate) fn text<M: Model>() -> Result<Option<String>, String> {
    if M::INFO.terminals.is_empty() {
        return Ok(None);
    }
    let text = text_of(|xml| {
        xml.create_element("fmiTerminalsAndIcons")
            .with_attribute(("fmiVersion", "3.0"))
            .write_inner_content(|xml| {
                xml.create_element("Terminals").write_inner_content(|xml| {
                    M::INFO.terminals.iter().try_for_each(|t| write(xml, t))
                })?;
                Ok(())
            })?;
        Ok(())
    })?;
    Ok(Some(text + "\n"))
}

fn write(xml: &mut Xml, terminal: &Terminal) -> io::Result<()> {
    let attributes = [
        ("name", terminal.name),
        ("matchingRule", terminal.matching_rule),
        ("terminalKind", terminal.kind),
        ("description", terminal.description),
    ];
    xml.create_element("Terminal")
        .with_attributes(attributes)
        .write_inner_content(|xml| {
            for (member, variable) in terminal.members {
                let attributes = [
                    ("variableName", (*variable).to_owned()),
                    ("memberName", (*member).to_owned()),
                    ("variableKind", "signal".to_owned()),
                ];
                empty(xml, "TerminalMemberVariable", &attributes)?;
            }
            Ok(())
        })?;
    Ok(())
}
