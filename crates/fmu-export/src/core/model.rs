//! What a model implements.

use super::derivatives::adjoint_by_columns;
use crate::{Info, InputPolynomial, Log, StepEnd, Variable};
use serde::{Serialize, de::DeserializeOwned};
use std::fmt;

/// A model that can be exported: its state is `Self`; parameters, inputs and outputs are plain structs.
///
/// The layer around it owns parameters, inputs, time, call order, saved states and messages; the model owns the physics.
/// All methods are called with parameters and inputs inside their declared bounds and finite.
pub trait Model: Clone + Serialize + DeserializeOwned + Send + 'static {
    /// FMI parameters, all of them.
    type Parameters: Clone + Serialize + DeserializeOwned + Send + 'static;
    /// FMI inputs. The same type carries their time derivatives and the seeds of directional derivatives, so `Default` must be zero.
    type Input: Copy + Default + Serialize + DeserializeOwned + Send + 'static;
    /// FMI outputs and locals.
    type Output: Copy + Default + Send + 'static;
    /// What outputs, derivatives and the step have in common, computed once for a state, parameters and inputs. `()` where there
    /// is nothing to share.
    type Evaluation: Evaluation<Self>;

    /// Names, default experiment, files.
    const INFO: Info;

    /// The table of variables: the single source of value references, get and set, and `modelDescription.xml`.
    fn variables() -> &'static [Variable<Self>];

    /// Start values of parameters and inputs.
    fn defaults() -> (Self::Parameters, Self::Input);

    /// The state at the start time `t`, s. Called at the end of initialization, and before whenever an output is asked for after
    /// something was set. The place for checks across several parameters.
    fn initialize(p: &Self::Parameters, u: &Self::Input, t: f64) -> Result<Self, ModelError>;

    /// Take over tunable parameters changed after initialization. On `Err`, `self` must be as before.
    /// A model that reads `p` in each call and caches nothing keeps this default.
    fn tune(&mut self, _p: &Self::Parameters) -> Result<(), ModelError> {
        Ok(())
    }

    /// Outputs of the state and the CURRENT inputs; called once per change of either. Must not give NaN or infinity.
    fn output(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
    ) -> Result<Self::Output, ModelError>;

    /// Advance from `t` by `h`, both s; `now` belongs to the state and `u.value()`. On `Err`, `self` must be as before: compute in
    /// locals, commit at the end; the importer may then try a smaller step. Nearly always the answer is [`StepEnd::WHOLE`].
    fn step(
        &mut self,
        p: &Self::Parameters,
        u: &InputPolynomial<Self::Input>,
        now: &Self::Evaluation,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError>;

    /// First time derivative of the outputs, with inputs `u` changing at `u_dot` (per s).
    /// Only called if [`Info::with_output_derivatives`] is declared.
    fn output_derivative(
        &self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _now: &Self::Evaluation,
        _u_dot: &Self::Input,
    ) -> Result<Self::Output, ModelError> {
        Err(ModelError::new("output_derivative is not implemented"))
    }

    /// Directional derivative `∂output/∂input · du` at fixed state.
    /// Only called if [`Info::with_directional_derivatives`] is declared.
    fn directional_derivative(
        &self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _now: &Self::Evaluation,
        _du: &Self::Input,
    ) -> Result<Self::Output, ModelError> {
        Err(ModelError::new("directional_derivative is not implemented"))
    }

    /// Adjoint derivative `weights · ∂output/∂input` at fixed state, one number in each Real input. There is a weight for each element of
    /// the Real outputs and local variables, in the order of the table. This default takes one directional derivative for each
    /// Real input; a model that has a shorter way overrides it.
    /// Only called if [`Info::with_directional_derivatives`] is declared.
    fn adjoint_derivative(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
        weights: &[f64],
    ) -> Result<Self::Input, ModelError> {
        adjoint_by_columns(self, p, u, now, weights)
    }

    /// Where the model's messages are, if it has any: asked for before and after `tune` and `step`, and after `initialize`.
    fn log(&mut self) -> Option<&mut Log> {
        None
    }

    /// A warning that arose in the last `initialize`, `tune` or `step`, handed out once. It is logged; the call still succeeds.
    fn take_warning(&mut self) -> Option<String> {
        None
    }
}

/// Work that outputs, derivatives and the step share: the layer makes it when one of them first needs it, hands it to each of
/// them, and drops it when the state, a parameter or an input changes. Inputs that [`of`](Self::of) does not read say so by
/// [`Variable::beside_evaluation`]; setting them keeps it.
pub trait Evaluation<M: Model>: Sized + Send + 'static {
    /// The evaluation of this state, with these parameters and inputs.
    fn of(model: &M, p: &M::Parameters, u: &M::Input) -> Result<Self, ModelError>;
}

impl<M: Model> Evaluation<M> for () {
    #[inline]
    fn of(_model: &M, _p: &M::Parameters, _u: &M::Input) -> Result<Self, ModelError> {
        Ok(())
    }
}

/// Why a model could not do what was asked; the text goes to the importer's log.
///
/// Any error type converts into it with `?`.
pub struct ModelError(String);

impl ModelError {
    /// An error with this text. Name the variable, its value and what is allowed.
    pub fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

impl<E: std::error::Error> From<E> for ModelError {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Debug for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
