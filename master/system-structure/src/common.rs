//! What several kinds of files have in common: units, types, transformations.

use fmi_description::Unit;
use fmi_description::xml::{self, Element, XmlError};

/// The units that a file defines.
pub(crate) fn units(file: &Element) -> Result<Vec<Unit>, XmlError> {
    file.listed("Units", "Unit").map(Unit::read).collect()
}

/// Type of a connector or of a parameter; the widths of numbers are left to the FMUs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// Real, Float64, Float32.
    Real,
    /// Integer and those of FMI 3.0.
    Integer,
    /// Boolean.
    Boolean,
    /// String.
    String,
    /// Enumeration.
    Enumeration,
    /// Binary.
    Binary,
    /// Clock.
    Clock,
}

impl DataType {
    /// Its name in SSP 1.0.
    pub fn name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
            Self::String => "String",
            Self::Enumeration => "Enumeration",
            Self::Binary => "Binary",
            Self::Clock => "Clock",
        }
    }

    /// The type that an element of this name stands for.
    fn of(element: &str) -> Option<Self> {
        Some(match element {
            "Real" | "Float64" | "Float32" => Self::Real,
            "Integer" | "Int8" | "UInt8" | "Int16" | "UInt16" | "Int32" | "UInt32" | "Int64"
            | "UInt64" => Self::Integer,
            "Boolean" => Self::Boolean,
            "String" => Self::String,
            "Enumeration" => Self::Enumeration,
            "Binary" => Self::Binary,
            "Clock" => Self::Clock,
            _ => return None,
        })
    }

    /// The element in `node` that says its type, with that type.
    pub(crate) fn declared(node: &Element) -> Option<(Self, &Element)> {
        let mut typed = node
            .children
            .iter()
            .filter_map(|c| Some((Self::of(&c.tag)?, c)));
        typed.next()
    }
}

/// What becomes of a value on its way.
#[derive(Clone, Debug, PartialEq)]
pub enum Transformation {
    /// `factor` · value + `offset`.
    Linear {
        /// Factor.
        factor: f64,
        /// Offset, in the unit of the end.
        offset: f64,
    },
    /// Truth values and what each becomes; others stay.
    Booleans(Vec<(bool, bool)>),
    /// Whole numbers and what each becomes; others stay.
    Integers(Vec<(i64, i64)>),
    /// Items of enumerations, by name, and what each becomes; others stay.
    Items(Vec<(String, String)>),
}

impl Transformation {
    /// The one in `node`, if there is one.
    pub(crate) fn read(node: &Element) -> Result<Option<Self>, XmlError> {
        for child in &node.children {
            return Ok(Some(match child.tag.as_str() {
                "LinearTransformation" => linear(child)?,
                "BooleanMappingTransformation" => Self::Booleans(entries(child, xml::truth)?),
                "IntegerMappingTransformation" => {
                    Self::Integers(entries(child, |text| text.trim().parse().ok())?)
                }
                "EnumerationMappingTransformation" => {
                    Self::Items(entries(child, |text| Some(text.to_string()))?)
                }
                _ => continue,
            }));
        }
        Ok(None)
    }
}

fn linear(node: &Element) -> Result<Transformation, XmlError> {
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

fn entries<T: PartialEq>(
    node: &Element,
    value: impl Fn(&str) -> Option<T>,
) -> Result<Vec<(T, T)>, XmlError> {
    let mut entries: Vec<(T, T)> = Vec::new();
    for entry in node.all("MapEntry") {
        let get = |name| {
            let text = entry.required(name)?;
            value(&text).ok_or_else(|| {
                entry.error(format!("{}: `{text}` is no value of its type", node.tag))
            })
        };
        let (source, target) = (get("source")?, get("target")?);
        if entries.iter().any(|(other, _)| *other == source) {
            let text = entry.required("source")?;
            return Err(entry.error(format!("{}: two entries map `{text}`", node.tag)));
        }
        entries.push((source, target));
    }
    Ok(entries)
}
