//! Parameter sets (`.ssv`), and the bindings by which a structure applies them to a component or a
//! system. `cosim` takes start values from both.

use fmi_description::Unit;
use fmi_description::xml::{Element, XmlError};

use crate::connector::{DataType, Units};
use crate::mapping::ParameterMapping;

/// The value of a parameter, or the start value of another variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, relative to the element that the set is bound to.
    pub name: String,
    /// Type of the value.
    pub data_type: DataType,
    /// Value.
    pub value: String,
    /// Unit of a real value.
    pub unit: Option<Unit>,
}

/// A parameter set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterSet {
    /// Parameters, in the order of the file.
    pub parameters: Vec<Parameter>,
}

impl ParameterSet {
    /// Read the text of a `.ssv`; `file` is its name for messages.
    pub fn parse(text: &str, file: &str) -> Result<Self, XmlError> {
        Self::read(&Element::parse(text, file, "ParameterSet")?)
    }

    fn read(node: &Element) -> Result<Self, XmlError> {
        let units = Units::read(node)?;
        let all = node.listed("Parameters", "Parameter");
        let parameters = all.map(|p| {
            let name = p.required("name")?;
            let Some((data_type, value)) = DataType::declared(p) else {
                return Err(p.error(format!("parameter `{name}` has no value")));
            };
            Ok(Parameter {
                name,
                data_type,
                value: value.required("value")?,
                unit: units.of(value),
            })
        });
        Ok(Self {
            parameters: parameters.collect::<Result<_, _>>()?,
        })
    }
}

/// Content that a structure holds inline or refers to as a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Sourced<T> {
    /// Inline.
    Inline(T),
    /// In a file with this name, relative to the structure.
    File(String),
}

impl<T> Sourced<T> {
    /// The source file that `node` names, else the content that `inline` finds in it; `what` is the
    /// kind of `node` in messages.
    pub(crate) fn read(
        node: &Element,
        what: &str,
        inline: impl FnOnce(&Element) -> Result<Option<T>, XmlError>,
    ) -> Result<Self, XmlError> {
        match (inline(node)?, node.get("source")) {
            (Some(inline), None) => Ok(Self::Inline(inline)),
            (None, Some(source)) => match node.get("sourceBase") {
                None | Some("SSD") => Ok(Self::File(source.to_string())),
                Some(base) => Err(node.error(format!(
                    "{what} `{source}` with sourceBase = `{base}`: only sources relative to the system structure are supported"
                ))),
            },
            _ => Err(node.error(format!(
                "{what} needs either a source or values, and not both"
            ))),
        }
    }
}

/// A parameter set applied to an element.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// Prefix for every name of the set.
    pub prefix: String,
    /// Parameter set.
    pub set: Sourced<ParameterSet>,
    /// Mapping of the set's names and values.
    pub mapping: Option<Sourced<ParameterMapping>>,
}

impl Binding {
    pub(crate) fn read_all(element: &Element) -> Result<Vec<Self>, XmlError> {
        let all = element.listed("ParameterBindings", "ParameterBinding");
        all.map(Self::read).collect()
    }

    fn read(node: &Element) -> Result<Self, XmlError> {
        let mapping = node.child("ParameterMapping").map(|mapping| {
            Sourced::read(mapping, "a parameter mapping", |mapping| {
                let inline = mapping.child("ParameterMapping");
                inline.map(ParameterMapping::read).transpose()
            })
        });
        Ok(Self {
            prefix: node.get("prefix").unwrap_or_default().to_string(),
            set: Sourced::read(node, "a parameter binding", |node| {
                let values = node.child("ParameterValues");
                let inline = values.and_then(|values| values.child("ParameterSet"));
                inline.map(ParameterSet::read).transpose()
            })?,
            mapping: mapping.transpose()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SET: &str = r#"<ssv:ParameterSet xmlns:ssv="urn:ssv" version="1.0" name="x"><ssv:Parameters>
        <ssv:Parameter name="k"><ssv:Real value="2.5" unit="kN/m"/></ssv:Parameter>
        <ssv:Parameter name="n"><ssv:Integer value="3"/></ssv:Parameter>
        <ssv:Parameter name="on"><ssv:Boolean value="true"/></ssv:Parameter>
        <ssv:Parameter name="file"><ssv:String value="a.json"/></ssv:Parameter>
        <ssv:Parameter name="mode"><ssv:Enumeration value="pd"/></ssv:Parameter></ssv:Parameters>
        <ssv:Units><ssc:Unit name="kN/m"><ssc:BaseUnit kg="1" s="-2" factor="1000"/></ssc:Unit></ssv:Units></ssv:ParameterSet>"#;

    #[test]
    fn a_set_of_every_type_is_read_with_its_units() {
        let set = ParameterSet::parse(SET, "x.ssv").unwrap();
        let found: Vec<_> = set
            .parameters
            .iter()
            .map(|p| (p.name.as_str(), p.data_type.name(), p.value.as_str()))
            .collect();
        assert_eq!(
            found,
            [
                ("k", "Real", "2.5"),
                ("n", "Integer", "3"),
                ("on", "Boolean", "true"),
                ("file", "String", "a.json"),
                ("mode", "Enumeration", "pd")
            ]
        );
        let unit = set.parameters[0].unit.as_ref().unwrap();
        assert_eq!(
            (unit.factor, unit.exponents),
            (1000.0, Some([1, 0, -2, 0, 0, 0, 0, 0]))
        );
    }

    #[test]
    fn what_is_no_set_is_refused_with_its_name_and_line() {
        let empty = SET.replace(r#"<ssv:Integer value="3"/>"#, "");
        for (text, expected) in [
            (
                empty.as_str(),
                "`x.ssv`, line 3: parameter `n` has no value",
            ),
            (
                "<a/>",
                "`x.ssv`, line 1: its outermost element is not ParameterSet",
            ),
            ("time,x\n0,1\n", "it is no XML"),
        ] {
            let error = ParameterSet::parse(text, "x.ssv").unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
