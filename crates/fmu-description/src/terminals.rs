//! `terminalsAndIcons.xml` of FMI 3.0 (section 2.4.9): which variables belong together at a connection.

use serde::Deserialize;

use crate::DescriptionError;

/// A terminal.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Terminal {
    /// Name.
    #[serde(rename = "@name")]
    pub name: String,
    /// What is connected here, a reverse domain name; None where nothing is said.
    #[serde(rename = "@terminalKind")]
    pub kind: Option<String>,
    /// `plug`, `bus`, `sequence`, ….
    #[serde(rename = "@matchingRule")]
    pub matching_rule: String,
    /// Variables of it.
    #[serde(rename = "TerminalMemberVariable", default)]
    pub members: Vec<Member>,
    /// Terminals in it.
    #[serde(rename = "Terminal", default)]
    pub terminals: Vec<Terminal>,
}

/// A variable of a terminal.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Member {
    /// Name of the variable in the model description.
    #[serde(rename = "@variableName")]
    pub variable: String,
    /// Name by which terminals match.
    #[serde(rename = "@memberName")]
    pub name: Option<String>,
    /// `signal`, `inflow`, `outflow`, ….
    #[serde(rename = "@variableKind")]
    pub kind: String,
}

#[derive(Deserialize)]
struct File {
    #[serde(rename = "Terminals", default)]
    terminals: List,
}

#[derive(Default, Deserialize)]
struct List {
    #[serde(rename = "Terminal", default)]
    terminals: Vec<Terminal>,
}

/// The terminals of a `terminalsAndIcons.xml`.
pub fn terminals(text: &str) -> Result<Vec<Terminal>, DescriptionError> {
    let file: File = quick_xml::de::from_str(text)?;
    Ok(file.terminals.terminals)
}
