//! Transformations of values, which connections and parameter mappings have: linear, or from value
//! to value. `cosim` applies them.

use std::collections::HashSet;
use std::hash::Hash;

use fmi_description::xml::{self, Element, XmlError};

/// How a connection or a parameter mapping changes a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Transformation {
    /// `factor` · value + `offset`.
    Linear {
        /// Factor.
        factor: f64,
        /// Offset, in the unit of the end that receives the value.
        offset: f64,
    },
    /// Each Boolean and its replacement; other values stay.
    Booleans(Vec<(bool, bool)>),
    /// Each integer and its replacement; other values stay.
    Integers(Vec<(i64, i64)>),
    /// Each enumeration item and its replacement, by name; other values stay.
    Items(Vec<(String, String)>),
}

impl Transformation {
    /// The transformation that the element `node` contains, if it contains one.
    pub(crate) fn read(node: &Element) -> Result<Option<Self>, XmlError> {
        for child in &node.children {
            return Ok(Some(match child.tag.as_str() {
                "LinearTransformation" => read_linear(child)?,
                "BooleanMappingTransformation" => Self::Booleans(read_entries(child, xml::truth)?),
                "IntegerMappingTransformation" => {
                    Self::Integers(read_entries(child, |text| text.trim().parse().ok())?)
                }
                "EnumerationMappingTransformation" => {
                    Self::Items(read_entries(child, |text| Some(text.to_string()))?)
                }
                _ => continue,
            }));
        }
        Ok(None)
    }
}

fn read_linear(node: &Element) -> Result<Transformation, XmlError> {
    let text = |name, default| node.get(name).unwrap_or(default);
    let (factor, offset) = (text("factor", "1"), text("offset", "0"));
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    match (number(factor), number(offset)) {
        (Some(factor), Some(offset)) => Ok(Transformation::Linear { factor, offset }),
        _ => Err(node.error(format!(
            "LinearTransformation with factor {factor} and offset {offset}; both must be finite"
        ))),
    }
}

fn read_entries<T: Clone + Eq + Hash>(
    node: &Element,
    value: impl Fn(&str) -> Option<T>,
) -> Result<Vec<(T, T)>, XmlError> {
    let (mut entries, mut sources) = (Vec::new(), HashSet::new());
    for entry in node.all("MapEntry") {
        let get = |name| {
            let text = entry.required(name)?;
            value(&text).ok_or_else(|| {
                entry.error(format!("{}: `{text}` is no value of its type", node.tag))
            })
        };
        let (source, target) = (get("source")?, get("target")?);
        if !sources.insert(source.clone()) {
            let text = entry.required("source")?;
            return Err(entry.error(format!("{}: two entries map `{text}`", node.tag)));
        }
        entries.push((source, target));
    }
    Ok(entries)
}
