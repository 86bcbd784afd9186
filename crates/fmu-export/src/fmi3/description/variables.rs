//! `<ModelVariables>`: time, and one variable for each row; a row whose elements have different
//! units is one for each element.

use super::super::instance::NAMES;
use crate::Model;
use crate::border::description::{Xml, empty, type_attributes};
use crate::core::causality::Causality;
use crate::core::layout::{Layout, TIME};
use crate::core::model::Variable;
use crate::core::place::Kind;
use std::io;

pub(super) fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let (parameters, input) = M::defaults();
    let output = M::Output::default();
    xml.create_element("ModelVariables")
        .write_inner_content(|xml| {
            let time = [
                ("name", "time".to_owned()),
                ("valueReference", TIME.to_string()),
                ("description", "simulated time".to_owned()),
                ("causality", "independent".to_owned()),
                ("variability", "continuous".to_owned()),
            ];
            empty(xml, "Float64", &time)?;
            for number in layout.blocks() {
                let (run, first, n) = layout.block(number).expect("of the layout");
                let starts = (first..first + n)
                    .map(|i| run.row.start(&parameters, &input, &output, i))
                    .collect();
                let dimension = run.is_array().then_some(n);
                variable(xml, number, run.row, first, dimension, starts)?;
            }
            Ok(())
        })?;
    Ok(())
}

/// A variable, with its start values if it has any.
fn variable<M: Model>(
    xml: &mut Xml,
    number: u32,
    row: &Variable<M>,
    first: usize,
    dimension: Option<usize>,
    starts: Option<Vec<String>>,
) -> io::Result<()> {
    let name = match dimension {
        Some(_) => row.name.to_owned(),
        None => row.element_name(first),
    };
    let (causality, initial) = row.causality_and_initial();
    let mut attributes = vec![
        ("name", name),
        ("valueReference", number.to_string()),
        ("description", row.description.to_owned()),
        ("causality", causality.to_owned()),
        ("variability", row.variability().to_owned()),
    ];
    if row.has_intermediate_update() {
        attributes.push(("intermediateUpdate", "true".to_owned()));
    }
    attributes.extend(initial.map(|initial| ("initial", initial.to_owned())));
    attributes.extend(type_attributes(row, first));
    let is_text = row.place.kind() == Kind::String;
    let starts = starts.unwrap_or_default();
    if !is_text && !starts.is_empty() {
        attributes.push(("start", starts.join(" ")));
    }
    let element = match row.enumeration {
        Some(_) => NAMES.enumeration,
        None => row.place.kind().name(&NAMES),
    };
    let has_texts = is_text && !starts.is_empty();
    if dimension.is_none() && !has_texts {
        return empty(xml, element, &attributes);
    }
    let attributes = (attributes.iter()).map(|(name, value)| (*name, value.as_str()));
    xml.create_element(element)
        .with_attributes(attributes)
        .write_inner_content(|xml| {
            if let Some(n) = dimension {
                empty(xml, "Dimension", &[("start", n.to_string())])?;
            }
            for text in starts.into_iter().filter(|_| is_text) {
                empty(xml, "Start", &[("value", text)])?;
            }
            Ok(())
        })?;
    Ok(())
}

impl<M: Model> Variable<M> {
    /// Whether it can be read within steps: what is continuous and for wiring.
    pub(crate) fn has_intermediate_update(&self) -> bool {
        self.causality == Causality::Output && self.variability() == "continuous"
    }
}
