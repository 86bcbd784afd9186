//! The element `<ModelStructure>` of FMI 2.0, for `description`: the dependencies of outputs and
//! derivatives while stepping, and of all that is computed in Initialization Mode.

use crate::Model;
use crate::c_api::description::{Element, listed};
use crate::core::dependencies::Knowns;
use crate::core::layout::Layout;
use crate::core::length::MOST_COUNTED;
use crate::core::model::Variable;

pub(super) fn model_structure<M: Model>(layout: &Layout<M>) -> Result<Element, String> {
    let knowns = Knowns::new(layout);
    let unknowns = |element, initially| {
        let mut unknowns = Vec::new();
        let is_unknown = |row: &Variable<M>| match element {
            "Derivatives" => row.storage.is_derivative(),
            _ => {
                !row.storage.is_clock()
                    && row.is_unknown(initially)
                    && (initially || !row.storage.is_equation())
            }
        };
        for (elements, row) in layout.rows().filter(|(_, row)| is_unknown(row)) {
            // No list for a long row with many dependencies, which means that it depends on
            // everything: the list would be repeated for each element.
            let (n, is_short) = (elements.len(), |list: Vec<_>| list.len() <= MOST_COUNTED);
            let is_listed =
                n <= MOST_COUNTED || (knowns.resolve(row, n / 2, initially)?).is_none_or(is_short);
            for (i, position) in elements.enumerate() {
                let knowns = match is_listed {
                    true => knowns.resolve(row, i, initially)?,
                    false => None,
                };
                let knowns = knowns.map(|knowns| listed(knowns.iter().map(|k| k + 1)));
                let unknown = Element::new("Unknown").with([("index", (position + 1).to_string())]);
                unknowns.push(unknown.with(knowns.map(|knowns| ("dependencies", knowns))));
            }
        }
        Ok::<_, String>(Element::new(element).holding(unknowns).if_any())
    };
    Ok(Element::new("ModelStructure")
        .holding(unknowns("Outputs", false)?)
        .holding(unknowns("Derivatives", false)?)
        .holding(unknowns("InitialUnknowns", true)?))
}
