//! The one trait a model implements.

use crate::{Info, InputPolynomial, Variable};
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

    /// Names, default experiment, files.
    const INFO: Info;

    /// The table of variables: the single source of value references, get and set, and `modelDescription.xml`.
    fn variables() -> &'static [Variable<Self>];

    /// Start values of parameters and inputs.
    fn defaults() -> (Self::Parameters, Self::Input);

    /// The state at the start time `t`, s. Called on fmi2ExitInitializationMode and whenever an output is asked for in
    /// Initialization Mode after something was set. The place for checks across several parameters.
    fn initialize(p: &Self::Parameters, u: &Self::Input, t: f64) -> Result<Self, ModelError>;

    /// Take over tunable parameters changed after initialization. On `Err`, `self` must be as before.
    /// A model that reads `p` in each call and caches nothing keeps this default.
    fn tune(&mut self, _p: &Self::Parameters) -> Result<(), ModelError> {
        Ok(())
    }

    /// Outputs of the state and the CURRENT inputs; called once per change of either. Must not give NaN or infinity.
    fn output(&self, p: &Self::Parameters, u: &Self::Input) -> Result<Self::Output, ModelError>;

    /// Advance from `t` by `h`, both s. On `Err`, `self` must be as before: compute in locals, commit at the end.
    /// `Err` becomes fmi2Discard, so the importer may try a smaller step.
    fn step(
        &mut self,
        p: &Self::Parameters,
        u: &InputPolynomial<Self::Input>,
        t: f64,
        h: f64,
    ) -> Result<(), ModelError>;

    /// The inputs held after a step of `h` s until the importer sets them again: by default their polynomial at `h`.
    /// Override it where one input is known to be the rate of another.
    fn extrapolate(_p: &Self::Parameters, u: &InputPolynomial<Self::Input>, h: f64) -> Self::Input {
        u.at::<Self>(h)
    }

    /// First time derivative of the outputs, with inputs `u` changing at `u_dot` (per s).
    /// Only called if [`Info::with_output_derivatives`] is declared.
    fn output_derivative(
        &self,
        _p: &Self::Parameters,
        _u: &Self::Input,
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
        _du: &Self::Input,
    ) -> Result<Self::Output, ModelError> {
        Err(ModelError::new("directional_derivative is not implemented"))
    }

    /// A warning that arose in the last `initialize`, `tune` or `step`, handed out once. It is logged; the call still returns fmi2OK.
    fn take_warning(&mut self) -> Option<String> {
        None
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
