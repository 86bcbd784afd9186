//! `<ModelStructure>`: what the outputs depend on, while stepping and in Initialization Mode.

use crate::Model;
use crate::border::description::{Xml, empty};
use crate::core::causality::Causality;
use crate::core::dependencies::Knowns;
use crate::core::layout::Layout;
use crate::core::model::Variable;
use std::io;

pub(super) fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let outputs: &[Causality] = &[Causality::Output];
    let initial: &[Causality] = &[Causality::Output, Causality::CalculatedParameter];
    let has = |which: &[Causality]| layout.iter().any(|(_, row)| which.contains(&row.causality));
    if !has(initial) {
        return xml
            .create_element("ModelStructure")
            .write_empty()
            .map(|_| ());
    }
    xml.create_element("ModelStructure")
        .write_inner_content(|xml| {
            let knowns = Knowns::new(layout);
            if has(outputs) {
                unknowns(xml, "Outputs", layout, outputs, |row, i| {
                    knowns.resolve(row.dependencies, i, false)
                })?;
            }
            unknowns(xml, "InitialUnknowns", layout, initial, |row, i| {
                knowns.resolve(row.initial_dependencies, i, true)
            })
        })?;
    Ok(())
}

fn unknowns<M: Model>(
    xml: &mut Xml,
    element: &str,
    layout: &Layout<M>,
    which: &[Causality],
    knowns: impl Fn(&Variable<M>, usize) -> Result<Option<Vec<usize>>, String>,
) -> io::Result<()> {
    xml.create_element(element).write_inner_content(|xml| {
        for (position, (i, row)) in (1_usize..).zip(layout.iter()) {
            if !which.contains(&row.causality) {
                continue;
            }
            let index = position.to_string();
            let mut attributes = vec![("index", index)];
            if let Some(knowns) = knowns(row, i).map_err(io::Error::other)? {
                let knowns: Vec<_> = (knowns.iter()).map(|k| (k + 1).to_string()).collect();
                attributes.push(("dependencies", knowns.join(" ")));
            }
            empty(xml, "Unknown", &attributes)?;
        }
        Ok(())
    })?;
    Ok(())
}
