//! `<ModelVariables>`.

use crate::Model;
use crate::border::description::{Xml, empty, type_attributes};
use crate::core::layout::Layout;
use crate::core::model::Variable;
use crate::core::place::Names;
use std::io;

pub(super) fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let (parameters, input) = M::defaults();
    let output = M::Output::default();
    xml.create_element("ModelVariables")
        .write_inner_content(|xml| {
            for (vr, (i, row)) in layout.numbered() {
                let start = row.start(&parameters, &input, &output, i);
                write_variable(xml, vr, row, i, start)?;
            }
            Ok(())
        })?;
    Ok(())
}

fn write_variable<M: Model>(
    xml: &mut Xml,
    vr: u32,
    row: &Variable<M>,
    i: usize,
    start: Option<String>,
) -> io::Result<()> {
    let (vr, name) = (vr.to_string(), row.element_name(i));
    let (causality, initial) = row.causality_and_initial();
    let mut attributes = vec![
        ("name", name.as_str()),
        ("valueReference", &vr),
        ("description", row.description),
        ("causality", causality),
        ("variability", row.variability()),
    ];
    attributes.extend(initial.map(|initial| ("initial", initial)));
    xml.create_element("ScalarVariable")
        .with_attributes(attributes)
        .write_inner_content(|xml| {
            let mut attributes = type_attributes(row, i);
            attributes.extend(start.map(|start| ("start", start)));
            let element = match row.enumeration {
                Some(_) => "Enumeration",
                None => row.place.kind().name(&Names::PLAIN),
            };
            empty(xml, element, &attributes)
        })?;
    Ok(())
}
