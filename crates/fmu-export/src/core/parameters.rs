//! Parameters: numbers set one by one, and texts that may set all of them.
//!
//! What is in force does not depend on the order of setting: it is the start values and the
//! explicit numbers that texts read, then what each text sets (a file, say), then every number that
//! was set explicitly. Importers write back start values without meaning anything by it, so before
//! the end of initialization a value equal to its start is not explicit: what a text sets stays in
//! force, and that is logged.

use super::fault::{Fault, discard, refuse};
use super::instance::{Instance, hear, listen, warn};
use super::layout::Layout;
use super::message::Kind;
use super::phase::Phase;
use super::place::{self, Place};
use super::state::Given;
use super::value::{Value, allowed};
use crate::Model;

/// Runs `$then` with the place of a parameter that is a number; None for other rows.
macro_rules! number {
    ($place:expr, |$number:ident| $then:expr) => {
        match $place {
            Place::RealParameter($number) => Some($then),
            Place::IntegerParameter($number) => Some($then),
            Place::BooleanParameter($number) => Some($then),
            _ => None,
        }
    };
}

/// The first parameter that is not finite, in its bounds and in its enumeration: its name, value,
/// and what it must be.
pub(crate) fn out_of_bounds<M: Model>(layout: &Layout<M>, p: &M::Parameters) -> Option<String> {
    layout.iter().find_map(|(i, row)| {
        number!(&row.place, |place| {
            let value = place.get(p, i);
            (!value.is_allowed(row)).then(|| {
                let (name, allowed) = (row.element_name(i), allowed(row));
                format!("`{name}` = {value} must be {allowed}")
            })
        })?
    })
}

impl<M: Model> Instance<M> {
    /// Writes the parameters of a checked batch, and tells a running model.
    #[cold]
    #[inline(never)]
    pub(crate) fn set_parameters<T: Value>(
        &mut self,
        pair: impl Fn(usize) -> Option<(u32, T)>,
    ) -> Result<(), Fault> {
        if self.state.phase == Phase::Configuration {
            return self.configure(pair);
        }
        let is_running = self.state.phase.is_running();
        let mut parameters = self.state.parameters.clone();
        let mut given = self.state.given.clone();
        let mut texts_read = false;
        for (element, value) in (0..).map_while(pair) {
            let (i, row) = self.layout.find(element)?;
            let Some(place) = T::parameter(&row.place) else {
                continue;
            };
            *place.get_mut(&mut parameters, i) = value;
            texts_read |= row.read_by_texts;
            let is_start = !is_running && value.is_same(place.get(&self.start, i));
            given[self.layout.slot(element)] = if is_start {
                Given::Start
            } else {
                Given::Explicit
            };
        }
        if let (true, Some(model)) = (is_running, &mut self.state.model) {
            listen(self.wanted, model);
            if let Err(error) = model.tune(&parameters) {
                hear(&mut self.messages, model);
                return Err(error.into());
            }
            warn(&mut self.messages, model);
        } else if texts_read || given.contains(&Given::Start) {
            let texts = self.texts(&parameters, &given);
            parameters = self.composed(&texts, &parameters, &given)?;
        }
        self.state.parameters = parameters;
        self.state.given = given;
        self.touch(true);
        Ok(())
    }

    /// Sets texts. `values` are pairs of element and text.
    pub(crate) fn set_texts(&mut self, values: &[(u32, &str)]) -> Result<(), Fault> {
        if values.is_empty() {
            return Ok(());
        }
        let mut given = self.state.given.clone();
        let mut texts = self.texts(&self.state.parameters, &given);
        for &(element, value) in values {
            let (i, row) = self.layout.find(element)?;
            match &row.place {
                Place::StringParameter(get, _) if !self.state.phase.is_running() => {
                    let is_start = value == get(&self.start);
                    let element = self.layout.slot(element);
                    texts[element] = (!is_start).then(|| value.to_owned());
                    given[element] = if is_start {
                        Given::Start
                    } else {
                        Given::Explicit
                    };
                }
                _ => {
                    return Err(self.not_settable(
                        row,
                        i,
                        format!("\"{value}\""),
                        place::Kind::String,
                    ));
                }
            }
        }
        self.state.parameters = self.composed(&texts, &self.state.parameters.clone(), &given)?;
        self.state.given = given;
        self.touch(true);
        Ok(())
    }

    /// By number: the texts that were set explicitly.
    fn texts(&self, p: &M::Parameters, given: &[Given]) -> Vec<Option<String>> {
        let mut texts = vec![None; given.len()];
        for (number, (_, row)) in self.layout.numbered() {
            if let Place::StringParameter(get, _) = &row.place
                && given[self.layout.slot(number)] == Given::Explicit
            {
                texts[self.layout.slot(number)] = Some(get(p).to_owned());
            }
        }
        texts
    }

    /// The parameters in force: start values, what the texts set, and the explicit numbers of
    /// `numbers`.
    fn composed(
        &mut self,
        texts: &[Option<String>],
        numbers: &M::Parameters,
        given: &[Given],
    ) -> Result<M::Parameters, Fault> {
        let mut parameters = self.start.clone();
        for (number, (i, row)) in self.layout.numbered() {
            if row.read_by_texts && given[self.layout.slot(number)] == Given::Explicit {
                number!(&row.place, |place| *place.get_mut(&mut parameters, i) =
                    place.get(numbers, i));
            }
        }
        let mut sources = Vec::new();
        for (number, (_, row)) in self.layout.numbered() {
            if let (Place::StringParameter(_, set), Some(text)) =
                (&row.place, &texts[self.layout.slot(number)])
            {
                let source = format!("`{}` = \"{text}\"", row.name);
                if let Err(reason) = set(&mut parameters, text, self.resources.as_deref()) {
                    return refuse!("{source}: {reason}");
                }
                if !self.has_sizes(&parameters) {
                    return refuse!("{source}: changes how many elements vectors have");
                }
                if let Some(reason) = out_of_bounds(&self.layout, &parameters) {
                    return discard!("{source}: {reason}");
                }
                sources.push(source);
            }
        }
        let mut overridden = Vec::new();
        for (number, (i, row)) in self.layout.numbered() {
            number!(&row.place, |place| {
                let (start, value) = (place.get(&self.start, i), place.get(&parameters, i));
                match given[self.layout.slot(number)] {
                    Given::Explicit => *place.get_mut(&mut parameters, i) = place.get(numbers, i),
                    Given::Start if !value.is_same(start) => overridden.push(format!(
                        "`{}` = {start}, its start value, was set; {value} from {} stays in force",
                        row.element_name(i),
                        sources.join(", "),
                    )),
                    _ => {}
                }
            });
        }
        for text in overridden {
            self.tell(Kind::Warning, text);
        }
        Ok(parameters)
    }

    /// The text of an element.
    pub(crate) fn text(&mut self, element: u32) -> Result<&str, Fault> {
        let (i, row) = self.layout.find_any(element)?;
        match &row.place {
            Place::StringParameter(get, _) => Ok(get(&self.state.parameters)),
            Place::StringOut(get) => {
                self.refresh_for(row)?;
                Ok(get(&self.output))
            }
            _ => Err(self.not_gettable(row, i, self.names.string)),
        }
    }
}
