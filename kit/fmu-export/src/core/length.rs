//! How long rows can be, and the lengths of rows in a `Vec`, for tables, `layout` and `sizes`.

use super::impl_copy::impl_copy;

/// Most elements of a row whose elements each have a number; longer rows have one number.
pub(crate) const MOST_COUNTED: usize = 256;
/// Bits for an element's index in the number of an element of a long row.
pub(crate) const SHIFT: u32 = 20;
/// Most elements of a row.
pub(crate) const LONGEST: usize = 1 << SHIFT;

/// The number of elements of a row in one dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// A constant.
    Fixed(usize),
    /// The value of the structural parameter with this name.
    Parameter(&'static str),
}

/// Gives the `Vec` of a row a length, filled with start values.
pub enum Resize<P, U, Y> {
    /// A `Vec` in the parameters.
    Parameter(fn(&mut P, usize)),
    /// A `Vec` in the inputs.
    Input(fn(&mut U, usize)),
    /// A `Vec` in the outputs.
    Output(fn(&mut Y, usize)),
}

impl_copy! { [P, U, Y] Resize<P, U, Y>; }
