//! The elements of a table, counted over all rows: a scalar is one, a vector as many as it is long.
//! A row may say the number of its first element, so numbers may be left out, and need not ascend.
//!
//! A long row, and one in a vector, counts as one: its number is `r` whatever its length is, and its
//! elements have numbers far above all others, `(r + 1) << 20` and on.

use super::copied::copied;
use super::fault::Fault;
use super::length::{LONGEST, MOST_COUNTED, Resize, SHIFT};
use super::model::{Model, ModelExchange, Variable, zero};
use super::place::Place;
use std::ops::Range;

/// An element: the index within its row, from 0, and the row.
pub(crate) type Element<M> = (usize, &'static Variable<M>);

/// Number of time itself, which is no element.
pub(crate) const TIME: u32 = LARGEST_NUMBER + 1;

/// The elements of one row, which follow each other.
pub(crate) struct Run<M: Model> {
    /// Number of the first element.
    first: u32,
    len: u32,
    is_array: bool,
    /// Of what is behind the table: where its numbers begin among all of them.
    pub(crate) offset: u32,
    pub(crate) row: &'static Variable<M>,
    /// [`Variable::bounds`] of the row.
    pub(crate) bounds: [f64; 2],
}

copied! { [M: Model] Run<M>; }

impl<M: Model> Run<M> {
    /// Index within the row of the element with this number; larger than any for an element of
    /// another row.
    #[inline]
    pub(crate) fn index(&self, number: u32) -> usize {
        number.wrapping_sub(self.first) as usize
    }

    /// Whether the elements have all things in common, so that they are one array.
    #[inline]
    pub(crate) fn is_array(&self) -> bool {
        self.is_array
    }

    /// How many elements the row has.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.len as usize
    }

    /// The number of the row: that of its first element, unless it counts as one.
    pub(crate) fn number(&self) -> u32 {
        match self.is_long() {
            true => (self.first >> SHIFT) - 1,
            false => self.first,
        }
    }

    /// The largest number that it can have.
    pub(crate) fn largest_number(&self) -> u32 {
        match self.is_long() {
            true => LARGEST_OF_LONG,
            false => LARGEST_NUMBER,
        }
    }

    fn is_long(&self) -> bool {
        self.first >> SHIFT > 0
    }

    /// The block that the number of one of the elements means.
    #[inline]
    fn block_of(self, number: u32) -> Option<Block<M>> {
        match self.index(number) {
            i if !self.is_array => Some((self, i, 1)),
            0 => Some((self, 0, self.len())),
            _ => None,
        }
    }
}

/// The elements that one number means where rows are arrays: their run, the index of the first one,
/// and how many they are. It is the number of a row's first element, and means all of the row;
/// where the elements have different units, each is on its own.
pub(crate) type Block<M> = (Run<M>, usize, usize);

/// Largest number of an element that may be said.
pub(crate) const LARGEST_NUMBER: u32 = u16::MAX as u32;
/// Largest number of a long row.
pub(crate) const LARGEST_OF_LONG: u32 = (1 << (u32::BITS - SHIFT)) - 3;

/// The elements of a table. A row, too, can be addressed: by the number of its first element.
pub(crate) struct Layout<M: Model> {
    /// By number; None where no element has it.
    by_number: Vec<Option<Run<M>>>,
    /// All rows in the order of the table, with the position of the first element among all.
    rows: Vec<(usize, Run<M>)>,
    /// The long rows, with the number of elements of those before.
    long: Vec<(usize, Run<M>)>,
    /// How many continuous states there are for Model Exchange.
    pub(crate) states: usize,
    /// How many event indicators.
    pub(crate) indicators: usize,
}

/// The row of the table that is a state, by its name.
pub(crate) fn state<M: Model>(name: &str) -> Option<&'static Variable<M>> {
    M::variables().iter().find(|row| row.name == name)
}

impl<M: Model> Layout<M> {
    /// Counts the elements of each row in the default values.
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
        for row in M::variables().iter().chain(ModelExchange::<M>::rows()) {
            let is_behind = row.place.is_behind();
            let owner = match row.place {
                Place::Derivative => state(row.name).unwrap_or(row),
                _ => row,
            };
            let len = owner.len(parameters, input, &output).min(LONGEST);
            let number = match is_behind {
                true => layout.len() as u32,
                false => row.at.unwrap_or(next),
            };
            let is_long = owner.resize.is_some() || len > MOST_COUNTED;
            let counted = if is_long { 1 } else { len as u32 };
            next = number.saturating_add(counted);
            let run = Run {
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
            match row.place {
                Place::Derivative => layout.states += len,
                _ if is_behind => layout.indicators += len,
                _ => {}
            }
            offset += if is_behind { len as u32 } else { 0 };
            layout.rows.push((position, run));
            position += len;
            if number > LARGEST_NUMBER {
                continue; // refused by the check of the table
            }
            if layout.by_number.len() < next as usize {
                layout.by_number.resize(next as usize, None);
            }
            if is_long {
                layout.long.push((in_long, run));
                in_long += len;
                continue;
            }
            for place in &mut layout.by_number[number as usize..next as usize] {
                place.get_or_insert(run);
            }
        }
        layout
    }

    /// One more than the largest number of a row.
    pub(crate) fn len(&self) -> usize {
        self.by_number.len()
    }

    /// How many places for something about each element there must be.
    pub(crate) fn slots(&self) -> usize {
        let in_long = |(before, run): &(usize, Run<M>)| before + run.len();
        self.len() + self.long.last().map_or(0, in_long)
    }

    /// The place for something about the element with this number.
    pub(crate) fn slot(&self, number: u32) -> usize {
        match (self.long.iter()).find(|(_, run)| run.index(number) < run.len()) {
            Some((before, run)) => self.len() + before + run.index(number),
            None => number as usize,
        }
    }

    /// Whether there are rows whose length is that of a vector.
    #[inline]
    pub(crate) fn has_vectors(&self) -> bool {
        (self.long.iter()).any(|(_, run)| run.row.resize.is_some())
    }

    /// Inputs that are zero, with vectors as long as those of `like`.
    #[inline]
    pub(crate) fn zero(&self, like: &M::Input) -> M::Input {
        match self.has_vectors() {
            true => zero::<M>(like),
            false => M::Input::default(),
        }
    }

    /// Whether parameters and inputs are as long as the rows.
    pub(crate) fn fits(&self, p: &M::Parameters, u: &M::Input) -> bool {
        self.long.iter().all(|(_, run)| match run.row.resize {
            None | Some(Resize::Output(_)) => true,
            Some(_) => run.row.place.len(p, u, &M::Output::default()) == run.len(),
        })
    }

    /// All elements in the order of the table.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Element<M>> {
        self.numbered().map(|(_, element)| element)
    }

    /// All elements in the order of the table, with their numbers.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (u32, Element<M>)> {
        (self.rows.iter()).flat_map(|&(_, run)| {
            (run.first..run.first + run.len)
                .map(move |number| (number, (run.index(number), run.row)))
        })
    }

    /// Elements to try something with, at their positions: all, of long rows some.
    pub(crate) fn samples(&self) -> Vec<(usize, Element<M>)> {
        let some = |&(start, run): &(usize, Run<M>)| {
            let last = run.len().saturating_sub(1);
            let is_tried = move |&i: &usize| !run.is_long() || [0, 1, last / 2, last].contains(&i);
            let tried = (0..run.len()).filter(is_tried);
            tried.map(move |i| (start + i, (i, run.row)))
        };
        self.rows.iter().flat_map(some).collect()
    }

    /// All rows in the order of the table, with the positions of their elements among all elements.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (Range<usize>, &'static Variable<M>)> {
        (self.rows.iter()).map(|&(start, run)| (start..start + run.len(), run.row))
    }

    /// Where the derivatives of a state's row, or an indicator, begin among all that is behind the
    /// table.
    pub(crate) fn offset(&self, of: &Variable<M>) -> usize {
        let is_it = |row: &Variable<M>| row.place.is_behind() && row.name == of.name;
        let run = self.rows.iter().find(|(_, run)| is_it(run.row));
        run.map_or(0, |(_, run)| run.offset as usize)
    }

    /// The position of the state of which element `i` of a row is the derivative.
    pub(crate) fn state_of(&self, row: &Variable<M>, i: usize) -> Option<usize> {
        let mut rows = self.rows();
        let state = rows.find(|(_, state)| row.place.is_derivative() && state.name == row.name)?;
        Some(state.0.start + i)
    }

    /// The block that a number means.
    #[inline]
    pub(crate) fn block(&self, number: u32) -> Result<Block<M>, Fault> {
        match self.short(number) {
            Some(run) => run.block_of(number).ok_or(Fault::Unknown(number)),
            None => self.long_block(number),
        }
    }

    #[cold]
    #[inline(never)]
    fn long_block(&self, number: u32) -> Result<Block<M>, Fault> {
        let run = (self.long.iter()).find(|(_, run)| run.number() == number);
        run.map_or(Err(Fault::Unknown(number)), |&(_, run)| {
            Ok((run, 0, run.len()))
        })
    }

    /// The row of which this number means all elements, if there are `len` of them.
    #[inline]
    pub(crate) fn whole(&self, number: u32, len: usize) -> Option<&Run<M>> {
        let run = self.short(number)?;
        let is_whole = number == run.first && len == run.len() && (run.is_array || len == 1);
        is_whole.then_some(run)
    }

    /// The long row of this number, if it has `len` elements.
    #[cold]
    #[inline(never)]
    pub(crate) fn long(&self, number: u32, len: usize) -> Option<Run<M>> {
        let (run, _, n) = self.long_block(number).ok()?;
        (n == len && run.is_array).then_some(run)
    }

    /// All blocks in the order of the table, with their numbers.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = (u32, Block<M>)> {
        self.together(|run| run.is_array && run.len > 0)
    }

    /// What is numbered: elements, and long rows as one.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (u32, Block<M>)> {
        self.together(Run::is_long)
    }

    /// All elements, together where a row is one.
    fn together(&self, is_one: fn(&Run<M>) -> bool) -> impl Iterator<Item = (u32, Block<M>)> {
        self.rows.iter().flat_map(move |&(_, run)| {
            let (blocks, len) = match is_one(&run) {
                true => (1, run.len()),
                false => (run.len, 1),
            };
            (0..blocks).map(move |i| (run.number() + i, (run, i as usize, len)))
        })
    }

    /// The numbers of the elements that `number` means in [`block`](Self::block).
    pub(crate) fn elements(&self, number: u32) -> Result<Range<u32>, Fault> {
        let (run, first, len) = self.block(number)?;
        let first = run.first + first as u32;
        Ok(first..first + len as u32)
    }

    /// The number of the block that holds the element at a position, and its index there.
    pub(crate) fn block_at(&self, position: usize) -> (u32, usize) {
        let k = self.rows.partition_point(|(start, _)| *start <= position) - 1;
        let (start, run) = &self.rows[k];
        let i = position - start;
        match run.is_array() {
            true => (run.number(), i),
            false => (run.first + i as u32, 0),
        }
    }

    /// The run of the element with this number, unless it is of a long row.
    #[inline]
    pub(crate) fn short(&self, number: u32) -> Option<&Run<M>> {
        self.by_number.get(number as usize)?.as_ref()
    }

    /// The run of the element with this number.
    #[inline]
    pub(crate) fn run(&self, number: u32) -> Result<Run<M>, Fault> {
        match self.short(number) {
            Some(run) => Ok(*run),
            None => self.long_run(number),
        }
    }

    #[cold]
    #[inline(never)]
    fn long_run(&self, number: u32) -> Result<Run<M>, Fault> {
        let run = (self.long.iter()).find(|(_, run)| run.index(number) < run.len());
        run.map_or(Err(Fault::Unknown(number)), |&(_, run)| Ok(run))
    }

    /// The element with this number, or the first one of the block with it: for what is said of it.
    pub(crate) fn find_any(&self, number: u32) -> Result<Element<M>, Fault> {
        let block = self.block(number).map(|(run, first, _)| (first, run.row));
        block.or_else(|_| self.find(number))
    }

    /// The element with this number.
    #[inline]
    pub(crate) fn find(&self, number: u32) -> Result<Element<M>, Fault> {
        let run = self.run(number)?;
        Ok((run.index(number), run.row))
    }
}
