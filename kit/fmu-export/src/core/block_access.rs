//! Setting and getting Float64 variables for `fmi3`, where a row is one array (a block) with one
//! value reference. A batch is checked completely before anything is written.

use super::causality::Causality;
use super::element_access::{not_as_long, not_finite};
use super::fault::{Fault, OF_VARIABLES, check_number, refuse};
use super::instance::Instance;
use super::layout::TIME;
use super::model::Variable;
use super::phase::Phase;
use super::sizes;
use super::storage::{Accessor, AnyValue, Kind, StorageType};
use super::value::Value;
use crate::Model;

impl<M: Model> Instance<M> {
    /// Sets blocks: `number(k)` is the number of the `k`-th block, None ends the batch; `value(j)`
    /// is the `j`-th of all `len` values, which `all` iterates over.
    #[inline]
    pub(crate) fn set_blocks<I: Iterator<Item = f64>>(
        &mut self,
        number: impl Fn(usize) -> Option<u32> + Copy,
        len: usize,
        value: impl Fn(usize) -> f64 + Copy,
        all: impl Fn() -> I,
    ) -> Result<(), Fault> {
        if number(1).is_none()
            && let Some(number) = number(0)
        {
            if let Some(span) = self.layout.whole_row(number, len) {
                if let Some(field) = f64::input(&span.row.storage) {
                    return self.set_whole_input(span.row, span.bounds, field, len, value);
                }
            } else if let Some(span) = self.layout.long_row(number, len)
                && let Some(field) = f64::input(&span.row.storage)
                && all().fold(true, |ok, value| ok & value.is_within(span.bounds))
            {
                self.set_long_input(span.row, field, all());
                return Ok(());
            }
        }
        let mut parameters = false;
        let (mut k, mut from) = (0, 0);
        while let Some(block) = number(k) {
            let (span, first, n) = self.layout.block(block)?;
            if n > len - from {
                return too_few(len);
            }
            if f64::input(&span.row.storage).is_none() {
                let element = self.layout.elements(block)?.start;
                self.check_settable(element, Kind::Real, &|| value(from).to_message())?;
                parameters = true;
            }
            for j in 0..n {
                let value = value(from + j);
                if !value.is_within(span.bounds) {
                    return Err(self.not_allowed(span.row, first + j, &{ value }));
                }
            }
            (k, from) = (k + 1, from + n);
        }
        check_number("nValues", len, from, OF_VARIABLES)?;
        if parameters {
            self.set_parameter_blocks(&number, &|j, _| value(j).into_any())?;
        }
        self.set_input_blocks(number, value)
    }

    /// Checks and sets all elements of one input, the usual batch.
    #[inline]
    fn set_whole_input(
        &mut self,
        row: &Variable<M>,
        bounds: [f64; 2],
        field: &Accessor<M::Input, f64>,
        len: usize,
        value: impl Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        let inputs = &mut field.slice_mut(&mut self.state.input.value)[..len];
        let mut changed = row.counter.is_some();
        for (j, input) in inputs.iter().enumerate() {
            let value = value(j);
            if !value.is_within(bounds) {
                return Err(self.not_allowed(row, j, &{ value }));
            }
            changed |= !input.is_same(&value);
        }
        if !changed {
            return Ok(());
        }
        for (j, input) in inputs.iter_mut().enumerate() {
            *input = value(j);
        }
        if let Some(counter) = row.counter {
            self.state.count_sets(counter, len as u32);
        }
        self.invalidate_inputs(!row.not_in_evaluation);
        Ok(())
    }

    /// Sets all elements of one long input to checked values.
    fn set_long_input(
        &mut self,
        row: &Variable<M>,
        field: &Accessor<M::Input, f64>,
        all: impl Iterator<Item = f64>,
    ) {
        let (mut changed, mut sets) = (row.counter.is_some(), 0);
        let inputs = field.slice_mut(&mut self.state.input.value);
        for (input, value) in inputs.iter_mut().zip(all) {
            changed |= !input.is_same(&value);
            *input = value;
            sets += 1;
        }
        if let Some(counter) = row.counter {
            self.state.count_sets(counter, sets);
        }
        if changed {
            self.invalidate_inputs(!row.not_in_evaluation);
        }
    }

    /// Writes the inputs of a checked batch. FMI 3.0 has no input derivatives to reset.
    #[inline]
    fn set_input_blocks(
        &mut self,
        number: impl Fn(usize) -> Option<u32>,
        value: impl Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        let (mut is_changed, mut is_evaluated) = (false, false);
        let (mut k, mut from) = (0, 0);
        while let Some(block) = number(k) {
            let (span, first, n) = self.layout.block(block)?;
            if let Some(field) = f64::input(&span.row.storage) {
                let inputs = &mut field.slice_mut(&mut self.state.input.value)[first..first + n];
                let mut changed = false;
                for (j, input) in inputs.iter_mut().enumerate() {
                    let value = value(from + j);
                    changed |= !input.is_same(&value);
                    *input = value;
                }
                if let Some(counter) = span.row.counter {
                    self.state.count_sets(counter, n as u32);
                    changed = true;
                }
                is_changed |= changed;
                is_evaluated |= changed && !span.row.not_in_evaluation;
            }
            (k, from) = (k + 1, from + n);
        }
        if is_changed {
            self.invalidate_inputs(is_evaluated);
        }
        Ok(())
    }

    /// Writes the parameters of a checked batch; `value(j, kind)` is the `j`-th of all values, as
    /// the type in which its row stores it.
    #[cold]
    #[inline(never)]
    pub(super) fn set_parameter_blocks(
        &mut self,
        number: &dyn Fn(usize) -> Option<u32>,
        value: &dyn Fn(usize, Kind) -> AnyValue,
    ) -> Result<(), Fault> {
        let mut all = Vec::new();
        for block in (0..).map_while(number) {
            let stored = self.layout.block(block)?.0.row.storage.kind();
            all.extend((self.layout.elements(block)?).map(|element| (element, stored)));
        }
        self.set_parameters(&|k| {
            let &(element, stored) = all.get(k)?;
            Some((element, value(k, stored)))
        })
    }

    /// Gets blocks: `put(j, values)` receives the values of each block, the first of which is the
    /// `j`-th of all `len` values.
    #[inline]
    pub(crate) fn get_blocks(
        &mut self,
        number: impl Fn(usize) -> Option<u32>,
        len: usize,
        mut put: impl FnMut(usize, &[f64]),
    ) -> Result<(), Fault> {
        if number(1).is_none()
            && let Some(span) = number(0).and_then(|number| self.layout.whole_row(number, len))
            && let row = span.row
            && let Some(field) = f64::output(&row.storage)
            && self.state.phase != Phase::Instantiated
        {
            // All elements of one output, the usual batch.
            self.update_output()?;
            put(0, finite(row, field.slice(&self.output), 0, len)?);
            return Ok(());
        }
        let (mut k, mut from) = (0, 0);
        while let Some(block) = number(k) {
            k += 1;
            let (span, first, n) = match self.layout.block(block) {
                Ok(found) if found.2 <= len - from => found,
                Ok(_) => return too_few(len),
                Err(_) if block == TIME && from < len => {
                    put(from, &[self.state.time]);
                    from += 1;
                    continue;
                }
                Err(fault) => return Err(fault),
            };
            let values = self.values(&span, first)?;
            put(from, finite(span.row, values, first, n)?);
            from += n;
        }
        check_number("nValues", len, from, OF_VARIABLES)
    }

    /// Before initialization, constants are the only computed variables with values.
    #[cold]
    #[inline(never)]
    pub(crate) fn start_output(&mut self, row: &Variable<M>) -> Result<(), Fault> {
        if row.causality != Causality::Constant {
            let (name, kind) = (self.name(row, 0), row.kind(self.names));
            return refuse!("`{name}` is {kind} and has no value before initialization");
        }
        self.output = sizes::output::<M>(&self.state.parameters);
        self.output_is_valid = false;
        Ok(())
    }
}

/// `n` values of a row from `first` on, if they are finite.
#[inline]
fn finite<'a, M: Model>(
    row: &Variable<M>,
    values: &'a [f64],
    first: usize,
    n: usize,
) -> Result<&'a [f64], Fault> {
    let Some(values) = values.get(first..first + n) else {
        return Err(not_as_long(row, values.len(), n));
    };
    match f64::are_finite(values) {
        true => Ok(values),
        false => Err(none_finite(row, values, first)),
    }
}

#[cold]
#[inline(never)]
fn none_finite<M: Model>(row: &Variable<M>, values: &[f64], first: usize) -> Fault {
    let wrong = values.iter().position(|value| !value.is_finite());
    let k = wrong.expect("one is not finite");
    not_finite(row, first + k, &values[k])
}

#[cold]
#[inline(never)]
pub(super) fn too_few(len: usize) -> Result<(), Fault> {
    refuse!("nValues = {len} is less than the number of elements of these variables")
}
