//! Setting parameters for `fmi2` and `fmi3`, including String ones that set others (from a file).
//!
//! The result does not depend on the order of setting: start values, overridden by what each text
//! sets, overridden by every value that was set explicitly. Importers write start values back, so a
//! value equal to its start value, before the end of initialization, is not explicit: the text's
//! value is kept, and a warning is logged.

use super::fault::{Fault, discard, refuse};
use super::instance::{Instance, collect_log, collect_messages, set_log_filter};
use super::layout::Layout;
use super::message::Kind;
use super::model::Variable;
use super::parameter_file::Reading;
use super::phase::Phase;
use super::state::Setting;
use super::storage::{self, AnyValue, Storage, each};
use super::value::{Value, allowed};
use crate::Model;

/// A message about the first parameter with a value that is not allowed.
pub(crate) fn out_of_bounds<M: Model>(layout: &Layout<M>, p: &M::Parameters) -> Option<String> {
    layout.iter().find_map(|(i, row)| {
        each!(Values, row.storage.parameter_values(p)?, |values| {
            let value = &values[i];
            (!value.is_allowed(row)).then(|| {
                let (name, allowed) = (row.element_name(i), allowed(row));
                format!("`{name}` = {value} must be {allowed}")
            })
        })
    })
}

/// The bits of element `i` of a parameter.
fn bits<M: Model>(row: &Variable<M>, p: &M::Parameters, i: usize) -> Vec<u8> {
    let mut bits = Vec::new();
    if let Some(values) = row.storage.parameter_values(p) {
        each!(Values, values, |values| values[i].write_bytes(&mut bits));
    }
    bits
}

impl<M: Model> Instance<M> {
    /// Writes the parameters of a checked batch; a running model is tuned.
    #[cold]
    #[inline(never)]
    pub(crate) fn set_parameters(
        &mut self,
        pair: &dyn Fn(usize) -> Option<(u32, AnyValue)>,
    ) -> Result<(), Fault> {
        let is_running = self.state.phase.is_running();
        let mut parameters = self.state.parameters.clone();
        let mut settings = self.state.settings.clone();
        let mut texts_read = false;
        for (element, value) in (0..).map_while(pair) {
            let (i, row) = self.layout.find(element)?;
            if !row.storage.put_parameter(&mut parameters, i, value) {
                continue;
            }
            let is_start = !is_running && bits(row, &parameters, i) == bits(row, &self.start, i);
            texts_read |= row.read_by_string_setters;
            settings[self.layout.slot(element)] = if is_start {
                Setting::Start
            } else {
                Setting::Explicit
            };
        }
        match self.state.phase {
            Phase::Configuration => self.configure(parameters),
            _ => self.take_parameters(parameters, settings, texts_read),
        }
    }

    /// Adopts parameters; `texts_read` says that a parameter was set that String setters read.
    fn take_parameters(
        &mut self,
        mut parameters: M::Parameters,
        settings: Vec<Setting>,
        texts_read: bool,
    ) -> Result<(), Fault> {
        if let (true, Some(model)) = (self.state.phase.is_running(), &mut self.state.model) {
            set_log_filter(self.log_filter, model);
            if let Err(error) = model.tune(&parameters) {
                collect_log(&mut self.messages, model);
                return Err(error.into());
            }
            collect_messages(&mut self.messages, model);
        } else if texts_read || settings.contains(&Setting::Start) {
            let texts = self.texts(&parameters, &settings);
            parameters = self.composed(&texts, &parameters, &settings)?;
        }
        self.state.parameters = parameters;
        self.state.settings = settings;
        self.invalidate_inputs(true);
        Ok(())
    }

    /// Sets texts: pairs of element and text, for String parameters with and without setters.
    pub(crate) fn set_texts(&mut self, values: Vec<(u32, String)>) -> Result<(), Fault> {
        let (mut texts, mut plain) = (Vec::new(), Vec::new());
        for (element, value) in values {
            let (i, row) = self.layout.find(element)?;
            match &row.storage {
                Storage::Text(..) if !self.state.phase.is_running() => texts.push((element, value)),
                Storage::StringIn(_) | Storage::StringParameter(_) => plain.push((element, value)),
                _ => {
                    let kind = storage::Kind::String;
                    return Err(self.not_settable(row, i, &value.to_message(), kind));
                }
            }
        }
        let plain = |k: usize| plain.get(k).cloned();
        match &texts[..] {
            [] => self.set(plain),
            texts => {
                let before = self.snapshot();
                let done = self.set_meaning(texts).and_then(|()| self.set(plain));
                done.inspect_err(|_| self.replace(before))
            }
        }
    }

    /// Sets String parameters with setters, which may set other parameters.
    fn set_meaning(&mut self, values: &[(u32, String)]) -> Result<(), Fault> {
        let mut settings = self.state.settings.clone();
        let mut texts = self.texts(&self.state.parameters, &settings);
        for (element, value) in values {
            let (_, row) = self.layout.find(*element)?;
            if let Storage::Text(get, _) = &row.storage {
                let is_start = value == get(&self.start);
                let slot = self.layout.slot(*element);
                texts[slot] = match is_start {
                    true => self.packed_texts.get(row.name).cloned(),
                    false => Some(value.clone()),
                };
                settings[slot] = if is_start {
                    Setting::Start
                } else {
                    Setting::Explicit
                };
            }
        }
        self.state.parameters = self.composed(&texts, &self.state.parameters.clone(), &settings)?;
        self.state.settings = settings;
        self.invalidate_inputs(true);
        Ok(())
    }

    /// The texts that were set explicitly, or that name edited files of the FMU, by
    /// [`Layout::slot`].
    pub(super) fn texts(&self, p: &M::Parameters, settings: &[Setting]) -> Vec<Option<String>> {
        let mut texts = vec![None; settings.len()];
        for (number, (_, row)) in self.layout.numbered() {
            if let Storage::Text(get, _) = &row.storage {
                let slot = self.layout.slot(number);
                texts[slot] = match settings[slot] {
                    Setting::Explicit => Some(get(p).to_owned()),
                    _ => self.packed_texts.get(row.name).cloned(),
                };
            }
        }
        texts
    }

    /// The result: start values, then what texts set, then explicit values from `numbers`.
    pub(super) fn composed(
        &mut self,
        texts: &[Option<String>],
        numbers: &M::Parameters,
        settings: &[Setting],
    ) -> Result<M::Parameters, Fault> {
        let mut parameters = self.start.clone();
        for (number, (i, row)) in self.layout.numbered() {
            if row.read_by_string_setters && settings[self.layout.slot(number)] == Setting::Explicit
            {
                row.storage.copy_parameter(i, numbers, &mut parameters);
            }
        }
        let mut sources = Vec::new();
        for (number, (_, row)) in self.layout.numbered() {
            if let (Storage::Text(_, set), Some(text)) =
                (&row.storage, &texts[self.layout.slot(number)])
            {
                let source = format!("`{}` = \"{text}\"", row.name);
                let is_packed = settings[self.layout.slot(number)] != Setting::Explicit;
                let reading = Reading::start(is_packed);
                let done = set(&mut parameters, text, self.resources.as_deref());
                drop(reading);
                if let Err(reason) = done {
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
            match settings[self.layout.slot(number)] {
                Setting::Explicit => row.storage.copy_parameter(i, numbers, &mut parameters),
                Setting::Start if bits(row, &self.start, i) != bits(row, &parameters, i) => {
                    let [start, value] = [&self.start, &parameters].map(|p| {
                        let values = row.storage.parameter_values(p);
                        values.map(|found| each!(Values, found, |all| all[i].to_message()))
                    });
                    overridden.push(format!(
                        "`{}` was set to its start value {}; the value {} from {} is kept",
                        self.name(row, i),
                        start.unwrap_or_default(),
                        value.unwrap_or_default(),
                        sources.join(", "),
                    ));
                }
                _ => {}
            }
        }
        for text in overridden {
            self.report(Kind::Warning, text);
        }
        Ok(parameters)
    }

    /// The text of an element.
    pub(crate) fn text(&mut self, element: u32) -> Result<&str, Fault> {
        let (i, row) = self.layout.find_any(element)?;
        match &row.storage {
            Storage::Text(get, _) => Ok(get(&self.state.parameters)),
            Storage::TextOut(get) => {
                self.update_output_for(row)?;
                Ok(get(&self.output))
            }
            _ => {
                let span = match self.layout.span(element) {
                    Err(unknown) if row.storage.kind() == storage::Kind::String => {
                        return Err(unknown);
                    }
                    found => found.map_err(|_| self.not_gettable(row, i, "String"))?,
                };
                Ok(&self.values::<String>(&span, i)?[i])
            }
        }
    }
}
