//! `<ModelVariables>`.

use crate::Model;
use crate::border::description::{Element, type_attributes, variable};
use crate::core::layout::Layout;
use crate::core::place::Names;

pub(super) fn of<M: Model>(layout: &Layout<M>) -> Element {
    let (parameters, input) = M::defaults();
    let output = M::Output::default();
    Element::new("ModelVariables").holding(layout.numbered().map(|(number, (i, row))| {
        let element = match row.enumeration {
            Some(_) => "Enumeration",
            None => row.place.kind().name(&Names::PLAIN),
        };
        let state = layout.state_of(row, i);
        let start = row.start(&parameters, &input, &output, i);
        let (_, initial) = row.causality_and_initial();
        variable("ScalarVariable", row.element_name(i), number, row)
            .with(initial.map(|initial| ("initial", initial)))
            .holding([Element::new(element)
                .with(type_attributes(row, i))
                .with(state.map(|state| ("derivative", (state + 1).to_string())))
                .with(start.map(|start| ("start", start)))])
    }))
}
