//! [`check`]: compares a model with its table of variables by running the model, for a test that
//! the model's author writes.

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

/// Runs a model and lists what its table gets wrong; empty if no mistake was found. It checks that:
///
/// - [`model_description`](crate::model_description) finds no mistake; for a model with types that
///   FMI 2.0 does not have, [`model_description3`](crate::model_description3).
/// - With its start values the model initializes, steps, and gives outputs that are finite and
///   items of their enumerations; the derivatives that it declares are implemented.
/// - Each input and parameter reads back what was written, and no two rows share a field.
/// - Outputs depend only on the inputs and parameters that they declare, while stepping and
///   initially.
/// - For Model Exchange, the states are those of the table, all derivatives are written, and
///   outputs, derivatives and event indicators depend only on the states that they declare.
/// - Directional derivatives agree with differences of the outputs, and adjoint derivatives are
///   their transpose.
/// - Calculated parameters depend only on the parameters that they declare, constants on nothing.
/// - The model's [`Evaluation`](crate::Evaluation) depends on no input that is declared
///   [`not_in_evaluation`](crate::Variable::not_in_evaluation).
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
