//! What several kinds of files have in common: units, enumerations, types, transformations.

use crate::error::StructureError;
use crate::xml::Node;

/// A unit: value in base units = `factor` · value + `offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Name.
    pub name: String,
    /// Exponents of kg, m, s, A, K, mol, cd and rad; None where the file does not define the unit.
    pub exponents: Option<[i32; 8]>,
    /// Factor to base units.
    pub factor: f64,
    /// Offset in base units.
    pub offset: f64,
}

/// Names of the base units, in the order of [`Unit::exponents`].
const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

impl Unit {
    /// A unit that is known by its name alone.
    pub fn named(name: &str) -> Self {
        let (name, exponents) = (name.to_string(), None);
        Self {
            name,
            exponents,
            factor: 1.0,
            offset: 0.0,
        }
    }

    pub(crate) fn read_all(file: &Node) -> Result<Vec<Self>, StructureError> {
        file.listed("Units", "Unit").map(Self::read).collect()
    }

    fn read(node: &Node) -> Result<Self, StructureError> {
        let mut unit = Self::named(node.required("name")?);
        let Some(base) = node.child("BaseUnit") else {
            return Ok(unit);
        };
        let mut exponents = [0; 8];
        for (exponent, name) in exponents.iter_mut().zip(BASE) {
            let Some(text) = base.attribute(name) else {
                continue;
            };
            *exponent = text.trim().parse().map_err(|_| {
                base.error(format!(
                    "unit `{}`: the exponent {name} = `{text}` must be a whole number",
                    unit.name
                ))
            })?;
        }
        unit.exponents = Some(exponents);
        unit.factor = base.number("factor")?.unwrap_or(1.0);
        unit.offset = base.number("offset")?.unwrap_or(0.0);
        Ok(unit)
    }

    /// The unit `name` of a file; by its name alone where the file does not define it.
    pub(crate) fn of(units: &[Self], name: &str) -> Self {
        let found = units.iter().find(|u| u.name == name);
        found.cloned().unwrap_or_else(|| Self::named(name))
    }
}

/// An enumeration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Name.
    pub name: String,
    /// Names and values of its items.
    pub items: Vec<(String, i64)>,
}

impl Enumeration {
    pub(crate) fn read_all(file: &Node) -> Result<Vec<Self>, StructureError> {
        file.listed("Enumerations", "Enumeration")
            .map(Self::read)
            .collect()
    }

    fn read(node: &Node) -> Result<Self, StructureError> {
        let items = node.children.iter().filter(|c| c.name == "Item");
        let item = |item: &Node| {
            let (name, value) = (item.required("name")?, item.required("value")?);
            let number = value.trim().parse().map_err(|_| {
                item.error(format!(
                    "item `{name}` has the value `{value}`; it must be a whole number"
                ))
            })?;
            Ok((name.to_string(), number))
        };
        Ok(Self {
            name: node.required("name")?.to_string(),
            items: items.map(item).collect::<Result<_, _>>()?,
        })
    }
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
    pub(crate) fn declared(node: &Node) -> Option<(Self, &Node)> {
        let mut typed = node
            .children
            .iter()
            .filter_map(|c| Some((Self::of(&c.name)?, c)));
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
    pub(crate) fn read(node: &Node) -> Result<Option<Self>, StructureError> {
        for child in &node.children {
            return Ok(Some(match child.name.as_str() {
                "LinearTransformation" => linear(child)?,
                "BooleanMappingTransformation" => {
                    Self::Booleans(entries(child, |text| match text.trim() {
                        "true" | "1" => Some(true),
                        "false" | "0" => Some(false),
                        _ => None,
                    })?)
                }
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

fn linear(node: &Node) -> Result<Transformation, StructureError> {
    let text = |name, default| node.attribute(name).unwrap_or(default);
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
    node: &Node,
    value: impl Fn(&str) -> Option<T>,
) -> Result<Vec<(T, T)>, StructureError> {
    let mut entries: Vec<(T, T)> = Vec::new();
    for entry in node.children.iter().filter(|c| c.name == "MapEntry") {
        let get = |name| {
            let text = entry.required(name)?;
            value(text).ok_or_else(|| {
                entry.error(format!("{}: `{text}` is no value of its type", node.name))
            })
        };
        let (source, target) = (get("source")?, get("target")?);
        if entries.iter().any(|(other, _)| *other == source) {
            let text = entry.required("source")?;
            return Err(entry.error(format!("{}: two entries map `{text}`", node.name)));
        }
        entries.push((source, target));
    }
    Ok(entries)
}
