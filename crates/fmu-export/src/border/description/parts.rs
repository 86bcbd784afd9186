//! Parts of a model description that are the same in every version of FMI.

use crate::border::log::CATEGORIES;
use crate::core::causality::Causality;
use crate::core::enumeration::Enumeration;
use crate::core::info::Info;
use crate::core::layout::Layout;
use crate::core::model::Variable;
use crate::core::place::Place;
use crate::core::unit::{DIMENSIONS, Unit};
use crate::{KNOWN_UNITS, Model};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

/// Writes into memory.
pub(crate) type Xml = Writer<Vec<u8>>;

/// The text of a file, without the end of its last line.
pub(crate) fn text(write: impl FnOnce(&mut Xml) -> io::Result<()>) -> Result<String, String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let declaration = Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None));
    (xml.write_event(declaration))
        .and_then(|()| write(&mut xml))
        .map_err(|e| e.to_string())?;
    String::from_utf8(xml.into_inner()).map_err(|e| e.to_string())
}

/// Attributes of the root: what comes before those of the model, what may be said of it, what comes
/// after.
pub(crate) fn root_attributes<'a>(
    info: &'static Info,
    version: &'static str,
    hash: (&'static str, &'a str),
) -> Vec<(&'static str, &'a str)> {
    let generator = concat!("fmu-export ", env!("CARGO_PKG_VERSION"));
    let mut attributes = vec![("fmiVersion", version), ("modelName", info.model), hash];
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
    attributes
}

/// An element without content.
pub(crate) fn empty(
    xml: &mut Xml,
    name: &str,
    attributes: &[(&'static str, String)],
) -> io::Result<()> {
    let attributes = (attributes.iter()).map(|(name, value)| (*name, value.as_str()));
    xml.create_element(name)
        .with_attributes(attributes)
        .write_empty()?;
    Ok(())
}

/// `true` or `false`.
pub(crate) fn flag(yes: bool) -> &'static str {
    if yes { "true" } else { "false" }
}

/// The unit of an element: what the row brings along, else the model's own, else the known one.
pub(crate) fn unit<M: Model>(row: &Variable<M>, i: usize) -> Option<&'static Unit> {
    let name = row.unit_of(i)?;
    (row.own_unit.into_iter())
        .chain(M::INFO.units)
        .chain(KNOWN_UNITS)
        .find(|unit| unit.name == name)
}

/// The units in use, in the order of first use.
pub(super) fn units_in_use<M: Model>(layout: &Layout<M>) -> Vec<&'static Unit> {
    let mut used: Vec<&Unit> = Vec::new();
    for (elements, row) in layout.rows() {
        let different = elements.len().min(row.each_unit.len()).max(1);
        for unit in (0..different).filter_map(|i| unit::<M>(row, i)) {
            if !used.iter().any(|known| known.name == unit.name) {
                used.push(unit);
            }
        }
    }
    used
}

pub(crate) fn units<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let used = units_in_use(layout);
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

/// Attributes of a factor and an offset, unless they are 1 and 0, which is what their absence
/// means.
fn scale(factor: f64, offset: f64) -> impl Iterator<Item = (&'static str, String)> {
    let factor = (factor != 1.0).then(|| ("factor", real(factor)));
    let offset = (offset != 0.0).then(|| ("offset", real(offset)));
    factor.into_iter().chain(offset)
}

/// The enumerations in use, in the order of first use.
pub(crate) fn enumerations<M: Model>(layout: &Layout<M>) -> Vec<Enumeration> {
    let mut used: Vec<Enumeration> = Vec::new();
    for (_, row) in layout.rows() {
        if let Some(enumeration) = row.enumeration
            && !used.iter().any(|known| known.name == enumeration.name)
        {
            used.push(enumeration);
        }
    }
    used
}

/// The types of the enumerations, in one element or, one in the other, in two.
pub(crate) fn types<M: Model>(
    xml: &mut Xml,
    layout: &Layout<M>,
    (outer, inner): (&str, Option<&str>),
) -> io::Result<()> {
    let used = enumerations(layout);
    if used.is_empty() {
        return Ok(());
    }
    xml.create_element("TypeDefinitions")
        .write_inner_content(|xml| {
            for enumeration in &used {
                let attributes = [
                    ("name", enumeration.name),
                    ("description", enumeration.description),
                ];
                xml.create_element(outer)
                    .with_attributes(attributes)
                    .write_inner_content(|xml| match inner {
                        None => items(xml, enumeration),
                        Some(inner) => xml
                            .create_element(inner)
                            .write_inner_content(|xml| items(xml, enumeration))
                            .map(|_| ()),
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

pub(crate) fn categories<M: Model>(xml: &mut Xml) -> io::Result<()> {
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

pub(crate) fn experiment<M: Model>(xml: &mut Xml) -> io::Result<()> {
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
pub(crate) fn real(x: f64) -> String {
    format!("{x:?}")
}

/// Attributes of a type: bounds, nominal value and unit of element `i`.
pub(crate) fn type_attributes<M: Model>(
    row: &Variable<M>,
    i: usize,
) -> Vec<(&'static str, String)> {
    let mut attributes = Vec::new();
    let mut add = |name, value: Option<String>| attributes.extend(value.map(|value| (name, value)));
    let is_real = row.place.is_real();
    let bound = |x: f64| {
        x.is_finite()
            .then(|| if is_real { real(x) } else { x.to_string() })
    };
    add("declaredType", row.enumeration.map(|e| e.name.to_owned()));
    add("unit", row.unit_of(i).map(str::to_owned));
    add("displayUnit", row.display_unit.map(str::to_owned));
    add("min", bound(row.min));
    add("max", bound(row.max));
    add("nominal", row.nominal.map(real));
    attributes
}

impl<M: Model> Variable<M> {
    pub(crate) fn variability(&self) -> &'static str {
        match self.causality {
            Causality::Constant => "constant",
            Causality::Parameter | Causality::CalculatedParameter if self.tunable => "tunable",
            Causality::Parameter | Causality::CalculatedParameter => "fixed",
            _ if self.place.is_real() && !self.discrete => "continuous",
            _ => "discrete",
        }
    }

    /// What `causality` and `initial` say; inputs have no `initial`.
    pub(crate) fn causality_and_initial(&self) -> (&'static str, Option<&'static str>) {
        match self.causality {
            Causality::Input => ("input", None),
            Causality::Output => ("output", Some("calculated")),
            Causality::Local => ("local", Some("calculated")),
            Causality::Parameter => ("parameter", Some("exact")),
            Causality::CalculatedParameter => ("calculatedParameter", Some("calculated")),
            Causality::Constant => ("local", Some("exact")),
        }
    }

    /// Start value of an input, a parameter or a constant; what is computed has none.
    pub(crate) fn start(
        &self,
        p: &M::Parameters,
        u: &M::Input,
        y: &M::Output,
        i: usize,
    ) -> Option<String> {
        let is_constant = self.causality == Causality::Constant;
        match &self.place {
            Place::RealIn(place) => Some(real(place.get(u, i))),
            Place::IntegerIn(place) => Some(place.get(u, i).to_string()),
            Place::BooleanIn(place) => Some(place.get(u, i).to_string()),
            Place::RealParameter(place) => Some(real(place.get(p, i))),
            Place::IntegerParameter(place) => Some(place.get(p, i).to_string()),
            Place::BooleanParameter(place) => Some(place.get(p, i).to_string()),
            Place::StringParameter(get, _) => Some(get(p).to_owned()),
            Place::RealOut(place) => is_constant.then(|| real(place.get(y, i))),
            Place::IntegerOut(place) => is_constant.then(|| place.get(y, i).to_string()),
            Place::BooleanOut(place) => is_constant.then(|| place.get(y, i).to_string()),
            Place::StringOut(_) => None,
        }
    }
}
