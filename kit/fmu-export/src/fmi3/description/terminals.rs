//! Checks a model's terminals (groups of variables to connect together) for `description`, and
//! writes `terminalsAndIcons.xml` (FMI 3.0.2, section 2.4.9).

use crate::Model;
use crate::c_api::description::Element;
use crate::core::layout::{Block, Layout};
use std::collections::BTreeSet;

/// The first mistake in the model's terminals.
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
            let is_it = |(_, (span, first, _)): (u32, Block<M>)| match span.is_array() {
                true => span.row.name == *variable,
                false => span.row.element_name(first) == *variable,
            };
            if !layout.blocks().any(is_it) {
                return Err(format!(
                    "terminal `{name}`, member `{member}`: `{variable}` must be a variable of the table"
                ));
            }
        }
    }
    Ok(())
}

/// The text of the file; None if the model has no terminals.
pub(crate) fn text<M: Model>() -> Result<Option<String>, String> {
    let member = |member: &str, variable: &str| {
        Element::new("TerminalMemberVariable").with([
            ("variableName", variable),
            ("memberName", member),
            ("variableKind", "signal"),
        ])
    };
    let terminals = M::INFO.terminals.iter().map(|terminal| {
        let members = terminal.members.iter().map(|(name, of)| member(name, of));
        #[cfg(feature = "can")]
        let members = members.chain(super::can::members::<M>(terminal, member));
        let attributes = [
            ("name", terminal.name),
            ("matchingRule", terminal.matching_rule),
            ("terminalKind", terminal.kind),
            ("description", terminal.description),
        ];
        Element::new("Terminal").with(attributes).holding(members)
    });
    let Some(terminals) = Element::new("Terminals").holding(terminals).if_any() else {
        return Ok(None);
    };
    let root = Element::new("fmiTerminalsAndIcons").with([("fmiVersion", "3.0")]);
    root.holding([terminals]).file().map(Some)
}
