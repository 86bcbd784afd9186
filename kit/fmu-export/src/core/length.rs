//! How long a row is that is not an array in Rust, and what makes it as long.

use super::impl_copy::impl_copy;

/// Most elements of a row whose elements are counted one by one.
pub(crate) const MOST_COUNTED: usize = 256;
/// Where the elements of a long row are numbered: bits below the row's number.
pub(crate) const SHIFT: u32 = 20;
/// Most elements of a row.
pub(crate) const LONGEST: usize = 1 << SHIFT;

/// How many elements a row has in a dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// Always as many.
    Fixed(usize),
    /// As many as the structural parameter of this name says.
    Parameter(&'static str),
}

/// Makes the vector that a row is in of a length, with start values.
pub enum Resize<P, U, Y> {
    /// A vector in the parameters.
    Parameter(fn(&mut P, usize)),
    /// A vector in the inputs.
    Input(fn(&mut U, usize)),
    /// A vector in the outputs.
    Output(fn(&mut Y, usize)),
}

impl_copy! { [P, U, Y] Resize<P, U, Y>; }
