//! Exports a Rust model as an FMU for FMI 2.0 and FMI 3.0, from one table of variables and as one
//! library: for Co-Simulation and, if the model gives its differential equations, Model Exchange.
//!
//! With the feature `derive`, structs with derives make up the table of variables:
//!
#![cfg_attr(feature = "derive", doc = "```")]
#![cfg_attr(not(feature = "derive"), doc = "```ignore")]
//! use fmu_export::prelude::*;
//!
//! #[derive(Parameters)]
//! struct Parameters {
//!     /// Time constant
//!     #[fmu(unit = "s", start = 0.1, min = 1e-6)]
//!     time_constant: f64,
//! }
//!
//! #[derive(Input)]
//! struct Input {
//!     /// What y follows
//!     #[fmu(unit = "m", display_unit = "mm")]
//!     u: [f64; 2],
//! }
//!
//! /// Two first-order lags: T dy/dt = u − y
//! #[derive(State)]
//! #[fmu(parameters = Parameters, input = Input, model_exchange)]
//! struct Lag {
//!     /// Lagged u
//!     #[fmu(unit = "m", start = u.u)]
//!     y: [f64; 2],
//! }
//!
//! impl Ode for Lag {
//!     fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
//!         dx.y = std::array::from_fn(|i| (u.u[i] - self.y[i]) / p.time_constant);
//!     }
//! }
//!
//! export_fmu!(Lag);
//! # fn main() { assert_eq!(fmu_export::check::<Lag>(), [""; 0]); }
//! ```
//!
//! Without the derives, a table of [`Variable`]s says where each variable is stored, and an
//! implementation of [`Model`] computes:
//!
//! ```
//! use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
//! use serde::{Deserialize, Serialize};
//!
//! /// A first-order lag: T dy/dt = u − y.
//! #[derive(Clone, Serialize, Deserialize)]
//! struct Lag { y: [f64; 2] }
//!
//! #[derive(Clone, Serialize, Deserialize)]
//! struct Parameters { time_constant: f64 }
//! #[derive(Clone, Copy, Default, Serialize, Deserialize)]
//! struct Input { u: [f64; 2] }
//! #[derive(Clone, Copy, Default)]
//! struct Output { y: [f64; 2], sum: f64 }
//!
//! type V = Variable<Lag>;
//! #[rustfmt::skip]
//! const VARIABLES: &[V] = &[
//!     V::parameter("T", "time constant", |p| &p.time_constant, |p| &mut p.time_constant).unit("s").min(1e-6),
//!     V::inputs   ("u", "what y follows", |u| &u.u, |u| &mut u.u).unit("m").display_unit("mm"),
//!     V::outputs  ("y", "lagged u", |y| &y.y).unit("m").depends_on(&[]).initially_depends_on(&["u[i]"]),
//!     V::output   ("sum", "sum of y and u", |y| &y.sum).unit("m").depends_on(&["u"]).initially_depends_on(&["u"]),
//! ];
//!
//! impl Model for Lag {
//!     type Parameters = Parameters;
//!     type Input = Input;
//!     type Output = Output;
//!     type Evaluation = (); // nothing that `output` and `step` would both compute
//!     const INFO: Info = Info::new("Lag", "two first-order lags").version(env!("CARGO_PKG_VERSION"));
//!
//!     fn variables() -> &'static [Variable<Self>] { VARIABLES }
//!     fn defaults() -> (Parameters, Input) { (Parameters { time_constant: 0.1 }, Input::default()) }
//!     fn initialize(_p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> { Ok(Lag { y: u.u }) }
//!     fn output(&self, _p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
//!         Ok(Output { y: self.y, sum: self.y.iter().chain(&u.u).sum() })
//!     }
//!     fn step(&mut self, p: &Parameters, u: &InputPolynomial<Input>, _now: &(), _t: f64, h: f64) -> Result<StepEnd, ModelError> {
//!         let decay = (-h / p.time_constant).exp();
//!         let mid = u.at::<Self>(0.5 * h); // follows the input derivatives if the importer gives them
//!         for (y, u) in self.y.iter_mut().zip(mid.u) { *y = u + (*y - u) * decay; }
//!         Ok(StepEnd::WHOLE)
//!     }
//! } fmu_export::export_fmu!(Lag);
//! # fn main() {}
//! ```
//!
//! Accessors point at the field (`|u| &u.x`, `|u| &mut u.x`); [`row!`] writes both from its name.
//! Vectors of any array or slice work the same. Enumerations are `i32` rows with
//! `.enumeration(&DRIVE)`, items counted from 1, or with [`Items`] of any type. See [`Variable`] for
//! everything a row can say and [`Info`] for default experiment, documentation, icon and resources.
//! `type V = Variable<Lag>` is needed for type inference.
//!
//! For Model Exchange, a model also implements [`Continuous`]; one with derives has the attribute
//! `#[fmu(model_exchange)]`.

mod c_api;
#[cfg(feature = "can")]
pub mod can;
mod check;
mod core;
#[cfg(feature = "derive")]
#[doc(hidden)]
pub mod derive;
mod fmi2;
mod fmi3;
#[doc(no_inline)]
pub use fmu_solver as solver;
/// For types of fields with `#[fmu(skip)]`: `#[derive(Serialize, Deserialize)]` of the prelude with
/// `#[serde(crate = "fmu_export::serde")]` needs no dependency.
#[doc(no_inline)]
pub use serde;
pub mod tables;
#[cfg(target_arch = "wasm32")]
mod wasm;

pub use check::check;
pub use core::binary::Binary;
pub use core::causality::{ALL_PARAMETERS, NO_STATES};
pub use core::continuous::Continuous;
pub use core::counted_input::{CountedInput, ExtrapolatedInput};
pub use core::enumeration::{Enumeration, Items};
pub use core::error::ModelError;
pub use core::event::{Event, Tick};
pub use core::info::{File, Info, MadeFile, Terminal};
pub use core::input::{InputPolynomial, MAX_INPUT_DERIVATIVE};
pub use core::length::{Length, Resize};
pub use core::log::Log;
pub use core::message::Level;
pub use core::model::{Clock, Evaluation, Model, ModelExchange, OnTick, SetString, Variable};
pub use core::packed_file::PackedFile;
pub use core::parameter_file::{read_parameter_file, read_placed_file};
#[doc(hidden)]
pub use core::sizes::fit_start_values;
#[doc(hidden)]
pub use core::solver::{SolverName, solved_step};
#[doc(hidden)]
pub use core::solver_workspace::SolverWorkspace;
pub use core::step_end::StepEnd;
pub use core::storage::Fields;
#[doc(hidden)]
pub use core::table_macros::{join, total};
pub use core::type_definition::TypeDefinition;
pub use fmi_units::{DisplayUnit, KNOWN_UNITS, Unit};
pub use fmi2::description::model_description;
#[doc(hidden)]
pub use fmi2::entry;
pub use fmi2::ffi;
pub use fmi3::description::model_description3;
#[doc(hidden)]
pub use fmi3::entry as entry3;
pub use fmi3::ffi as ffi3;
#[cfg(target_arch = "wasm32")]
#[doc(hidden)]
pub use wasm::component;
#[cfg(feature = "derive")]
pub use {
    derive::{Choice, Ode},
    fmu_export_derive::{Enumeration, Input, Output, Parameters, State},
};

/// Everything a model with derives needs: `use fmu_export::prelude::*;`.
#[cfg(feature = "derive")]
pub mod prelude {
    /// The trait of the states of models, for `start`; their derive has the same name.
    pub use crate::derive::State;
    pub use crate::{
        Binary, Choice, Clock, Enumeration, Event, Info, Input, InputPolynomial, Log, Model,
        ModelError, Ode, Output, Parameters, State, StepEnd, Tick, TypeDefinition, Unit, Variable,
        derived, export_fmu, indicators_of, solved,
    };
    pub use serde::{Deserialize, Serialize};
}

/// The model in the README of the kit.
#[cfg(all(doctest, feature = "derive"))]
#[doc = include_str!("../../README.md")]
struct Readme;

/// The node in the page about CAN.
#[cfg(all(doctest, feature = "can"))]
#[doc = include_str!("../../../docs/kit/can.md")]
struct CanPage;

/// The controller in the page about clocks.
#[cfg(all(doctest, feature = "derive"))]
#[doc = include_str!("../../../docs/kit/clocks.md")]
struct ClocksPage;
