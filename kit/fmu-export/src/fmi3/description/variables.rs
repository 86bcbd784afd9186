//! The element `<ModelVariables>` of FMI 3.0, for `description`: time, and an array or scalar for
//! each row. A row of elements with different units becomes one scalar for each element.

use super::super::instance::NAMES;
use crate::Model;
use crate::c_api::description::{Element, real, type_attributes, variable};
use crate::core::causality::Causality;
use crate::core::layout::{Block, Layout, RowSpan, TIME};
use crate::core::length::Length;
use crate::core::model::Variable;
use crate::core::sizes::{self, StartValues};
use crate::core::storage::Kind;

pub(super) fn model_variables<M: Model>(layout: &Layout<M>, (p, u): &StartValues<M>) -> Element {
    let y = sizes::output::<M>(p);
    let time = Element::new("Float64").with([
        ("name", "time".to_owned()),
        ("valueReference", TIME.to_string()),
        ("description", "simulated time".to_owned()),
        ("causality", "independent".to_owned()),
        ("variability", "continuous".to_owned()),
    ]);
    let variables = layout.blocks().map(|(number, block)| {
        let (span, first, n) = block;
        let start = |i| span.row.start(p, u, &y, i);
        let state = layout.state_position(span.row, first);
        let state = state.map(|state| ("derivative", layout.block_at(state).0.to_string()));
        let starts = (first..first + n).map(start).collect();
        let previous = (span.row.previous).map(|name| ("previous", reference(layout, name)));
        block_variable(number, block, starts, dimensions(layout, &span))
            .with(state)
            .with(clocks(layout, span.row))
            .with(previous)
    });
    Element::new("ModelVariables")
        .holding([time])
        .holding(variables)
}

/// The element of a variable, with its start values if it has any.
fn block_variable<M: Model>(
    number: u32,
    (span, first, _): Block<M>,
    starts: Option<Vec<String>>,
    dimensions: Vec<(&'static str, String)>,
) -> Element {
    let row = span.row;
    let name = match span.is_array() {
        true => row.full_name(),
        false => row.element_name(first),
    };
    let element = row.type_name(&NAMES);
    let update = row.has_intermediate_update().then_some("true");
    let (_, initial) = row.causality_and_initial();
    let initial = initial.filter(|_| !row.storage.is_clock());
    let is_text = matches!(row.storage.kind(), Kind::String | Kind::Binary);
    let [texts, numbers] = match starts {
        Some(starts) if is_text => [starts, Vec::new()],
        starts => [Vec::new(), starts.unwrap_or_default()],
    };
    let start = (!numbers.is_empty()).then(|| ("start", numbers.join(" ")));
    let texts = texts.into_iter();
    variable(element, name, number, row)
        .with(update.map(|update| ("intermediateUpdate", update)))
        .with(initial.map(|initial| ("initial", initial)))
        .with(type_attributes(row, first))
        .with(start)
        .holding((dimensions.into_iter()).map(|length| Element::new("Dimension").with([length])))
        .holding(texts.map(|text| Element::new("Start").with([("value", text)])))
        .holding(row.by_aliases().map(|alias| {
            let name = match span.is_array() {
                true => alias.full_name(),
                false => alias.element_name(first),
            };
            Element::new("Alias").with([
                ("name", name),
                ("description", alias.description.to_owned()),
            ])
        }))
}

/// The number of the variable with this name.
fn reference<M: Model>(layout: &Layout<M>, name: &str) -> String {
    let number = (layout.blocks()).find(|(_, (span, ..))| span.row.name == name);
    number.map_or(0, |(number, _)| number).to_string()
}

/// The clocks that a variable belongs to, and the attributes of a variable that is a clock itself.
fn clocks<M: Model>(
    layout: &Layout<M>,
    row: &Variable<M>,
) -> impl Iterator<Item = (&'static str, String)> {
    let mut attributes = Vec::new();
    if M::CLOCKS.is_empty() {
        return attributes.into_iter();
    }
    let of = row.clocks.iter().map(|name| reference(layout, name));
    let of = Vec::from_iter(of).join(" ");
    if !of.is_empty() {
        attributes.push(("clocks", of));
    }
    let mut all = M::CLOCKS.iter().enumerate();
    let own = all.find(|(_, clock)| row.storage.is_clock() && clock.row.name == row.name);
    if let Some((priority, clock)) = own {
        attributes.push(("intervalVariability", clock.variability().to_owned()));
        attributes.extend((clock.interval()).map(|s| ("intervalDecimal", real(s))));
        if clock.shift > 0.0 {
            attributes.push(("shiftDecimal", real(clock.shift)));
        }
        if clock.is_input() {
            attributes.push(("canBeDeactivated", "true".to_owned()));
            attributes.push(("priority", priority.to_string()));
        }
    }
    attributes.into_iter()
}

/// The dimensions of an array: each a number, or the reference of a structural parameter.
fn dimensions<M: Model>(layout: &Layout<M>, span: &RowSpan<M>) -> Vec<(&'static str, String)> {
    let length = |length: &Length| match *length {
        Length::Fixed(n) => ("start", n.to_string()),
        Length::Parameter(name) => ("valueReference", reference(layout, name)),
    };
    match span.row.lengths() {
        _ if !span.is_array() => Vec::new(),
        [] => vec![("start", span.len().to_string())],
        shape => shape.iter().map(length).collect(),
    }
}

impl<M: Model> Variable<M> {
    /// Whether it can be read within steps: it is a continuous output.
    pub(crate) fn has_intermediate_update(&self) -> bool {
        self.causality == Causality::Output && self.variability() == "continuous"
    }
}
