//! `terminalsAndIcons.xml` of FMI 3.0 (section 2.4.9): which variables belong together at a
//! connection.

use crate::error::DescriptionError;
use crate::xml::{Element, XmlError};

/// A terminal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Terminal {
    /// Name.
    pub name: String,
    /// What is connected here, a reverse domain name; None where nothing is said.
    pub kind: Option<String>,
    /// `plug`, `bus`, `sequence`, ….
    pub matching_rule: String,
    /// Variables of it.
    pub members: Vec<Member>,
    /// Terminals in it.
    pub terminals: Vec<Terminal>,
}

/// A variable of a terminal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Name of the variable in the model description.
    pub variable: String,
    /// Name by which terminals match.
    pub name: Option<String>,
    /// `signal`, `inflow`, `outflow`, ….
    pub kind: String,
}

/// The terminals of a `terminalsAndIcons.xml`.
pub fn terminals(text: &str) -> Result<Vec<Terminal>, DescriptionError> {
    let root = Element::parse(text, "terminalsAndIcons.xml", "fmiTerminalsAndIcons")?;
    let terminals = root.listed("Terminals", "Terminal").map(terminal);
    Ok(terminals.collect::<Result<_, _>>()?)
}

fn terminal(element: &Element) -> Result<Terminal, XmlError> {
    let text = |element: &Element, name| element.get(name).map(str::to_string);
    let members = element.all("TerminalMemberVariable").map(|member| {
        Ok(Member {
            variable: member.required("variableName")?,
            name: text(member, "memberName"),
            kind: member.required("variableKind")?,
        })
    });
    Ok(Terminal {
        name: element.required("name")?,
        kind: text(element, "terminalKind"),
        matching_rule: element.required("matchingRule")?,
        members: members.collect::<Result<_, XmlError>>()?,
        terminals: element
            .all("Terminal")
            .map(terminal)
            .collect::<Result<_, _>>()?,
    })
}
