//! The element `<ModelVariables>` for `description`: one `<ScalarVariable>` for each element, and
//! after them one for each alias, so that the order of the others is that of the table.

use crate::Model;
use crate::c_api::description::{Element, type_attributes, variable};
use crate::core::causality::Causality;
use crate::core::layout::Layout;
use crate::core::model::Variable;
use crate::core::sizes::{self, StartValues};
use crate::core::storage::TypeNames;

pub(super) fn model_variables<M: Model>(layout: &Layout<M>, (p, u): &StartValues<M>) -> Element {
    let y = sizes::output::<M>(p);
    // Called for variables and for aliases, and compiled once.
    let scalar: &dyn Fn(u32, usize, &Variable<M>) -> Element = &|number, i, row| {
        let element = match row.enumeration {
            Some(_) => "Enumeration",
            None => row.storage.kind().name(&TypeNames::PLAIN),
        };
        let state = layout.state_position(row, i);
        let (_, initial) = row.causality_and_initial();
        let start = row
            .start(p, u, &y, i)
            .filter(|_| initial != Some("calculated"));
        let dimensions: Vec<_> = row.dimensions(p).collect();
        variable("ScalarVariable", row.name_in(&dimensions, i), number, row)
            .with(initial.map(|initial| ("initial", initial)))
            .holding([Element::new(element)
                .with(type_attributes(row, i))
                .with(state.map(|state| ("derivative", (state + 1).to_string())))
                .with(start.map(|start| ("start", start)))])
    };
    let rows = || {
        // Clocks are time events.
        let elements = (layout.numbered()).filter(|(_, (_, row))| !row.storage.is_clock());
        elements.map(|(number, (i, row))| {
            // A size was chosen when the FMU was packed, and is a constant.
            let causality = match row.structural {
                true => Causality::Constant,
                false => row.causality,
            };
            (number, i, Variable { causality, ..*row })
        })
    };
    let aliases = rows().flat_map(|(number, i, row)| {
        Vec::from_iter(row.by_aliases().map(|row| scalar(number, i, &row)))
    });
    Element::new("ModelVariables")
        .holding(rows().map(|(number, i, row)| scalar(number, i, &row)))
        .holding(aliases)
}
