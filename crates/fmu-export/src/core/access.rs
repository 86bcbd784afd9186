//! Setting and getting numbers by element. A batch is checked completely before anything is written.
//!
//! Elements of one row that follow each other are read and written through one look at the row.

use super::fault::Fault;
use super::instance::Instance;
use super::phase::Phase;
use super::value::{Value, allowed};
use super::variable::{Causality, Variable};
use crate::Model;
use std::fmt::Display;
use std::ptr;

impl<M: Model> Instance<M> {
    /// Sets `n` elements: `element(k)` is to become `value(k)`.
    #[inline]
    pub(crate) fn set<T: Value>(
        &mut self,
        n: usize,
        element: impl Fn(usize) -> u32,
        value: impl Fn(usize) -> T,
    ) -> Result<(), Fault> {
        let mut parameters = false;
        for k in 0..n {
            let (i, row) = self.layout.find(element(k))?;
            let value = value(k);
            if T::input(&row.place).is_none() {
                self.check_settable::<T>(row, i, value)?;
                parameters = true;
            }
            if !value.is_allowed(row) {
                return Err(not_allowed(row, i, value));
            }
        }
        if parameters {
            self.set_parameters::<T>(n, &element, &value)?;
        }
        // Nothing is out of date if an input is set to what it is.
        let (mut is_changed, mut is_evaluated) = (false, false);
        let mut k = 0;
        while k < n {
            let (mut i, row) = self.layout.find(element(k))?;
            let Some(place) = T::input(&row.place) else {
                k += 1;
                continue;
            };
            let mut inputs = self.state.input_row(place);
            let mut sets = 0;
            loop {
                let changed = inputs.set(i, value(k)) || row.counter.is_some();
                sets += 1;
                is_changed |= changed;
                is_evaluated |= changed && !row.beside_evaluation;
                k += 1;
                match self.layout.get(k, n, &element) {
                    Some((next, same)) if ptr::eq(same, row) => i = next,
                    _ => break,
                }
            }
            if let Some(counter) = row.counter {
                self.state.count_sets(counter, sets);
            }
        }
        if is_changed {
            self.touch(is_evaluated);
        }
        Ok(())
    }

    /// Refuses what is neither an input nor a parameter that can be set now.
    fn check_settable<T: Value>(&self, row: &Variable<M>, i: usize, value: T) -> Result<(), Fault> {
        let is_open = row.tunable || self.state.phase != Phase::Stepping;
        if T::parameter(&row.place).is_some() && is_open {
            return Ok(());
        }
        Err(self.not_settable(row, i, value, T::TYPE))
    }

    #[cold]
    pub(crate) fn not_settable(
        &self,
        row: &Variable<M>,
        i: usize,
        value: impl Display,
        given: &str,
    ) -> Fault {
        let (name, kind) = (row.element_name(i), row.kind());
        let right = row.place.type_name();
        let reason = match row.causality {
            Causality::Output | Causality::Local => {
                "cannot be set; only inputs and parameters can".to_owned()
            }
            _ if right != given => {
                format!("cannot be set as {given}; it must be set as {right}")
            }
            _ => {
                "cannot be set any more; it must be set before the end of initialization".to_owned()
            }
        };
        Fault::Refused(format!("`{name}` = {value}: {kind} {reason}"))
    }

    /// Gets `n` elements: `put(k, value)` receives the value of `element(k)`.
    #[inline]
    pub(crate) fn get<T: Value>(
        &mut self,
        n: usize,
        element: impl Fn(usize) -> u32,
        mut put: impl FnMut(usize, T),
    ) -> Result<(), Fault> {
        let mut k = 0;
        while k < n {
            let (mut i, row) = self.layout.find(element(k))?;
            let values = if let Some(place) = T::output(&row.place) {
                self.refresh()?;
                place.slice(&self.output)
            } else if let Some(place) = T::input(&row.place) {
                place.slice(&self.state.input.value)
            } else if let Some(place) = T::parameter(&row.place) {
                place.slice(&self.state.parameters)
            } else {
                return Err(not_gettable(row, i, T::TYPE));
            };
            loop {
                let value = values[i];
                if !value.is_finite() {
                    return Err(not_finite(row, i, value));
                }
                put(k, value);
                k += 1;
                match self.layout.get(k, n, &element) {
                    Some((next, same)) if ptr::eq(same, row) => i = next,
                    _ => break,
                }
            }
        }
        Ok(())
    }
}

#[cold]
pub(crate) fn not_allowed<M: Model>(row: &Variable<M>, i: usize, value: impl Display) -> Fault {
    let (name, allowed) = (row.element_name(i), allowed(row));
    Fault::Discarded(format!("`{name}` = {value} must be {allowed}"))
}

#[cold]
fn not_finite<M: Model>(row: &Variable<M>, i: usize, value: impl Display) -> Fault {
    let name = row.element_name(i);
    Fault::Refused(format!("`{name}` became {value}; it must be finite"))
}

#[cold]
pub(crate) fn not_gettable<M: Model>(row: &Variable<M>, i: usize, given: &str) -> Fault {
    let (name, kind, right) = (row.element_name(i), row.kind(), row.place.type_name());
    Fault::Refused(format!(
        "`{name}` is {kind} and cannot be read as {given}; it must be read as {right}"
    ))
}
