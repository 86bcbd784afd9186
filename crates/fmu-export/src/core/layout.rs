//! The elements of a table, counted over all rows: a scalar is one, a vector as many as it is long.
//! A row may say the number of its first element, so numbers may be left out, and need not ascend.

use super::continuous::ModelExchange;
use super::copied::copied;
use super::fault::Fault;
use super::model::{Model, Variable};
use super::place::Place;
use std::ops::Range;
use std::ptr;

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

    /// The block that the number of one of the elements means.
    #[inline]
    fn block(self, number: u32) -> Option<Block<M>> {
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

/// The elements of a table. A row, too, can be addressed: by the number of its first element.
pub(crate) struct Layout<M: Model> {
    /// By number; None where no element has it.
    by_number: Vec<Option<Run<M>>>,
    /// Number and run of each element, in the order of the table.
    in_order: Vec<(u32, Run<M>)>,
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
        let (mut by_number, mut in_order) = (Vec::new(), Vec::new());
        let mut next = 0;
        let (mut offset, mut states) = (0, 0);
        for row in M::variables().iter().chain(ModelExchange::<M>::rows()) {
            let is_behind = row.place.is_behind();
            let owner = match row.place {
                Place::Derivative => state(row.name).unwrap_or(row),
                _ => row,
            };
            let len = owner.place.len(parameters, input, &output) as u32;
            let first = match is_behind {
                true => by_number.len() as u32,
                false => row.at.unwrap_or(next),
            };
            next = first.saturating_add(len);
            let run = Run {
                first,
                len,
                is_array: !owner.scalar
                    && owner.each_unit.windows(2).all(|pair| pair[0] == pair[1]),
                offset,
                row,
                bounds: row.bounds(),
            };
            offset += if is_behind { len } else { 0 };
            if let Place::Derivative = row.place {
                states = offset as usize;
            }
            in_order.extend((first..next).map(|number| (number, run)));
            if first > LARGEST_NUMBER {
                continue; // refused by the check of the table
            }
            if by_number.len() < next as usize {
                by_number.resize(next as usize, None);
            }
            for place in &mut by_number[first as usize..next as usize] {
                place.get_or_insert(run);
            }
        }
        Self {
            by_number,
            in_order,
            states,
            indicators: offset as usize - states,
        }
    }

    /// One more than the largest number.
    pub(crate) fn len(&self) -> usize {
        self.by_number.len()
    }

    /// All elements in the order of the table.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Element<M>> {
        self.numbered().map(|(_, element)| element)
    }

    /// All elements in the order of the table, with their numbers.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (u32, Element<M>)> {
        (self.in_order.iter()).map(|&(number, run)| (number, (run.index(number), run.row)))
    }

    /// All rows in the order of the table, with the positions of their elements among all elements.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (Range<usize>, &'static Variable<M>)> {
        let mut end = 0;
        (self.in_order)
            .chunk_by(|(_, a), (_, b)| ptr::eq(a.row, b.row))
            .map(move |elements| {
                let start = end;
                end += elements.len();
                (start..end, elements[0].1.row)
            })
    }

    /// Where the derivatives of a state's row begin among those of all states.
    pub(crate) fn derivative_of(&self, state: &Variable<M>) -> usize {
        let of_it = |row: &Variable<M>| row.place.is_derivative() && row.name == state.name;
        let run = self.in_order.iter().find(|(_, run)| of_it(run.row));
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
        let run = self.run(number)?;
        run.block(number).ok_or(Fault::Unknown(number))
    }

    /// The row of which this number means all elements, if there are `len` of them.
    #[inline]
    pub(crate) fn whole(&self, number: u32, len: usize) -> Option<&Run<M>> {
        let run = self.by_number.get(number as usize)?.as_ref()?;
        let is_whole = number == run.first && len == run.len() && (run.is_array || len == 1);
        is_whole.then_some(run)
    }

    /// All blocks in the order of the table, with their numbers.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = (u32, Block<M>)> {
        (self.in_order.iter()).filter_map(|(number, run)| Some((*number, run.block(*number)?)))
    }

    /// The numbers of the elements that `number` means in [`block`](Self::block).
    pub(crate) fn elements(&self, number: u32) -> Result<Range<u32>, Fault> {
        let (_, _, len) = self.block(number)?;
        Ok(number..number + len as u32)
    }

    /// The number of the block that holds the element at a position.
    pub(crate) fn block_at(&self, position: usize) -> (u32, usize) {
        let (number, run) = &self.in_order[position];
        match run.is_array() {
            true => (run.first, run.index(*number)),
            false => (*number, 0),
        }
    }

    /// The run of the element with this number.
    #[inline]
    pub(crate) fn run(&self, number: u32) -> Result<Run<M>, Fault> {
        let run = self.by_number.get(number as usize).copied();
        run.flatten().ok_or(Fault::Unknown(number))
    }

    /// The element with this number.
    #[inline]
    pub(crate) fn find(&self, number: u32) -> Result<Element<M>, Fault> {
        let run = self.run(number)?;
        Ok((run.index(number), run.row))
    }
}
