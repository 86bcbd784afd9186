//! Signal dictionaries (`.ssb`): signals by name that connections of several systems share.

use fmi_description::Unit;
use fmi_description::xml::{Element, XmlError};

use crate::common::{DataType, units};
use crate::connector::Connector;

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
    pub fn parse(text: &str, file: &str) -> Result<Self, XmlError> {
        Self::read(&Element::parse(text, file, "SignalDictionary")?)
    }

    pub(crate) fn read(node: &Element) -> Result<Self, XmlError> {
        let units = units(node)?;
        let all = node.all("DictionaryEntry");
        let entries = all.map(|entry| {
            let name = entry.required("name")?;
            let Some((data_type, declared)) = DataType::declared(entry) else {
                return Err(
                    entry.error(format!("the entry `{name}` of the dictionary has no type"))
                );
            };
            let unit = declared
                .get("unit")
                .map(|name| Unit::find_or_named(&units, name));
            Ok((name, data_type, unit))
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
