//! Signal dictionaries (`.ssb`): signals by name that connections of several systems share.

use crate::common::{DataType, Unit};
use crate::connector::Connector;
use crate::error::StructureError;
use crate::xml::Node;

/// The signals of a dictionary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalDictionary {
    /// Names and types.
    pub entries: Vec<(String, DataType, Option<Unit>)>,
}

impl SignalDictionary {
    /// Read the text of a `.ssb`; `file` is its name for messages.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub fn parse(text: &str, file: &str) -> Result<Self, StructureError> {
        Self::read(&Node::parse(text, file, "SignalDictionary")?)
    }

    pub(crate) fn read(node: &Node) -> Result<Self, StructureError> {
        let units = Unit::read_all(node)?;
        let all = node.children.iter().filter(|c| c.name == "DictionaryEntry");
        let entries = all.map(|entry| {
            let name = entry.required("name")?;
            let Some((data_type, declared)) = DataType::declared(entry) else {
                return Err(
                    entry.error(format!("the entry `{name}` of the dictionary has no type"))
                );
            };
            let unit = declared
                .attribute("unit")
                .map(|name| Unit::of(&units, name));
            Ok((name.to_string(), data_type, unit))
        });
        Ok(Self {
            entries: entries.collect::<Result<_, _>>()?,
        })
    }
}

/// A place in a system where the signals of a dictionary can be connected.
#[derive(Clone, Debug, PartialEq)]
pub struct DictionaryReference {
    /// Name of the element.
    pub name: String,
    /// Name of the dictionary, of this system or of one around it.
    pub dictionary: String,
    /// Its signals that are connected here.
    pub connectors: Vec<Connector>,
}
