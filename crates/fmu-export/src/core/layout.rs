//! The elements of a table, counted over all rows: a scalar is one, a vector as many as it is long. A row may say the number of its
//! first element, so numbers may be left out, and need not ascend.

use super::fault::Fault;
use super::variable::{Causality, Kind, Names, Place, Read, Variable, Write};
use crate::{InputPolynomial, Model};
use std::ops::Range;
use std::{ptr, slice};

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
    pub(crate) row: &'static Variable<M>,
    /// [`Variable::bounds`] of the row.
    pub(crate) bounds: [f64; 2],
}

impl<M: Model> Clone for Run<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Model> Copy for Run<M> {}

impl<M: Model> Run<M> {
    /// Index within the row of the element with this number; larger than any for an element of another row.
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
}

/// Largest number of an element that may be said.
pub(crate) const LARGEST_NUMBER: u32 = u16::MAX as u32;

/// The elements of a table. A row, too, can be addressed: by the number of its first element.
pub(crate) struct Layout<M: Model> {
    /// By number; None where no element has it.
    by_number: Vec<Option<Run<M>>>,
    /// Number and run of each element, in the order of the table.
    in_order: Vec<(u32, Run<M>)>,
}

impl<M: Model> Layout<M> {
    /// Counts the elements of each row in the default values.
    pub(crate) fn new(parameters: &M::Parameters, input: &M::Input) -> Self {
        let output = M::Output::default();
        let (mut by_number, mut in_order) = (Vec::new(), Vec::new());
        let mut next = 0;
        for row in M::variables() {
            let len = row.place.len(parameters, input, &output) as u32;
            let first = row.at.unwrap_or(next);
            next = first.saturating_add(len);
            let run = Run {
                first,
                len,
                is_array: !row.scalar && row.each_unit.windows(2).all(|pair| pair[0] == pair[1]),
                row,
                bounds: row.bounds(),
            };
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

    /// The elements that one number means where rows are arrays: their run, the index of the first one, and how many they are. It is the
    /// number of a row's first element, and means all of the row; where the elements have different units, each is on its own.
    #[inline]
    pub(crate) fn block(&self, number: u32) -> Result<(Run<M>, usize, usize), Fault> {
        let run = self.run(number)?;
        if run.is_array() {
            return match run.index(number) {
                0 => Ok((run, 0, run.len())),
                _ => Err(Fault::Unknown(number)),
            };
        }
        Ok((run, run.index(number), 1))
    }

    /// The row of which this number means all elements, if there are `len` of them.
    #[inline]
    pub(crate) fn whole(&self, number: u32, len: usize) -> Option<&Run<M>> {
        let run = self.by_number.get(number as usize)?.as_ref()?;
        let is_whole = number == run.first && len == run.len() && (run.is_array || len == 1);
        is_whole.then_some(run)
    }

    /// The numbers of all blocks, in the order of the table.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = u32> {
        (self.in_order.iter())
            .filter(|(number, run)| !run.is_array() || *number == run.first)
            .map(|(number, _)| *number)
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

impl<M: Model> Variable<M> {
    /// Name of an element: `x`, or `x[1]` for the first of a vector.
    pub(crate) fn element_name(&self, index: usize) -> String {
        if self.scalar {
            self.name.to_owned()
        } else {
            format!("{}[{}]", self.name, index + 1)
        }
    }

    /// Type and causality in words, for messages: `an Integer input`.
    pub(crate) fn kind(&self, names: &Names) -> String {
        let causality = match self.causality {
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Local => "local variable",
            Causality::Parameter if self.tunable => "tunable parameter",
            Causality::Parameter => "fixed parameter",
            Causality::CalculatedParameter => "calculated parameter",
            Causality::Constant => "constant",
        };
        let name = match self.enumeration {
            Some(_) => names.enumeration,
            None => self.place.kind().name(names),
        };
        let article = if name.starts_with(['I', 'E']) {
            "an"
        } else {
            "a"
        };
        format!("{article} {name} {causality}")
    }

    /// Name of the type by which it is set and read.
    pub(crate) fn access(&self, names: &Names) -> &'static str {
        match self.enumeration {
            Some(_) => names.enumeration_access,
            None => self.place.kind().name(names),
        }
    }
}

impl<M: Model> Place<M> {
    pub(crate) fn len(&self, p: &M::Parameters, u: &M::Input, y: &M::Output) -> usize {
        match self {
            Place::RealIn(place) => place.len(u),
            Place::IntegerIn(place) => place.len(u),
            Place::BooleanIn(place) => place.len(u),
            Place::RealOut(place) => place.len(y),
            Place::IntegerOut(place) => place.len(y),
            Place::BooleanOut(place) => place.len(y),
            Place::RealParameter(place) => place.len(p),
            Place::IntegerParameter(place) => place.len(p),
            Place::BooleanParameter(place) => place.len(p),
            Place::StringParameter(..) | Place::StringOut(_) => 1,
        }
    }

    /// Its type.
    pub(crate) fn kind(&self) -> Kind {
        match self {
            Place::RealIn(_) | Place::RealOut(_) | Place::RealParameter(_) => Kind::Real,
            Place::IntegerIn(_) | Place::IntegerOut(_) | Place::IntegerParameter(_) => {
                Kind::Integer
            }
            Place::BooleanIn(_) | Place::BooleanOut(_) | Place::BooleanParameter(_) => {
                Kind::Boolean
            }
            Place::StringParameter(..) | Place::StringOut(_) => Kind::String,
        }
    }

    pub(crate) fn is_real(&self) -> bool {
        self.kind() == Kind::Real
    }
}

impl<S, T: Copy> Read<S, T> {
    fn len(&self, s: &S) -> usize {
        self.slice(s).len()
    }

    /// All elements of the row.
    #[inline]
    pub(crate) fn slice<'a>(&self, s: &'a S) -> &'a [T] {
        match self {
            Read::Scalar(get) => slice::from_ref(get(s)),
            Read::Vector(get) => get(s),
        }
    }

    #[inline]
    pub(crate) fn get(&self, s: &S, i: usize) -> T {
        self.slice(s)[i]
    }
}

impl<S, T: Copy> Write<S, T> {
    pub(crate) fn len(&self, s: &S) -> usize {
        self.slice(s).len()
    }

    /// All elements of the row.
    #[inline]
    pub(crate) fn slice<'a>(&self, s: &'a S) -> &'a [T] {
        match self {
            Write::Scalar(get, _) => slice::from_ref(get(s)),
            Write::Vector(get, _) => get(s),
        }
    }

    #[inline]
    pub(crate) fn get(&self, s: &S, i: usize) -> T {
        self.slice(s)[i]
    }

    /// All elements of the row, to write.
    #[inline]
    pub(crate) fn slice_mut<'a>(&self, s: &'a mut S) -> &'a mut [T] {
        match self {
            Write::Scalar(_, get_mut) => slice::from_mut(get_mut(s)),
            Write::Vector(_, get_mut) => get_mut(s),
        }
    }

    #[inline]
    pub(crate) fn get_mut<'a>(&self, s: &'a mut S, i: usize) -> &'a mut T {
        &mut self.slice_mut(s)[i]
    }
}

/// The `order`-th time derivative of all Real inputs, `s` seconds into the step; other inputs as they are.
pub(crate) fn taylor<M: Model>(u: &InputPolynomial<M::Input>, s: f64, order: usize) -> M::Input {
    let mut result = if order == 0 {
        u.value
    } else {
        M::Input::default()
    };
    for (i, place) in real_inputs::<M>(&u.value) {
        // Horner from the highest order down: a_k + s/(k − order + 1)·(…), a_k the k-th derivative at the start.
        let mut sum = 0.0;
        for k in (order..=u.order).rev() {
            let a_k = if k == 0 {
                &u.value
            } else {
                &u.derivatives[k - 1]
            };
            sum = place.get(a_k, i) + sum * s / (k - order + 1) as f64;
        }
        *place.get_mut(&mut result, i) = sum;
    }
    result
}

/// Every element of the Real outputs and local variables, in order.
pub(crate) fn real_outputs<M: Model>(y: &M::Output) -> impl Iterator<Item = f64> {
    M::variables()
        .iter()
        .filter_map(|row| match &row.place {
            Place::RealOut(place) => Some(place.slice(y)),
            _ => None,
        })
        .flatten()
        .copied()
}

/// Every element of the Real inputs: index in its row, and place.
pub(crate) fn real_inputs<M: Model>(
    u: &M::Input,
) -> impl Iterator<Item = (usize, &'static Write<M::Input, f64>)> {
    M::variables()
        .iter()
        .filter_map(|row| match &row.place {
            Place::RealIn(place) => Some(place),
            _ => None,
        })
        .flat_map(|place| (0..place.len(u)).map(move |i| (i, place)))
}
