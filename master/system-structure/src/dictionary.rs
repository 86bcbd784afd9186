//! Signal dictionaries (`.ssb`), for `cosim`: signals that connections in several systems share.

use fmi_description::Unit;
use fmi_description::xml::{Element, XmlError};

use crate::connector::{Connector, DataType, Units};

/// The signals of a dictionary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalDictionary {
    /// Name, type and unit of each signal.
    pub entries: Vec<(String, DataType, Option<Unit>)>,
}

impl SignalDictionary {
    /// Read the text of a `.ssb`; `file` is its name for messages.
    pub fn parse(text: &str, file: &str) -> Result<Self, XmlError> {
        Self::read(&Element::parse(text, file, "SignalDictionary")?)
    }

    pub(crate) fn read(node: &Element) -> Result<Self, XmlError> {
        let units = Units::read(node)?;
        let all = node.all("DictionaryEntry");
        let entries = all.map(|entry| {
            let name = entry.required("name")?;
            let Some((data_type, declared)) = DataType::declared(entry) else {
                return Err(
                    entry.error(format!("the entry `{name}` of the dictionary has no type"))
                );
            };
            Ok((name, data_type, units.of(declared)))
        });
        Ok(Self {
            entries: entries.collect::<Result<_, _>>()?,
        })
    }
}

/// An element of a system to which connections to the signals of a dictionary attach.
#[derive(Clone, Debug, PartialEq)]
pub struct DictionaryReference {
    /// Name of the element.
    pub name: String,
    /// Name of the dictionary, which this system or an enclosing one has.
    pub dictionary: String,
    /// The signals that are connected here.
    pub connectors: Vec<Connector>,
}
