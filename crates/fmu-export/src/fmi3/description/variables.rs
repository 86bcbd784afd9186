//! `<ModelVariables>`: time, and one variable for each row; a row whose elements have different
//! units is one for each element.

use super::super::instance::NAMES;
use crate::Model;
use crate::border::description::{Element, type_attributes, variable};
use crate::core::causality::Causality;
use crate::core::layout::{Block, Layout, TIME};
use crate::core::model::Variable;
use crate::core::place::Kind;

pub(super) fn of<M: Model>(layout: &Layout<M>) -> Element {
    let (parameters, input) = M::defaults();
    let output = M::Output::default();
    let time = Element::new("Float64").with([
        ("name", "time".to_owned()),
        ("valueReference", TIME.to_string()),
        ("description", "simulated time".to_owned()),
        ("causality", "independent".to_owned()),
        ("variability", "continuous".to_owned()),
    ]);
    let variables = layout.blocks().map(|(number, block)| {
        let (run, first, n) = block;
        let start = |i| run.row.start(&parameters, &input, &output, i);
        let state = layout.state_of(run.row, first);
        let state = state.map(|state| ("derivative", layout.block_at(state).0.to_string()));
        of_block(number, block, (first..first + n).map(start).collect()).with(state)
    });
    Element::new("ModelVariables")
        .holding([time])
        .holding(variables)
}

/// A variable, with its start values if it has any.
fn of_block<M: Model>(
    number: u32,
    (run, first, n): Block<M>,
    starts: Option<Vec<String>>,
) -> Element {
    let row = run.row;
    let name = match run.is_array() {
        true => row.full_name(),
        false => row.element_name(first),
    };
    let element = match row.enumeration {
        Some(_) => NAMES.enumeration,
        None => row.place.kind().name(&NAMES),
    };
    let update = row.has_intermediate_update().then_some("true");
    let (_, initial) = row.causality_and_initial();
    let is_text = row.place.kind() == Kind::String;
    let [texts, numbers] = match starts {
        Some(starts) if is_text => [starts, Vec::new()],
        starts => [Vec::new(), starts.unwrap_or_default()],
    };
    let start = (!numbers.is_empty()).then(|| ("start", numbers.join(" ")));
    let dimension = run.is_array().then_some(("start", n.to_string()));
    variable(element, name, number, row)
        .with(update.map(|update| ("intermediateUpdate", update)))
        .with(initial.map(|initial| ("initial", initial)))
        .with(type_attributes(row, first))
        .with(start)
        .holding(dimension.map(|start| Element::new("Dimension").with([start])))
        .holding(
            texts
                .into_iter()
                .map(|text| Element::new("Start").with([("value", text)])),
        )
}

impl<M: Model> Variable<M> {
    /// Whether it can be read within steps: what is continuous and for wiring.
    pub(crate) fn has_intermediate_update(&self) -> bool {
        self.causality == Causality::Output && self.variability() == "continuous"
    }
}
