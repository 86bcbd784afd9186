//! Maps numbers (value references) to elements of a model's table, for all that accesses or
//! describes variables. Elements are numbered over all rows: a scalar has one number, a vector one
//! for each element. A row may set its first number, so numbers may be skipped and need not ascend.
//!
//! A long row, and a row in a `Vec`, has only one number `r`, whatever its length; its elements
//! have numbers far above all others, from `(r + 1) << 20` on.

use super::fault::Fault;
use super::impl_copy::impl_copy;
use super::length::{LONGEST, MOST_COUNTED, Resize, SHIFT};
use super::model::{Model, ModelExchange, Variable, zero};
use super::storage::Storage;
use std::ops::Range;

/// An element: the index within its row, from 0, and the row.
pub(crate) type Element<M> = (usize, &'static Variable<M>);

/// Number of the variable `time` of FMI 3.0, which is not an element of the table.
pub(crate) const TIME: u32 = LARGEST_NUMBER + 1;

/// The consecutive elements of one row.
pub(crate) struct RowSpan<M: Model> {
    /// Number of the first element.
    first: u32,
    len: u32,
    is_array: bool,
    /// Position of a derivative's or indicator's first value among all of them.
    pub(crate) offset: u32,
    pub(crate) row: &'static Variable<M>,
    /// [`Variable::bounds`] of the row.
    pub(crate) bounds: [f64; 2],
}

impl_copy! { [M: Model] RowSpan<M>; }

impl<M: Model> RowSpan<M> {
    /// Index in the row of the element with this number; too large for an element of another row.
    #[inline]
    pub(crate) fn index(&self, number: u32) -> usize {
        number.wrapping_sub(self.first) as usize
    }

    /// Whether the row is an array: a vector whose elements have the same unit.
    #[inline]
    pub(crate) fn is_array(&self) -> bool {
        self.is_array
    }

    /// The number of elements.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.len as usize
    }

    /// The number of the row: that of its first element, unless it is a long row.
    pub(crate) fn number(&self) -> u32 {
        match self.is_long() {
            true => (self.first >> SHIFT) - 1,
            false => self.first,
        }
    }

    /// The largest number that the row can have.
    pub(crate) fn largest_number(&self) -> u32 {
        match self.is_long() {
            true => LARGEST_OF_LONG,
            false => LARGEST_NUMBER,
        }
    }

    fn is_long(&self) -> bool {
        self.first >> SHIFT > 0
    }

    /// The block that the number of an element stands for.
    #[inline]
    fn block_of(self, number: u32) -> Option<Block<M>> {
        match self.index(number) {
            i if !self.is_array => Some((self, i, 1)),
            0 => Some((self, 0, self.len())),
            _ => None,
        }
    }
}

/// The elements that one value reference of FMI 3.0 stands for: the row, the index of the first
/// element, and the number of elements. That is a whole row, or one element if units differ.
pub(crate) type Block<M> = (RowSpan<M>, usize, usize);

/// Largest number of an element that a row may set.
pub(crate) const LARGEST_NUMBER: u32 = u16::MAX as u32;
/// Largest number of a long row.
pub(crate) const LARGEST_OF_LONG: u32 = (1 << (u32::BITS - SHIFT)) - 3;

/// The elements of a table, by number and in the order of the table.
pub(crate) struct Layout<M: Model> {
    /// Rows by the number of each element; None for unused numbers.
    by_number: Vec<Option<RowSpan<M>>>,
    /// All rows in the order of the table, with the position of the first element.
    rows: Vec<(usize, RowSpan<M>)>,
    /// The long rows, with the number of elements of the long rows before.
    long: Vec<(usize, RowSpan<M>)>,
    /// Number of continuous states for Model Exchange.
    pub(crate) states: usize,
    /// Number of event indicators.
    pub(crate) indicators: usize,
}

/// The row of a state, by its name.
pub(crate) fn state<M: Model>(name: &str) -> Option<&'static Variable<M>> {
    M::variables().iter().find(|row| row.name == name)
}

impl<M: Model> Layout<M> {
    /// The layout for these start values, which determine the number of elements of each row.
    pub(crate) fn new(parameters: &M::Parameters, input: &M::Input) -> Self {
        let output = M::Output::default();
        let mut layout = Self {
            by_number: Vec::new(),
            rows: Vec::new(),
            long: Vec::new(),
            states: 0,
            indicators: 0,
        };
        let (mut next, mut position, mut in_long, mut offset) = (0, 0, 0, 0);
        let mut was_equation = false;
        let rows = M::variables().iter().chain(ModelExchange::<M>::rows());
        for row in rows.chain(M::CLOCKS.iter().map(|clock| &clock.row)) {
            let is_equation = row.storage.is_equation();
            let owner = match row.storage {
                Storage::Derivative => state(row.name).unwrap_or(row),
                _ => row,
            };
            let len = owner.len(parameters, input, &output).min(LONGEST);
            // The first equation and clocks follow all variables, unless they set their numbers.
            let follows_all = is_equation && !was_equation || row.storage.is_clock();
            let following = match follows_all {
                true => layout.len() as u32,
                false => next,
            };
            was_equation = is_equation;
            let number = row.at.unwrap_or(following);
            let is_long = owner.resize.is_some() || len > MOST_COUNTED;
            let counted = if is_long { 1 } else { len as u32 };
            next = number.saturating_add(counted);
            let span = RowSpan {
                first: match is_long {
                    true => number.saturating_add(1).min(LARGEST_OF_LONG + 2) << SHIFT,
                    false => number,
                },
                len: len as u32,
                is_array: !owner.scalar
                    && owner.each_unit.windows(2).all(|pair| pair[0] == pair[1]),
                offset,
                row,
                bounds: row.bounds(),
            };
            match row.storage {
                Storage::Derivative => layout.states += len,
                _ if is_equation => layout.indicators += len,
                _ => {}
            }
            offset += if is_equation { len as u32 } else { 0 };
            layout.rows.push((position, span));
            position += len;
            if number > LARGEST_NUMBER {
                continue; // refused by the check of the table
            }
            if layout.by_number.len() < next as usize {
                layout.by_number.resize(next as usize, None);
            }
            if is_long {
                layout.long.push((in_long, span));
                in_long += len;
                continue;
            }
            for entry in &mut layout.by_number[number as usize..next as usize] {
                entry.get_or_insert(span);
            }
        }
        layout
    }

    /// One more than the largest number of a row.
    pub(crate) fn len(&self) -> usize {
        self.by_number.len()
    }

    /// Length of an array with one entry for each element.
    pub(crate) fn slots(&self) -> usize {
        let in_long = |(before, span): &(usize, RowSpan<M>)| before + span.len();
        self.len() + self.long.last().map_or(0, in_long)
    }

    /// Index of an element in an array with one entry for each element.
    pub(crate) fn slot(&self, number: u32) -> usize {
        match (self.long.iter()).find(|(_, span)| span.index(number) < span.len()) {
            Some((before, span)) => self.len() + before + span.index(number),
            None => number as usize,
        }
    }

    /// Whether there are rows in a `Vec`, whose length may change.
    #[inline]
    pub(crate) fn has_vectors(&self) -> bool {
        (self.long.iter()).any(|(_, span)| span.row.resize.is_some())
    }

    /// Zero inputs, with vectors as long as those of `like`.
    #[inline]
    pub(crate) fn zero(&self, like: &M::Input) -> M::Input {
        match self.has_vectors() {
            true => zero::<M>(like),
            false => M::Input::default(),
        }
    }

    /// Whether parameters and inputs are as long as the rows.
    pub(crate) fn fits(&self, p: &M::Parameters, u: &M::Input) -> bool {
        self.long.iter().all(|(_, span)| match span.row.resize {
            None | Some(Resize::Output(_)) => true,
            Some(_) => span.row.storage.len(p, u, &M::Output::default()) == span.len(),
        })
    }

    /// All elements in the order of the table.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Element<M>> {
        self.numbered().map(|(_, element)| element)
    }

    /// All elements in the order of the table, with their numbers.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (u32, Element<M>)> {
        (self.rows.iter()).flat_map(|&(_, span)| {
            (span.first..span.first + span.len)
                .map(move |number| (number, (span.index(number), span.row)))
        })
    }

    /// Elements for checks, with their positions: all of short rows, some of long rows.
    pub(crate) fn samples(&self) -> Vec<(usize, Element<M>)> {
        let some = |&(start, span): &(usize, RowSpan<M>)| {
            let last = span.len().saturating_sub(1);
            let is_tried = move |&i: &usize| !span.is_long() || [0, 1, last / 2, last].contains(&i);
            let tried = (0..span.len()).filter(is_tried);
            tried.map(move |i| (start + i, (i, span.row)))
        };
        self.rows.iter().flat_map(some).collect()
    }

    /// All rows in the order of the table, with the positions of their elements.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (Range<usize>, &'static Variable<M>)> {
        (self.rows.iter()).map(|&(start, span)| (start..start + span.len(), span.row))
    }

    /// Position of the first derivative of a state's row, or of an indicator, among all of them.
    pub(crate) fn offset(&self, of: &Variable<M>) -> usize {
        let is_it = |row: &Variable<M>| row.storage.is_equation() && row.name == of.name;
        let span = self.rows.iter().find(|(_, span)| is_it(span.row));
        span.map_or(0, |(_, span)| span.offset as usize)
    }

    /// The position of the variable, mostly a state, whose derivative is element `i` of a row.
    pub(crate) fn state_position(&self, row: &Variable<M>, i: usize) -> Option<usize> {
        let own = row.storage.is_derivative().then_some(row.name);
        let name = own.or(row.rate_of)?;
        let state = self.rows().find(|(_, state)| state.name == name)?;
        Some(state.0.start + i)
    }

    /// The block that a number stands for.
    #[inline]
    pub(crate) fn block(&self, number: u32) -> Result<Block<M>, Fault> {
        match self.short_row(number) {
            Some(span) => span.block_of(number).ok_or(Fault::Unknown(number)),
            None => self.long_block(number),
        }
    }

    #[cold]
    #[inline(never)]
    fn long_block(&self, number: u32) -> Result<Block<M>, Fault> {
        let span = (self.long.iter()).find(|(_, span)| span.number() == number);
        span.map_or(Err(Fault::Unknown(number)), |&(_, span)| {
            Ok((span, 0, span.len()))
        })
    }

    /// The short row that this number stands for as a whole, if it has `len` elements.
    #[inline]
    pub(crate) fn whole_row(&self, number: u32, len: usize) -> Option<&RowSpan<M>> {
        let span = self.short_row(number)?;
        let is_whole = number == span.first && len == span.len() && (span.is_array || len == 1);
        is_whole.then_some(span)
    }

    /// The long row with this number, if it has `len` elements.
    #[cold]
    #[inline(never)]
    pub(crate) fn long_row(&self, number: u32, len: usize) -> Option<RowSpan<M>> {
        let (span, _, n) = self.long_block(number).ok()?;
        (n == len && span.is_array).then_some(span)
    }

    /// All blocks in the order of the table, with their numbers.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = (u32, Block<M>)> {
        self.grouped(|span| span.is_array && span.len > 0)
    }

    /// All numbers in the order of the table: elements of short rows, and long rows.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (u32, Block<M>)> {
        self.grouped(RowSpan::is_long)
    }

    /// All elements in the order of the table, with rows as one block where `is_one` holds.
    fn grouped(&self, is_one: fn(&RowSpan<M>) -> bool) -> impl Iterator<Item = (u32, Block<M>)> {
        self.rows.iter().flat_map(move |&(_, span)| {
            let (blocks, len) = match is_one(&span) {
                true => (1, span.len()),
                false => (span.len, 1),
            };
            (0..blocks).map(move |i| (span.number() + i, (span, i as usize, len)))
        })
    }

    /// The numbers of the elements of a [`block`](Self::block).
    pub(crate) fn elements(&self, number: u32) -> Result<Range<u32>, Fault> {
        let (span, first, len) = self.block(number)?;
        let first = span.first + first as u32;
        Ok(first..first + len as u32)
    }

    /// The number of the block that contains the element at a position, and its index in it.
    pub(crate) fn block_at(&self, position: usize) -> (u32, usize) {
        let k = self.rows.partition_point(|(start, _)| *start <= position) - 1;
        let (start, span) = &self.rows[k];
        let i = position - start;
        match span.is_array() {
            true => (span.number(), i),
            false => (span.first + i as u32, 0),
        }
    }

    /// The row of the element with this number, unless it is a long row.
    #[inline]
    pub(crate) fn short_row(&self, number: u32) -> Option<&RowSpan<M>> {
        self.by_number.get(number as usize)?.as_ref()
    }

    /// The row of the element with this number.
    #[inline]
    pub(crate) fn span(&self, number: u32) -> Result<RowSpan<M>, Fault> {
        match self.short_row(number) {
            Some(span) => Ok(*span),
            None => self.long_span(number),
        }
    }

    #[cold]
    #[inline(never)]
    fn long_span(&self, number: u32) -> Result<RowSpan<M>, Fault> {
        let span = (self.long.iter()).find(|(_, span)| span.index(number) < span.len());
        span.map_or(Err(Fault::Unknown(number)), |&(_, span)| Ok(span))
    }

    /// The first element of the block with this number, or the element with it, for messages.
    pub(crate) fn find_any(&self, number: u32) -> Result<Element<M>, Fault> {
        let block = self.block(number).map(|(span, first, _)| (first, span.row));
        block.or_else(|_| self.find(number))
    }

    /// The element with this number.
    #[inline]
    pub(crate) fn find(&self, number: u32) -> Result<Element<M>, Fault> {
        let span = self.span(number)?;
        Ok((span.index(number), span.row))
    }
}
