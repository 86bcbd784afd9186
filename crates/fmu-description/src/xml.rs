//! What the files of both versions have in common, and which version a file is of.

use quick_xml::events::Event;
use serde::Deserialize;
use serde::de::Error as _;

use crate::{DefaultExperiment, Description, DescriptionError, Unit, fmi2, fmi3};

/// Read the text of a file.
pub fn read(text: &str) -> Result<Description, DescriptionError> {
    let mut description = match root(text) {
        Some((version, _)) if version.starts_with("3.") => fmi3::read(text)?,
        Some((version, model)) if version != "2.0" => {
            return Err(DescriptionError::Version { model, version });
        }
        _ => fmi2::read(text)?,
    };
    description.index_names();
    Ok(description)
}

/// Version and model that the outermost element names; a file without them is refused by whoever reads it.
fn root(text: &str) -> Option<(String, String)> {
    let mut reader = quick_xml::Reader::from_str(text);
    loop {
        match reader.read_event().ok()? {
            Event::Start(element) | Event::Empty(element) => {
                let get = |name| element.try_get_attribute(name).ok()?;
                let [version, model] = [get("fmiVersion")?, get("modelName")?];
                return Some((version.value.into_owned(), model.value.into_owned()));
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}

/// The identifier becomes a file name and the prefix of C names.
pub fn check_identifier(model: &str, identifier: &str) -> Result<(), DescriptionError> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if identifier.chars().all(is_word) && identifier.starts_with(|c: char| !c.is_ascii_digit()) {
        return Ok(());
    }
    let [model, identifier] = [model, identifier].map(str::to_string);
    Err(DescriptionError::Identifier { model, identifier })
}

/// The outermost element; what each version has in its own way is a parameter: CoSimulation, types, variables, structure.
#[derive(Deserialize)]
pub struct File<C, T, V, S> {
    #[serde(rename = "@modelName")]
    pub model_name: String,
    /// Of FMI 2.0.
    #[serde(rename = "@guid")]
    pub guid: Option<String>,
    /// Of FMI 3.0.
    #[serde(rename = "@instantiationToken")]
    pub token: Option<String>,
    #[serde(rename = "@version", default)]
    pub version: String,
    #[serde(rename = "@generationTool", default)]
    pub generation_tool: String,
    #[serde(rename = "CoSimulation")]
    pub co_simulation: Option<C>,
    #[serde(rename = "UnitDefinitions", default)]
    pub units: Units,
    #[serde(rename = "TypeDefinitions", default)]
    pub types: T,
    #[serde(rename = "LogCategories", default)]
    pub log_categories: LogCategories,
    #[serde(rename = "DefaultExperiment", default)]
    pub default_experiment: DefaultExperiment,
    #[serde(rename = "ModelVariables")]
    pub variables: V,
    #[serde(rename = "ModelStructure", default)]
    pub structure: S,
}

/// An attribute that the version demands.
pub fn required(value: Option<String>, name: &'static str) -> Result<String, DescriptionError> {
    value.ok_or_else(|| quick_xml::DeError::missing_field(name).into())
}

#[derive(Default, Deserialize)]
pub struct Units {
    #[serde(rename = "Unit", default)]
    units: Vec<XmlUnit>,
}

impl Units {
    /// As they are handed out.
    pub fn read(self) -> Vec<Unit> {
        self.units.into_iter().map(unit).collect()
    }
}

fn unit(unit: XmlUnit) -> Unit {
    let base = unit.base.as_ref();
    let exponents = |b: &BaseUnit| [b.kg, b.m, b.s, b.ampere, b.kelvin, b.mol, b.cd, b.rad];
    Unit {
        exponents: base.map(exponents),
        factor: base.map_or(1.0, |b| b.factor),
        offset: base.map_or(0.0, |b| b.offset),
        name: unit.name,
    }
}

#[derive(Deserialize)]
struct XmlUnit {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "BaseUnit")]
    base: Option<BaseUnit>,
}

#[derive(Deserialize)]
struct BaseUnit {
    #[serde(rename = "@kg", default)]
    kg: i32,
    #[serde(rename = "@m", default)]
    m: i32,
    #[serde(rename = "@s", default)]
    s: i32,
    #[serde(rename = "@A", default)]
    ampere: i32,
    #[serde(rename = "@K", default)]
    kelvin: i32,
    #[serde(rename = "@mol", default)]
    mol: i32,
    #[serde(rename = "@cd", default)]
    cd: i32,
    #[serde(rename = "@rad", default)]
    rad: i32,
    #[serde(rename = "@factor", default = "one")]
    factor: f64,
    #[serde(rename = "@offset", default)]
    offset: f64,
}

fn one() -> f64 {
    1.0
}

#[derive(Default, Deserialize)]
pub struct LogCategories {
    #[serde(rename = "Category", default)]
    categories: Vec<Named>,
}

impl LogCategories {
    /// Their names.
    pub fn names(self) -> Vec<String> {
        let categories = self.categories.into_iter();
        categories.map(|category| category.name).collect()
    }
}

#[derive(Deserialize)]
struct Named {
    #[serde(rename = "@name")]
    name: String,
}
