//! Setting and getting numbers other than Float64, by block, for `fmi3`. All types share one
//! implementation, which works on bytes, to keep libraries small. A batch is checked completely
//! before anything is written.
//!
//! Models store enumerations and sizes as 32-bit integers; FMI 3.0 sets and reads them with 64
//! bits, which is converted here.

use super::block_access::too_few;
use super::element_access::{not_as_long, not_finite};
use super::fault::{Fault, OF_VARIABLES, check_number, refuse};
use super::instance::Instance;
use super::model::Variable;
use super::storage::{Kind, StorageType, each, typed};
use super::value::Value;
use crate::Model;

/// An array of numbers of one type, as C passes it.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<'a> {
    kind: Kind,
    size: usize,
    bytes: &'a [u8],
}

impl<'a> Numbers<'a> {
    /// The numbers in `bytes`, which are little-endian.
    pub(crate) fn new(kind: Kind, bytes: &'a [u8]) -> Self {
        let size = typed!(kind, T => size_of::<T>());
        Self { kind, size, bytes }
    }

    fn len(self) -> usize {
        self.bytes.len() / self.size
    }

    /// `n` numbers from `first` on.
    fn part(self, first: usize, n: usize) -> Self {
        let bytes = &self.bytes[first * self.size..(first + n) * self.size];
        Self { bytes, ..self }
    }

    fn bits(self, j: usize) -> u64 {
        bits(&self.bytes[j * self.size..(j + 1) * self.size])
    }

    /// The `j`-th number, for a message.
    #[cold]
    fn to_message(self, j: usize) -> String {
        typed!(self.kind, T => T::from_raw_bits(self.bits(j)).to_message())
    }

    /// All numbers, whose type is `T`.
    fn all<T: Value>(self) -> impl Iterator<Item = T> {
        let numbers = self.bytes.chunks_exact(size_of::<T>());
        numbers.map(|bytes| T::from_raw_bits(bits(bytes)))
    }

    /// The first number that is out of bounds or does not fit into the type in which it is stored.
    fn first_invalid(self, bounds: [f64; 2], stored: Kind) -> Option<usize> {
        typed!(self.kind, T => {
            let is_right = |value: T| value.is_within(bounds);
            if stored != self.kind {
                let fits = |bits: u64| match self.kind {
                    Kind::UInt64 => i32::try_from(bits).is_ok(),
                    _ => i32::try_from(bits.cast_signed()).is_ok(),
                };
                let is_right = |bits| fits(bits) && is_right(T::from_raw_bits(bits));
                return (0..self.len()).find(|&j| !is_right(self.bits(j)));
            }
            // Without a branch for each number.
            if self.all().fold(true, |all, value| all & is_right(value)) {
                return None;
            }
            self.all().position(|value| !is_right(value))
        })
    }

    /// Writes all numbers to `to`; returns whether that changes anything.
    fn write<T: Value>(self, to: &mut [T]) -> bool {
        let mut changed = false;
        let put = |(to, value): (&mut T, T)| {
            changed |= !to.is_same(&value);
            *to = value;
        };
        match T::KIND == self.kind {
            true => to.iter_mut().zip(self.all()).for_each(put),
            false => {
                let values = (0..self.len()).map(|j| T::from_raw_bits(self.bits(j)));
                to.iter_mut().zip(values).for_each(put);
            }
        }
        changed
    }
}

/// The bits of a number of at most eight bytes.
#[inline]
fn bits(bytes: &[u8]) -> u64 {
    let mut all = [0; 8];
    all[..bytes.len()].copy_from_slice(bytes);
    u64::from_le_bytes(all)
}

/// Number of values that are passed to `put` at once.
const PIECE: usize = 128;

/// Converts values to numbers of a type; `put` receives the index of the first and the bytes.
fn hand_out<T: Value>(values: &[T], kind: Kind, put: &mut dyn FnMut(usize, &[u8])) {
    let mut piece = [0; 8 * PIECE];
    for (k, values) in values.chunks(PIECE).enumerate() {
        let fill = |(to, value): (&mut [u8], &T)| {
            to.copy_from_slice(&value.bits().to_le_bytes()[..to.len()]);
        };
        let size = match T::KIND == kind {
            true => {
                let chunks = piece.chunks_exact_mut(size_of::<T>());
                chunks.zip(values).for_each(fill);
                size_of::<T>()
            }
            false => {
                piece.chunks_exact_mut(8).zip(values).for_each(fill);
                8
            }
        };
        put(k * PIECE, &piece[..values.len() * size]);
    }
}

impl<M: Model> Instance<M> {
    /// The type in which a row stores its numbers, if they are set and read as `kind`.
    fn stored_kind(&self, row: &Variable<M>, kind: Kind) -> Option<Kind> {
        let is_right = row.access(self.names) == kind.name(self.names);
        is_right.then(|| row.storage.kind())
    }

    /// Sets blocks of numbers: `number(k)` is the number of the `k`-th block; None ends the batch.
    #[inline(never)]
    pub(crate) fn set_numbers(
        &mut self,
        number: &dyn Fn(usize) -> Option<u32>,
        all: Numbers,
    ) -> Result<(), Fault> {
        let (kind, len) = (all.kind, all.len());
        let (mut parameters, mut from) = (false, 0);
        for block in (0..).map_while(number) {
            let (span, first, n) = self.layout.block(block)?;
            if n > len - from {
                return too_few(len);
            }
            let stored = self.stored_kind(span.row, kind);
            if stored.is_none() && span.row.storage.kind() == kind {
                return self.not_settable_as(block, kind.name(self.names));
            }
            let (element, stored) = (self.layout.elements(block)?.start, stored.unwrap_or(kind));
            self.check_settable(element, stored, &|| all.to_message(from))?;
            if let Some(j) = all.part(from, n).first_invalid(span.bounds, stored) {
                return Err(self.not_allowed(span.row, first + j, &all.to_message(from + j)));
            }
            parameters |= span.row.storage.is_parameter();
            from += n;
        }
        check_number("nValues", len, from, OF_VARIABLES)?;
        if parameters {
            let value = |j, stored| typed!(stored, T => T::from_raw_bits(all.bits(j)).into_any());
            self.set_parameter_blocks(number, &value)?;
        }
        self.set_number_inputs(number, all)
    }

    /// Writes the inputs of a checked batch.
    fn set_number_inputs(
        &mut self,
        number: &dyn Fn(usize) -> Option<u32>,
        all: Numbers,
    ) -> Result<(), Fault> {
        let (mut is_changed, mut is_evaluated, mut from) = (false, false, 0);
        for block in (0..).map_while(number) {
            let (span, first, n) = self.layout.block(block)?;
            let mut changed = span.row.counter.is_some();
            let input = &mut self.state.input.value;
            if let Some(inputs) = span.row.storage.input_values_mut(input) {
                let given = all.part(from, n);
                each!(ValuesMut, inputs, |inputs| {
                    changed |= given.write(&mut inputs[first..first + n]);
                });
                if let Some(counter) = span.row.counter {
                    self.state.count_sets(counter, n as u32);
                }
                is_changed |= changed;
                is_evaluated |= changed && !span.row.not_in_evaluation;
            }
            from += n;
        }
        if is_changed {
            self.invalidate_inputs(is_evaluated);
        }
        Ok(())
    }

    /// Gets blocks of numbers of a type: `put(j, bytes)` receives the bytes of values, the first of
    /// which is the `j`-th of all `len` values.
    #[inline(never)]
    pub(crate) fn get_numbers(
        &mut self,
        kind: Kind,
        number: &dyn Fn(usize) -> Option<u32>,
        len: usize,
        put: &mut dyn FnMut(usize, &[u8]),
    ) -> Result<(), Fault> {
        let mut from = 0;
        for block in (0..).map_while(number) {
            let (span, first, n) = self.layout.block(block)?;
            if n > len - from {
                return too_few(len);
            }
            let row = span.row;
            if self.stored_kind(row, kind).is_none() {
                return Err(self.not_gettable(row, first, kind.name(self.names)));
            }
            if row.storage.is_computed() {
                self.update_output_for(row)?;
            }
            let state = &self.state;
            let values = (row.storage).values(&state.parameters, &state.input.value, &self.output);
            let Some(values) = values else { continue };
            each!(Values, values, |values| {
                let Some(values) = values.get(first..first + n) else {
                    return Err(not_as_long(row, values.len(), n));
                };
                if let Some(j) = values.iter().position(|value| !value.is_finite()) {
                    return Err(not_finite(row, first + j, &values[j]));
                }
                hand_out(values, kind, &mut |j, bytes| put(from + j, bytes));
            });
            from += n;
        }
        check_number("nValues", len, from, OF_VARIABLES)
    }

    /// Refuses to set a row as a type that it does not have.
    #[cold]
    pub(crate) fn not_settable_as(&self, number: u32, name: &str) -> Result<(), Fault> {
        let (span, first, _) = self.layout.block(number)?;
        let (variable, kind) = (self.name(span.row, first), span.row.kind(self.names));
        let right = span.row.access(self.names);
        refuse!("`{variable}` is {kind} and cannot be set as {name}; it must be set as {right}")
    }
}
