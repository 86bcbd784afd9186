//! Setting and getting values by element, for `fmi2` and for strings and binary values in `fmi3`. A
//! batch is checked completely before anything is written.
//!
//! Consecutive elements of one row are read and written with one look-up of the row.

use super::causality::Causality;
use super::fault::Fault;
use super::instance::Instance;
use super::layout::RowSpan;
use super::model::Variable;
use super::phase::Phase;
use super::storage::Kind;
use super::value::{Value, allowed};
use crate::Model;
use std::fmt::Display;

impl<M: Model> Instance<M> {
    /// Sets elements: `pair(k)` is the number and value of the `k`-th; None ends the batch.
    #[inline]
    pub(crate) fn set<T: Value>(
        &mut self,
        pair: impl Fn(usize) -> Option<(u32, T)> + Copy,
    ) -> Result<(), Fault> {
        match self.set_one_row(pair)? {
            true => Ok(()),
            false => self.set_rows(pair),
        }
    }

    /// Sets elements of one row of inputs without derivatives, the usual batch; false for others.
    #[inline]
    fn set_one_row<T: Value>(
        &mut self,
        pair: impl Fn(usize) -> Option<(u32, T)> + Copy,
    ) -> Result<bool, Fault> {
        let span = pair(0).and_then(|(first, _)| self.layout.short_row(first));
        let held = span.filter(|span| span.row.counter.is_none() && self.state.is_held());
        let Some((span, field)) = held.and_then(|span| Some((span, T::input(&span.row.storage)?)))
        else {
            return Ok(false);
        };
        let mut k = 0;
        while let Some((element, value)) = pair(k) {
            let i = span.index(element);
            if i >= span.len() {
                return Ok(false);
            }
            if !value.is_within(span.bounds) {
                // A copy, so that the value stays in a register unless it is refused.
                return Err(self.not_allowed(span.row, i, &{ value }));
            }
            k += 1;
        }
        let inputs = &mut field.slice_mut(&mut self.state.input.value)[..span.len()];
        // Setting an input to its present value keeps the outputs valid.
        let (mut k, mut changed) = (0, false);
        while let Some((element, value)) = pair(k)
            && let Some(input) = inputs.get_mut(span.index(element))
        {
            changed |= !input.is_same(&value);
            *input = value;
            k += 1;
        }
        if changed {
            let row = span.row;
            self.invalidate_inputs(!row.not_in_evaluation);
        }
        Ok(true)
    }

    /// Sets elements of any rows.
    #[inline(never)]
    fn set_rows<T: Value>(
        &mut self,
        pair: impl Fn(usize) -> Option<(u32, T)> + Copy,
    ) -> Result<(), Fault> {
        let mut parameters = false;
        let mut k = 0;
        while let Some((element, value)) = pair(k) {
            let span = self.layout.span(element)?;
            if T::input(&span.row.storage).is_none() {
                self.check_settable(element, T::KIND, &|| value.to_message())?;
                parameters = true;
            }
            while let Some((element, value)) = pair(k) {
                let i = span.index(element);
                if i >= span.len() {
                    break;
                }
                if !value.is_within(span.bounds) {
                    return Err(self.not_allowed(span.row, i, &{ value }));
                }
                k += 1;
            }
        }
        if parameters {
            self.set_parameters(&|k| pair(k).map(|(element, value)| (element, value.into_any())))?;
        }
        self.set_inputs(pair)
    }

    /// Writes the inputs of a checked batch.
    #[inline]
    fn set_inputs<T: Value>(
        &mut self,
        pair: impl Fn(usize) -> Option<(u32, T)> + Copy,
    ) -> Result<(), Fault> {
        let is_held = self.state.is_held();
        // Setting an input to its present value keeps the outputs valid.
        let (mut is_changed, mut is_evaluated) = (false, false);
        let mut k = 0;
        while let Some((element, _)) = pair(k) {
            let span = self.layout.span(element)?;
            let Some(field) = T::input(&span.row.storage) else {
                k += 1;
                continue;
            };
            let inputs = &mut field.slice_mut(&mut self.state.input.value)[..span.len()];
            let (from, mut changed) = (k, !is_held);
            while let Some((element, value)) = pair(k)
                && let Some(input) = inputs.get_mut(span.index(element))
            {
                changed |= !input.is_same(&value);
                *input = value;
                k += 1;
            }
            if let Some(counter) = span.row.counter {
                self.state.count_sets(counter, (k - from) as u32);
                changed = true;
            }
            is_changed |= changed;
            is_evaluated |= changed && !span.row.not_in_evaluation;
        }
        if !is_held {
            self.end_derivatives(pair)?;
        }
        if is_changed {
            self.invalidate_inputs(is_evaluated);
        }
        Ok(())
    }

    /// Ends the derivatives of the inputs in a batch.
    #[cold]
    #[inline(never)]
    fn end_derivatives<T: Value>(
        &mut self,
        pair: impl Fn(usize) -> Option<(u32, T)>,
    ) -> Result<(), Fault> {
        for (element, value) in (0..).map_while(pair) {
            let (i, row) = self.layout.find(element)?;
            if let Some(field) = T::input(&row.storage) {
                self.state.end_derivatives(field, i, value);
            }
        }
        Ok(())
    }

    /// Refuses an element that is neither an input nor a parameter that can be set now.
    #[cold]
    #[inline(never)]
    pub(crate) fn check_settable(
        &self,
        element: u32,
        kind: Kind,
        value: &dyn Fn() -> String,
    ) -> Result<(), Fault> {
        let (i, row) = self.layout.find(element)?;
        match self.is_settable(row, kind) {
            true => Ok(()),
            false => Err(self.not_settable(row, i, &value(), kind)),
        }
    }

    /// Whether a row has this type, and is an input or a parameter that can be set now.
    #[cold]
    fn is_settable(&self, row: &Variable<M>, kind: Kind) -> bool {
        let is_open = match self.state.phase {
            Phase::Configuration => row.structural,
            phase => row.tunable || !(row.structural || phase.is_running()),
        };
        let storage = &row.storage;
        storage.kind() == kind && (storage.is_input() || storage.is_parameter() && is_open)
    }

    /// Name of an element; that of a matrix has its present dimensions.
    #[cold]
    pub(crate) fn name(&self, row: &Variable<M>, i: usize) -> String {
        let dimensions: Vec<_> = row.dimensions(&self.state.parameters).collect();
        row.name_in(&dimensions, i)
    }

    #[cold]
    pub(crate) fn not_allowed(&self, row: &Variable<M>, i: usize, value: &dyn Display) -> Fault {
        let (name, allowed) = (self.name(row, i), allowed(row));
        Fault::Discarded(format!("`{name}` = {value} must be {allowed}"))
    }

    #[cold]
    pub(crate) fn not_settable(
        &self,
        row: &Variable<M>,
        i: usize,
        value: &str,
        given: Kind,
    ) -> Fault {
        let (name, kind) = (self.name(row, i), row.kind(self.names));
        let reason = match row.causality {
            Causality::Output
            | Causality::Local
            | Causality::CalculatedParameter
            | Causality::Constant => "cannot be set; only inputs and parameters can".to_owned(),
            _ if row.storage.is_clock() => {
                "is not set as a value; fmi3SetClock activates it".to_owned()
            }
            _ if row.storage.kind() != given => {
                let (given, right) = (given.name(self.names), row.access(self.names));
                format!("cannot be set as {given}; it must be set as {right}")
            }
            _ if row.structural => "can only be set in Configuration Mode".to_owned(),
            _ if self.state.phase == Phase::Configuration => {
                "cannot be set in Configuration Mode; only structural parameters can".to_owned()
            }
            _ => {
                "cannot be set any more; it must be set before the end of initialization".to_owned()
            }
        };
        Fault::Refused(format!("`{name}` = {value}: {kind} {reason}"))
    }

    #[cold]
    pub(crate) fn not_gettable(&self, row: &Variable<M>, i: usize, given: &str) -> Fault {
        let (name, names) = (self.name(row, i), self.names);
        let (kind, right) = (row.kind(names), row.access(names));
        Fault::Refused(format!(
            "`{name}` is {kind} and cannot be read as {given}; it must be read as {right}"
        ))
    }

    /// Recomputes outdated outputs; before initialization, only constants have values.
    #[inline(always)]
    pub(super) fn update_output_for(&mut self, row: &Variable<M>) -> Result<(), Fault> {
        match self.state.phase {
            _ if self.output_is_valid => Ok(()),
            Phase::Instantiated => self.start_output(row),
            _ => Ok(self.update_output()?),
        }
    }

    /// All values of a row; `i` is the requested element, for messages.
    #[inline(always)]
    pub(super) fn values<T: Value>(&mut self, span: &RowSpan<M>, i: usize) -> Result<&[T], Fault> {
        let row = span.row;
        let values = if let Some(field) = T::output(&row.storage) {
            self.update_output_for(row)?;
            field.slice(&self.output)
        } else if let Some(field) = T::input(&row.storage) {
            field.slice(&self.state.input.value)
        } else if let Some(field) = T::parameter(&row.storage) {
            field.slice(&self.state.parameters)
        } else {
            self.equation_values(span, i)?
        };
        match values.get(..span.len()) {
            Some(values) => Ok(values),
            None => Err(not_as_long(row, values.len(), span.len())),
        }
    }

    /// Gets elements: `put(k, value)` receives the value of `element(k)`; None ends the batch.
    #[inline]
    pub(crate) fn get<T: Value>(
        &mut self,
        element: impl Fn(usize) -> Option<u32>,
        mut put: impl FnMut(usize, T),
    ) -> Result<(), Fault> {
        let mut k = 0;
        while let Some(first) = element(k) {
            let span = self.layout.span(first)?;
            let (row, values) = (span.row, self.values::<T>(&span, span.index(first))?);
            while let Some(element) = element(k)
                && let Some(value) = values.get(span.index(element))
            {
                if !value.is_finite() {
                    return Err(not_finite(row, span.index(element), value));
                }
                put(k, value.clone());
                k += 1;
            }
        }
        Ok(())
    }
}

/// The fault of a model's vector that is not as long as its row.
#[cold]
#[inline(never)]
pub(crate) fn not_as_long<M: Model>(row: &Variable<M>, found: usize, needed: usize) -> Fault {
    let name = row.name;
    Fault::Refused(format!(
        "`{name}` has {found} elements; it must have {needed}"
    ))
}

#[cold]
pub(crate) fn not_finite<M: Model>(row: &Variable<M>, i: usize, value: &dyn Display) -> Fault {
    let name = row.element_name(i);
    Fault::Refused(format!("`{name}` became {value}; it must be finite"))
}
