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
use std::mem;

impl<M: Model> Instance<M> {
    /// Sets `n` elements: `element(k)` is to become `value(k)`.
    #[inline]
    pub(crate) fn set<T: Value>(
        &mut self,
        n: usize,
        element: impl Fn(usize) -> u32 + Copy,
        value: impl Fn(usize) -> T + Copy,
    ) -> Result<(), Fault> {
        let mut parameters = false;
        let mut k = 0;
        while k < n {
            let run = self.layout.run(element(k))?;
            if T::input(&run.row.place).is_none() {
                self.check_settable(element(k), value(k))?;
                parameters = true;
            }
            while let Some(i) = run.index(k, n, element) {
                let value = value(k);
                if !value.is_allowed(run.row) {
                    return Err(not_allowed(run.row, i, value));
                }
                k += 1;
            }
        }
        if parameters {
            self.set_parameters::<T>(n, element, value)?;
        }
        // Nothing is out of date if an input is set to what it is.
        let (mut is_changed, mut is_evaluated) = (false, false);
        let is_held = self.state.is_held();
        let mut k = 0;
        while k < n {
            let run = self.layout.run(element(k))?;
            let Some(place) = T::input(&run.row.place) else {
                k += 1;
                continue;
            };
            let inputs = place.slice_mut(&mut self.state.input.value);
            let (from, mut changed) = (k, !is_held);
            while let Some(i) = run.index(k, n, element) {
                let old = mem::replace(&mut inputs[i], value(k));
                changed |= !old.is_same(value(k));
                k += 1;
            }
            if !is_held {
                for k in from..k {
                    let (i, _) = self.layout.find(element(k))?;
                    self.state.end_derivatives(place, i, value(k));
                }
            }
            if let Some(counter) = run.row.counter {
                self.state.count_sets(counter, (k - from) as u32);
                changed = true;
            }
            is_changed |= changed;
            is_evaluated |= changed && !run.row.beside_evaluation;
        }
        if is_changed {
            self.touch(is_evaluated);
        }
        Ok(())
    }

    /// Refuses what is neither an input nor a parameter that can be set now.
    fn check_settable<T: Value>(&self, element: u32, value: T) -> Result<(), Fault> {
        let (i, row) = self.layout.find(element)?;
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
            Causality::Output
            | Causality::Local
            | Causality::CalculatedParameter
            | Causality::Constant => "cannot be set; only inputs and parameters can".to_owned(),
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
            let run = self.layout.run(element(k))?;
            let row = run.row;
            let values = if let Some(place) = T::output(&row.place) {
                self.refresh()?;
                place.slice(&self.output)
            } else if let Some(place) = T::input(&row.place) {
                place.slice(&self.state.input.value)
            } else if let Some(place) = T::parameter(&row.place) {
                place.slice(&self.state.parameters)
            } else {
                let (i, row) = self.layout.find(element(k))?;
                return Err(not_gettable(row, i, T::TYPE));
            };
            while let Some(i) = run.index(k, n, &element) {
                let value = values[i];
                if !value.is_finite() {
                    return Err(not_finite(row, i, value));
                }
                put(k, value);
                k += 1;
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
