//! `modelDescription.xml`, made from the table of variables.

mod structure;
mod table;
mod variables;

use super::log::CATEGORIES;
use crate::core::info::Enumeration;
use crate::core::layout::Layout;
use crate::core::unit::{DIMENSIONS, Unit};
use crate::core::variable::Variable;
use crate::{KNOWN_UNITS, Model};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;
use uuid::Uuid;

/// Writes into memory.
type Xml = Writer<Vec<u8>>;

/// A model description and the GUID in it.
pub(crate) struct Description {
    pub(crate) xml: String,
    pub(crate) guid: Uuid,
}

/// The text of `modelDescription.xml`, or what is wrong with the table of variables.
///
/// The GUID is a hash of the text without it: the text is the same on every platform and says when the interface changed.
pub fn model_description<M: Model>() -> Result<String, String> {
    Ok(describe(&Layout::<M>::new())?.xml)
}

pub(crate) fn describe<M: Model>(layout: &Layout<M>) -> Result<Description, String> {
    table::check(layout)?;
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    write(&mut writer, layout).map_err(|e| e.to_string())?;
    let bytes = writer.into_inner();
    let guid = Uuid::new_v5(&Uuid::NAMESPACE_OID, &bytes);
    let xml = String::from_utf8(bytes).map_err(|e| e.to_string())? + "\n";
    Ok(Description {
        xml: xml.replacen("guid=\"\"", &format!("guid=\"{{{guid}}}\""), 1),
        guid,
    })
}

fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let info = &M::INFO;
    let generator = concat!("fmu-export ", env!("CARGO_PKG_VERSION"));
    let mut attributes = vec![
        ("fmiVersion", "2.0"),
        ("modelName", info.model),
        ("guid", ""),
    ];
    let optional = [
        ("description", info.description),
        ("author", info.author),
        ("version", info.version),
        ("copyright", info.copyright),
        ("license", info.license),
    ];
    attributes.extend(optional.into_iter().filter(|(_, text)| !text.is_empty()));
    attributes.push(("generationTool", generator));
    attributes.push(("variableNamingConvention", "structured"));
    xml.create_element("fmiModelDescription")
        .with_attributes(attributes)
        .write_inner_content(|xml| {
            co_simulation::<M>(xml)?;
            units(xml, layout)?;
            types(xml, layout)?;
            categories::<M>(xml)?;
            experiment::<M>(xml)?;
            variables::write(xml, layout)?;
            structure::write(xml, layout)
        })?;
    Ok(())
}

fn co_simulation<M: Model>(xml: &mut Xml) -> io::Result<()> {
    let flag = |yes: bool| if yes { "true" } else { "false" };
    xml.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", M::INFO.model),
            ("needsExecutionTool", "false"),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canInterpolateInputs", flag(M::INFO.input_derivatives)),
            (
                "maxOutputDerivativeOrder",
                if M::INFO.output_derivatives { "1" } else { "0" },
            ),
            ("canRunAsynchronuously", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canNotUseMemoryManagementFunctions", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
            (
                "providesDirectionalDerivative",
                flag(M::INFO.directional_derivatives),
            ),
        ])
        .write_empty()?;
    Ok(())
}

/// The unit of an element: what the row brings along, else the model's own, else the known one.
fn unit<M: Model>(row: &Variable<M>, i: usize) -> Option<&'static Unit> {
    let name = row.unit_of(i)?;
    (row.own_unit.into_iter())
        .chain(M::INFO.units)
        .chain(KNOWN_UNITS)
        .find(|unit| unit.name == name)
}

/// The units in use, in the order of first use.
fn units<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let mut used: Vec<&Unit> = Vec::new();
    for (i, row) in layout.iter() {
        if let Some(unit) = unit(row, i)
            && !used.iter().any(|known| known.name == unit.name)
        {
            used.push(unit);
        }
    }
    if used.is_empty() {
        return Ok(());
    }
    xml.create_element("UnitDefinitions")
        .write_inner_content(|xml| {
            for unit in used {
                write_unit(xml, unit)?;
            }
            Ok(())
        })?;
    Ok(())
}

fn write_unit(xml: &mut Xml, unit: &Unit) -> io::Result<()> {
    let exponents = DIMENSIONS.into_iter().zip(unit.exponents);
    let mut base: Vec<_> = exponents
        .filter(|(_, exponent)| *exponent != 0)
        .map(|(name, exponent)| (name, exponent.to_string()))
        .collect();
    base.extend(scale(unit.factor, unit.offset));
    xml.create_element("Unit")
        .with_attribute(("name", unit.name))
        .write_inner_content(|xml| {
            xml.create_element("BaseUnit")
                .with_attributes(base.iter().map(|(name, value)| (*name, value.as_str())))
                .write_empty()?;
            for shown in unit.display {
                let mut attributes = vec![("name", shown.name.to_owned())];
                attributes.push(("factor", real(shown.factor)));
                attributes.extend(scale(1.0, shown.offset));
                let attributes = attributes
                    .iter()
                    .map(|(name, value)| (*name, value.as_str()));
                xml.create_element("DisplayUnit")
                    .with_attributes(attributes)
                    .write_empty()?;
            }
            Ok(())
        })?;
    Ok(())
}

/// Attributes of a factor and an offset, unless they are 1 and 0, which is what their absence means.
fn scale(factor: f64, offset: f64) -> impl Iterator<Item = (&'static str, String)> {
    let factor = (factor != 1.0).then(|| ("factor", real(factor)));
    let offset = (offset != 0.0).then(|| ("offset", real(offset)));
    factor.into_iter().chain(offset)
}

/// The enumerations in use, in the order of first use.
fn types<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let mut used: Vec<&Enumeration> = Vec::new();
    for (_, row) in layout.iter() {
        if let Some(enumeration) = row.enumeration
            && !used.iter().any(|known| known.name == enumeration.name)
        {
            used.push(enumeration);
        }
    }
    if used.is_empty() {
        return Ok(());
    }
    xml.create_element("TypeDefinitions")
        .write_inner_content(|xml| {
            for enumeration in used {
                let attributes = [
                    ("name", enumeration.name),
                    ("description", enumeration.description),
                ];
                xml.create_element("SimpleType")
                    .with_attributes(attributes)
                    .write_inner_content(|xml| {
                        xml.create_element("Enumeration")
                            .write_inner_content(|xml| items(xml, enumeration))?;
                        Ok(())
                    })?;
            }
            Ok(())
        })?;
    Ok(())
}

fn items(xml: &mut Xml, enumeration: &Enumeration) -> io::Result<()> {
    for (value, (name, description)) in (1..).zip(enumeration.items) {
        let value = i32::to_string(&value);
        let attributes = [
            ("name", *name),
            ("value", &value),
            ("description", description),
        ];
        xml.create_element("Item")
            .with_attributes(attributes)
            .write_empty()?;
    }
    Ok(())
}

fn categories<M: Model>(xml: &mut Xml) -> io::Result<()> {
    let each = CATEGORIES.map(|(name, _, description)| (name, description));
    xml.create_element("LogCategories")
        .write_inner_content(|xml| {
            for (name, description) in each.iter().chain(M::INFO.log_categories) {
                let attributes = [("name", *name), ("description", *description)];
                xml.create_element("Category")
                    .with_attributes(attributes)
                    .write_empty()?;
            }
            Ok(())
        })?;
    Ok(())
}

fn experiment<M: Model>(xml: &mut Xml) -> io::Result<()> {
    let e = M::INFO.experiment;
    let (start, stop, step) = (real(e.start), real(e.stop), real(e.step));
    let attributes = [
        ("startTime", start.as_str()),
        ("stopTime", &stop),
        ("stepSize", &step),
    ];
    xml.create_element("DefaultExperiment")
        .with_attributes(attributes)
        .write_empty()?;
    Ok(())
}

/// The shortest decimal that reads back as the same number.
fn real(x: f64) -> String {
    format!("{x:?}")
}
