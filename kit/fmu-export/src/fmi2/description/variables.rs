//! The element `<ModelVariables>` for `description`: one `<ScalarVariable>` for each element.

use crate::Model;
use crate::c_api::description::{Element, type_attributes, variable};
use crate::core::causality::Causality;
use crate::core::layout::Layout;
use crate::core::model::Variable;
use crate::core::sizes::{self, StartValues};
use crate::core::storage::TypeNames;

pub(super) fn model_variables<M: Model>(layout: &Layout<M>, (p, u): &StartValues<M>) -> Element {
    let y = sizes::output::<M>(p);
    // Clocks are time events.
    let elements = (layout.numbered()).filter(|(_, (_, row))| !row.storage.is_clock());
    Element::new("ModelVariables").holding(elements.map(|(number, (i, row))| {
        // A size was chosen when the FMU was packed, and is a constant.
        let causality = if row.structural {
            Causality::Constant
        } else {
            row.causality
        };
        let row = &Variable { causality, ..*row };
        let element = match row.enumeration {
            Some(_) => "Enumeration",
            None => row.storage.kind().name(&TypeNames::PLAIN),
        };
        let state = layout.state_position(row, i);
        let start = row.start(p, u, &y, i);
        let (_, initial) = row.causality_and_initial();
        let dimensions: Vec<_> = row.dimensions(p).collect();
        variable("ScalarVariable", row.name_in(&dimensions, i), number, row)
            .with(initial.map(|initial| ("initial", initial)))
            .holding([Element::new(element)
                .with(type_attributes(row, i))
                .with(state.map(|state| ("derivative", (state + 1).to_string())))
                .with(start.map(|start| ("start", start)))])
    }))
}
