//! The element `<ModelStructure>` of FMI 3.0, for `description`: the dependencies of outputs,
//! derivatives and event indicators, and those in Initialization Mode. An array depends on all that
//! any element depends on; fmi3GetVariableDependencies returns these element by element.

use crate::Model;
use crate::c_api::description::{Element, listed};
use crate::core::dependencies::Knowns;
use crate::core::layout::{Block, Layout};
use crate::core::storage::Storage;

pub(super) fn model_structure<M: Model>(layout: &Layout<M>) -> Result<Element, String> {
    let knowns = Knowns::new(layout);
    let unknown = |element, initially, (number, (span, first, n)): (u32, Block<M>)| {
        let blocks = knowns.blocks(layout, span.row, (first, n), initially)?;
        let dependencies = blocks.map(|blocks| {
            let kinds = vec!["dependent"; blocks.len()].join(" ");
            [
                ("dependencies", listed(blocks)),
                ("dependenciesKind", kinds),
            ]
        });
        Ok(Element::new(element)
            .with([("valueReference", number.to_string())])
            .with(dependencies.into_iter().flatten()))
    };
    let unknowns = |element, initially: bool| {
        let blocks = layout.blocks();
        blocks
            .filter(|(_, (span, ..))| match element {
                "ContinuousStateDerivative" => span.row.storage.is_derivative(),
                "EventIndicator" => matches!(span.row.storage, Storage::Indicator),
                "ClockedState" => span.row.previous.is_some(),
                _ if span.row.storage.is_clock() => span.row.is_unknown(false) && !initially,
                _ => {
                    span.row.is_unknown(initially) && (initially || !span.row.storage.is_equation())
                }
            })
            .map(|block| unknown(element, initially, block))
            .collect::<Result<Vec<_>, String>>()
    };
    Ok(Element::new("ModelStructure")
        .holding(unknowns("Output", false)?)
        .holding(unknowns("ContinuousStateDerivative", false)?)
        .holding(unknowns("ClockedState", false)?)
        .holding(unknowns("InitialUnknown", true)?)
        .holding(unknowns("EventIndicator", false)?))
}
