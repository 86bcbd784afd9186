//! `<ModelStructure>`: what the outputs depend on, while stepping and in Initialization Mode. An
//! array depends on what one of its elements depends on; fmi3GetVariableDependencies tells it
//! element by element.

use crate::Model;
use crate::border::description::{Xml, empty};
use crate::core::causality::{Causality, Dependencies};
use crate::core::dependencies::Knowns;
use crate::core::layout::Layout;
use crate::core::model::Variable;
use std::collections::BTreeSet;
use std::io;

pub(super) fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let outputs: &[Causality] = &[Causality::Output];
    let initial: &[Causality] = &[Causality::Output, Causality::CalculatedParameter];
    let knowns = Knowns::new(layout);
    if !layout
        .iter()
        .any(|(_, row)| initial.contains(&row.causality))
    {
        return empty(xml, "ModelStructure", &[]);
    }
    xml.create_element("ModelStructure")
        .write_inner_content(|xml| {
            unknowns(xml, "Output", layout, outputs, |row| {
                (row.dependencies, &knowns, false)
            })?;
            unknowns(xml, "InitialUnknown", layout, initial, |row| {
                (row.initial_dependencies, &knowns, true)
            })
        })?;
    Ok(())
}

fn unknowns<'a, M: Model>(
    xml: &mut Xml,
    element: &str,
    layout: &Layout<M>,
    which: &[Causality],
    declared: impl Fn(&Variable<M>) -> (Dependencies, &'a Knowns, bool),
) -> io::Result<()> {
    for number in layout.blocks() {
        let (run, first, n) = layout.block(number).expect("of the layout");
        if !which.contains(&run.row.causality) {
            continue;
        }
        let (dependencies, knowns, initially) = declared(run.row);
        let mut attributes = vec![("valueReference", number.to_string())];
        let mut blocks = Some(BTreeSet::new());
        for i in first..first + n {
            let positions =
                (knowns.resolve(dependencies, i, initially)).map_err(io::Error::other)?;
            blocks = blocks.zip(positions).map(|(mut blocks, positions)| {
                blocks.extend(positions.iter().map(|&p| layout.block_at(p).0));
                blocks
            });
        }
        if let Some(blocks) = blocks {
            let list: Vec<_> = blocks.iter().map(u32::to_string).collect();
            attributes.push(("dependencies", list.join(" ")));
            attributes.push(("dependenciesKind", vec!["dependent"; list.len()].join(" ")));
        }
        empty(xml, element, &attributes)?;
    }
    Ok(())
}
