//! Setting and getting numbers of any type but `f64` by block. All of them go one way, as bits, so
//! that a library has it once and not for each type. A batch is checked completely before anything
//! is written.
//!
//! Enumerations and sizes are integers of 32 bits in a model; where a border has them set and read
//! as longer ones, they are converted here.

use super::access::{not_as_long, not_finite};
use super::blocks::too_few;
use super::fault::{Fault, OF_VARIABLES, check_number, refuse};
use super::instance::Instance;
use super::model::Variable;
use super::place::{Kept, Kind, each, typed};
use super::value::Value;
use crate::Model;

impl Kind {
    fn is_of_integers(self) -> bool {
        matches!(self, Kind::Integer | Kind::Int64 | Kind::UInt64)
    }

    /// The number of these bits in a message.
    #[cold]
    fn shown(self, bits: u64) -> String {
        typed!(self, T => T::of_bits(bits).shown())
    }

    /// Whether the number of these bits is in the bounds, and fits where it is kept.
    fn is_allowed(self, bits: u64, bounds: [f64; 2], kept: Kind) -> bool {
        let fits = match self {
            _ if kept == self => true,
            Kind::UInt64 => i32::try_from(bits).is_ok(),
            _ => i32::try_from(bits.cast_signed()).is_ok(),
        };
        fits && typed!(self, T => T::of_bits(bits).is_within(bounds))
    }
}

impl<M: Model> Instance<M> {
    /// As what the numbers of a row are kept that are set and read as `kind`; None if they are not.
    fn kept(&self, row: &Variable<M>, kind: Kind) -> Option<Kind> {
        let is_right = row.access(self.names) == kind.name(self.names);
        is_right.then(|| row.place.kind())
    }

    /// Sets blocks of numbers of a kind: `number(k)` is that of the `k`-th block, None at the end of
    /// the batch; `bits(j)` are those of the `j`-th of all `len` values.
    #[inline(never)]
    pub(crate) fn set_numbers(
        &mut self,
        kind: Kind,
        number: &dyn Fn(usize) -> Option<u32>,
        len: usize,
        bits: &dyn Fn(usize) -> u64,
    ) -> Result<(), Fault> {
        let (mut parameters, mut from) = (false, 0);
        for block in (0..).map_while(number) {
            let (run, first, n) = self.layout.block(block)?;
            if n > len - from {
                return too_few(len);
            }
            let kept = self.kept(run.row, kind);
            if kept.is_none() && run.row.place.kind() == Kind::Integer && kind.is_of_integers() {
                return self.not_settable_as(block, kind.name(self.names));
            }
            let (element, kept) = (self.layout.elements(block)?.start, kept.unwrap_or(kind));
            self.check_settable(element, kept, &|| kind.shown(bits(from)))?;
            for j in 0..n {
                let bits = bits(from + j);
                if !kind.is_allowed(bits, run.bounds, kept) {
                    return Err(self.not_allowed(run.row, first + j, &kind.shown(bits)));
                }
            }
            parameters |= run.row.place.is_parameter();
            from += n;
        }
        check_number("nValues", len, from, OF_VARIABLES)?;
        if parameters {
            self.set_number_parameters(number, bits)?;
        }
        self.set_number_inputs(number, bits)
    }

    /// Writes what are parameters in a checked batch.
    #[cold]
    fn set_number_parameters(
        &mut self,
        number: &dyn Fn(usize) -> Option<u32>,
        bits: &dyn Fn(usize) -> u64,
    ) -> Result<(), Fault> {
        let mut all = Vec::new();
        for block in (0..).map_while(number) {
            let kept = self.layout.block(block)?.0.row.place.kind();
            for element in self.layout.elements(block)? {
                all.push((element, kept, bits(all.len())));
            }
        }
        self.set_parameters(&|k| {
            let &(element, kept, bits) = all.get(k)?;
            Some((element, typed!(kept, T => T::of_bits(bits).any())))
        })
    }

    /// Writes what are inputs in a checked batch.
    fn set_number_inputs(
        &mut self,
        number: &dyn Fn(usize) -> Option<u32>,
        bits: &dyn Fn(usize) -> u64,
    ) -> Result<(), Fault> {
        let (mut is_changed, mut is_evaluated, mut from) = (false, false, 0);
        for block in (0..).map_while(number) {
            let (run, first, n) = self.layout.block(block)?;
            let mut changed = run.row.counter.is_some();
            if let Some(inputs) = run.row.place.input_values_mut(&mut self.state.input.value) {
                each!(ValuesMut, inputs, |inputs| {
                    for (j, input) in inputs[first..first + n].iter_mut().enumerate() {
                        let value = Value::of_bits(bits(from + j));
                        changed |= !input.is_same(&value);
                        *input = value;
                    }
                });
                if let Some(counter) = run.row.counter {
                    self.state.count_sets(counter, n as u32);
                }
                is_changed |= changed;
                is_evaluated |= changed && !run.row.beside_evaluation;
            }
            from += n;
        }
        if is_changed {
            self.touch(is_evaluated);
        }
        Ok(())
    }

    /// Gets blocks of numbers of a kind: `put(j, bits)` receives those of the `j`-th of all `len`
    /// values.
    #[inline(never)]
    pub(crate) fn get_numbers(
        &mut self,
        kind: Kind,
        number: &dyn Fn(usize) -> Option<u32>,
        len: usize,
        put: &mut dyn FnMut(usize, u64),
    ) -> Result<(), Fault> {
        let mut from = 0;
        for block in (0..).map_while(number) {
            let (run, first, n) = self.layout.block(block)?;
            if n > len - from {
                return too_few(len);
            }
            let row = run.row;
            if self.kept(row, kind).is_none() {
                return Err(self.not_gettable(row, first, kind.name(self.names)));
            }
            if row.place.is_computed() {
                self.refresh_for(row)?;
            }
            let state = &self.state;
            let values = (row.place).values(&state.parameters, &state.input.value, &self.output);
            let Some(values) = values else { continue };
            each!(Values, values, |values| {
                let Some(values) = values.get(first..first + n) else {
                    return Err(not_as_long(row, values.len(), n));
                };
                for (j, value) in values.iter().enumerate() {
                    if !value.is_finite() {
                        return Err(not_finite(row, first + j, value));
                    }
                    put(from + j, value.bits());
                }
            });
            from += n;
        }
        check_number("nValues", len, from, OF_VARIABLES)
    }

    /// Refuses to set a row as a type that it is not of.
    #[cold]
    pub(crate) fn not_settable_as(&self, number: u32, name: &str) -> Result<(), Fault> {
        let (run, first, _) = self.layout.block(number)?;
        let (variable, kind) = (self.name(run.row, first), run.row.kind(self.names));
        let right = run.row.access(self.names);
        refuse!("`{variable}` is {kind} and cannot be set as {name}; it must be set as {right}")
    }
}
