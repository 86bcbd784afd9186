//! `<ModelStructure>`: what outputs and derivatives depend on, while stepping and in Initialization Mode.

use crate::Model;
use crate::border::description::{Element, listed};
use crate::core::dependencies::Knowns;
use crate::core::layout::{Layout, MOST_COUNTED};

pub(super) fn of<M: Model>(layout: &Layout<M>) -> Result<Element, String> {
    let knowns = Knowns::new(layout);
    let unknowns = |element, initially| {
        let all = knowns.all(initially);
        let unknowns = (1_usize..).zip(layout.iter());
        let unknowns = unknowns.filter(|(_, (_, row))| match element {
            "Derivatives" => row.place.is_derivative(),
            _ => row.is_unknown(initially) && (initially || !row.place.is_behind()),
        });
        let unknowns = unknowns.map(|(index, (i, row))| {
            // A long row that depends on everything does not list it for each of its elements.
            let is_all = |listed: &Vec<usize>| listed.len() > MOST_COUNTED && *listed == all;
            let knowns = knowns.resolve(row, i, initially)?;
            let knowns = knowns.filter(|listed| !is_all(listed));
            let knowns = knowns.map(|knowns| listed(knowns.iter().map(|k| k + 1)));
            Ok(Element::new("Unknown")
                .with([("index", index.to_string())])
                .with(knowns.map(|knowns| ("dependencies", knowns))))
        });
        let unknowns = unknowns.collect::<Result<Vec<_>, String>>()?;
        Ok::<_, String>(Element::new(element).holding(unknowns).if_any())
    };
    Ok(Element::new("ModelStructure")
        .holding(unknowns("Outputs", false)?)
        .holding(unknowns("Derivatives", false)?)
        .holding(unknowns("InitialUnknowns", true)?))
}
