//! Checks of a model against its table that need the model to run: for the tests of its author.

mod accessors;
mod dependencies;
mod derivatives;
mod equations;
mod model_check;
mod point;
mod start;

use crate::Model;
use crate::fmi2::description::unsupported_type;
use model_check::ModelCheck;

/// What is wrong with a model's table, as far as trying can tell; empty if nothing is.
///
/// - [`model_description`](crate::model_description) finds no mistake, or for a model with types that
///   FMI 2.0 does not have, [`model_description3`](crate::model_description3).
/// - The model initializes, gives outputs that are finite and in their enumerations, and steps, all
///   with its start values; the derivatives it declares are there.
/// - Each input and parameter reads back what was written, and writing it changes no other one:
///   accessors of one row are of one field, and no two rows share a field. No two outputs do.
/// - Outputs follow no input and no parameter but those that they declare, while stepping and
///   initially.
/// - The states of a model for Model Exchange are those that the table shows, all derivatives are
///   written, and outputs, derivatives and event indicators follow no state but those that they
///   declare.
/// - Directional derivatives, if the model has them, are those that differences of the outputs
///   give, and adjoint derivatives are their transpose.
/// - Calculated parameters follow the parameters they declare and nothing else; constants nothing
///   at all.
/// - The model's [`Evaluation`](crate::Evaluation) follows no input that is declared to be beside
///   it.
///
/// ```
/// # use fmu_export::*; use serde::{Deserialize, Serialize};
/// # #[derive(Clone, Serialize, Deserialize)] struct Lag; #[derive(Clone, Copy, Default, Serialize, Deserialize)] struct Nothing;
/// # impl Model for Lag { type Parameters = Nothing; type Input = Nothing; type Output = Nothing; type Evaluation = ();
/// # const INFO: Info = Info::new("Lag", "lag"); fn variables() -> &'static [Variable<Self>] { &[] }
/// # fn defaults() -> (Nothing, Nothing) { (Nothing, Nothing) }
/// # fn initialize(_: &Nothing, _: &Nothing, _: f64) -> Result<Self, ModelError> { Ok(Lag) }
/// # fn output(&self, _: &Nothing, _: &Nothing, _: &()) -> Result<Nothing, ModelError> { Ok(Nothing) }
/// # fn step(&mut self, _: &Nothing, _: &InputPolynomial<Nothing>, _: &(), _: f64, _: f64) -> Result<StepEnd, ModelError> { Ok(StepEnd::WHOLE) } }
/// assert_eq!(fmu_export::check::<Lag>(), [""; 0]);
/// ```
pub fn check<M: Model>() -> Vec<String> {
    let described = match unsupported_type::<M>() {
        None => crate::model_description::<M>(),
        Some(_) => crate::model_description3::<M>(),
    };
    if let Err(reason) = described {
        return vec![reason];
    }
    let mut check = ModelCheck::<M>::new();
    check.accessors();
    check.texts();
    check.outputs();
    check.start();
    check.equations();
    if check.problems.is_empty() {
        check.dependencies();
        check.initial_dependencies();
    }
    check.problems.into_iter().collect()
}
