//! Groups of variables as files `OspModelDescription.xml` define them, for connections of groups.

use std::collections::HashMap;

use fmi_description::Unit;
use fmi_description::xml::{Element, XmlError};

/// A group: variables and further groups.
pub(super) struct Group {
    pub name: String,
    /// Names of variables, and their units where the file defines them.
    pub variables: Vec<(String, Option<Unit>)>,
    pub groups: Vec<Group>,
}

/// The groups of the text of the file `file`.
pub(super) fn read(text: &str, file: &str) -> Result<Vec<Group>, XmlError> {
    let root = Element::parse(text, file, "OspModelDescription")?;
    let units = root.listed("UnitDefinitions", "Unit").map(Unit::read);
    let units = units.map(|unit| unit.map(|unit| (unit.name.clone(), unit)));
    let units = units.collect::<Result<HashMap<_, _>, _>>()?;
    let groups = root.all_in("VariableGroups");
    groups.map(|group| read_group(group, &units)).collect()
}

fn read_group(node: &Element, units: &HashMap<String, Unit>) -> Result<Group, XmlError> {
    let name = node.required("name")?;
    let (mut variables, mut groups) = (Vec::new(), Vec::new());
    for child in &node.children {
        if child.tag != "Variable" {
            groups.push(read_group(child, units)?);
            continue;
        }
        let unit = Unit::name_in(child, "unit").and_then(|name| units.get(name));
        variables.push((child.required("ref")?, unit.cloned()));
    }
    Ok(Group {
        name,
        variables,
        groups,
    })
}

impl Group {
    /// The group with this name among `groups` or in them, the outermost first.
    pub fn find<'g>(groups: &'g [Self], name: &str) -> Option<&'g Self> {
        let own = groups.iter().find(|group| group.name == name);
        own.or_else(|| groups.iter().find_map(|g| Self::find(&g.groups, name)))
    }

    /// Names of all groups, for messages.
    pub fn names(groups: &[Self]) -> Vec<&str> {
        let all = groups.iter();
        all.flat_map(|group| [vec![group.name.as_str()], Self::names(&group.groups)].concat())
            .collect()
    }

    /// All variables: those of the groups in it, then its own.
    pub fn all(&self) -> Vec<&(String, Option<Unit>)> {
        let inner = self.groups.iter().flat_map(Self::all);
        inner.chain(&self.variables).collect()
    }

    /// Whether another group has groups and variables of the same number, at every depth.
    pub fn is_like(&self, other: &Self) -> bool {
        self.variables.len() == other.variables.len()
            && self.groups.len() == other.groups.len()
            && self
                .groups
                .iter()
                .zip(&other.groups)
                .all(|(a, b)| a.is_like(b))
    }
}
