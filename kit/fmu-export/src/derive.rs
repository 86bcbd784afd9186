//! What the derives of `fmu-export-derive` write against. None of it is written by hand, except
//! [`Choice`] and [`Ode`].
//!
//! A struct that derives [`Parameters`], [`Input`], [`Output`] or [`State`] has rows for any model
//! and any [`Path`] that leads to it, so that structs can be nested. The rows of a model are a
//! constant: nothing is made when a library is loaded.

mod array_serde;
mod choice;
mod fallback;
mod name;
mod ode;
mod path;
mod rows;
mod solver;

pub use array_serde::{ArrayCells, DeserializedArray, SerializedArray};
pub use choice::{Choice, Enumerated, Item};
pub use fallback::{Fallback, FallbackRows, FieldRows, FieldType, is_output};
pub use name::Name;
pub use ode::{Ode, OutputsPath, State, StateAndOutputs, StatePath, Vector};
pub use path::{Path, Root};
pub use rows::{
    Part, Rows, assemble, count, count_states, derivatives, is_display_unit, is_known_unit,
};
pub use serde;
pub use solver::SolverName;

use serde::{Serialize, de::DeserializeOwned};

/// A struct of parameters: `#[derive(Parameters)]` makes its rows of the table.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be a parameter",
    label = "not a type of parameter",
    note = "a parameter is an f64, an f32, an integer, a bool, a String, a Binary, a Choice<…>, an array or a Vec of one of them, or \
            a struct with #[derive(Parameters)]"
)]
pub trait Parameters: Clone + Serialize + DeserializeOwned {
    /// The start values.
    fn start() -> Self;
}

/// A struct of inputs: `#[derive(Input)]` makes its rows of the table.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be an input",
    label = "not a type of input",
    note = "an input is an f64, an f32, an integer, a bool, a String, a Binary, a Choice<…>, an array or a Vec of one of them, or a \
            struct with #[derive(Input)]"
)]
pub trait Input: Clone + Default + Serialize + DeserializeOwned {
    /// The start values.
    fn start() -> Self;
}

/// A struct of outputs: `#[derive(Output)]` makes its rows of the table.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be an output",
    label = "not a type of output",
    note = "an output is an f64, an f32, an integer, a bool, a String, a Binary, a Choice<…>, an array or a Vec of one of them, a \
            &'static str, or a struct with #[derive(Output)]"
)]
pub trait Output: Clone + Default {}

impl Parameters for () {
    fn start() {}
}

impl Input for () {
    fn start() {}
}

impl Output for () {}

/// In an `impl Model`: types, table and start values from structs with derives.
///
/// `derived!(Parameters, Input, Output);` stands for the associated types `Parameters`, `Input`,
/// `Output` and `Evaluation = ()`, and for `variables` and `defaults`. A type that is not needed is
/// `()`.
#[macro_export]
macro_rules! derived {
    ($parameters:ty, $input:ty, $output:ty $(,)?) => {
        type Parameters = $parameters;
        type Input = $input;
        type Output = $output;
        type Evaluation = ();

        fn variables() -> &'static [$crate::Variable<Self>] {
            const {
                &$crate::derive::assemble::<
                    Self,
                    {
                        $crate::derive::count::<Self>($crate::derived_rows!(
                            $parameters,
                            $input,
                            $output
                        ))
                    },
                >($crate::derived_rows!($parameters, $input, $output))
            }
        }

        fn defaults() -> (Self::Parameters, Self::Input) {
            $crate::fit_start_values::<Self>((
                <$parameters as $crate::derive::Parameters>::start(),
                <$input as $crate::derive::Input>::start(),
            ))
        }
    };
}

/// Part of [`derived!`].
#[doc(hidden)]
#[macro_export]
macro_rules! derived_rows {
    ($($owner:ty),*) => {
        &[$(<$owner as $crate::derive::Rows<Self, $crate::derive::Root<$owner>>>::ROWS),*]
    };
}
