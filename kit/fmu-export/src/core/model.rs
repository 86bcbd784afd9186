//! What a model implements, and what a row of its table of variables holds.

use super::causality::{Causality, Dependencies};
use super::enumeration::Enumeration;
use super::error::ModelError;
use super::event::Event;
use super::impl_copy::impl_copy;
use super::info::Info;
use super::input::InputPolynomial;
use super::length::{Length, Resize};
use super::log::Log;
use super::solver_workspace::SolverWorkspace;
use super::step_end::StepEnd;
use super::storage::{Accessor, Storage, each};
use super::unit::Unit;
use serde::{Serialize, de::DeserializeOwned};
use std::path::Path;

/// Setter of a String parameter: parameters, text, the FMU's resources folder if the importer gave
/// one.
pub type SetString<M> =
    fn(&mut <M as Model>::Parameters, &str, Option<&Path>) -> Result<(), String>;

/// A model that can be exported: its state is `Self`; parameters, inputs and outputs are plain
/// structs.
///
/// The layer around it owns parameters, inputs, time, call order, saved states and messages; the
/// model owns the physics. All methods are called with parameters and inputs inside their declared
/// bounds and finite.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a model",
    note = "write `impl Model for {Self}`, or `impl Ode for {Self}` where `{Self}` derives `State`"
)]
pub trait Model: Clone + Serialize + DeserializeOwned + Send + 'static {
    /// FMI parameters, all of them.
    type Parameters: Clone + Serialize + DeserializeOwned + Send + 'static;
    /// FMI inputs. The same type carries their time derivatives and the seeds of directional
    /// derivatives, so `Default` must be zero.
    type Input: Clone + Default + Serialize + DeserializeOwned + Send + 'static;
    /// FMI outputs and locals.
    type Output: Clone + Default + Send + 'static;
    /// What outputs, derivatives and the step have in common, computed once for a state, parameters
    /// and inputs. `()` where there is nothing to share.
    type Evaluation: Evaluation<Self>;

    /// Names, default experiment, files.
    const INFO: Info;

    /// The equations of a model that is exported for Model Exchange too:
    /// [`ModelExchange::from_continuous`]`()`, which is those of [`Continuous`](crate::Continuous).
    const MODEL_EXCHANGE: Option<ModelExchange<Self>> = None;

    /// The table of variables: the single source of value references, get and set, and
    /// `modelDescription.xml`.
    fn variables() -> &'static [Variable<Self>];

    /// Start values of parameters and inputs.
    fn defaults() -> (Self::Parameters, Self::Input);

    /// The state at the start time `t`, s. Called at the end of initialization, and before whenever
    /// an output is asked for after something was set. The place for checks across several
    /// parameters.
    fn initialize(p: &Self::Parameters, u: &Self::Input, t: f64) -> Result<Self, ModelError>;

    /// Take over tunable parameters changed after initialization. On `Err`, `self` must be as
    /// before. A model that reads `p` in each call and caches nothing keeps this default.
    fn tune(&mut self, _p: &Self::Parameters) -> Result<(), ModelError> {
        Ok(())
    }

    /// Outputs of the state and the CURRENT inputs; called once per change of either. Must not give
    /// NaN or infinity.
    fn output(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
    ) -> Result<Self::Output, ModelError>;

    /// Writes the outputs to where they are kept, [`output`](Self::output) if this is not written:
    /// for outputs that hold vectors, so that these stay where they are.
    #[inline]
    fn output_into(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
        y: &mut Self::Output,
    ) -> Result<(), ModelError> {
        *y = self.output(p, u, now)?;
        Ok(())
    }

    /// Advance from `t` by `h`, both s; `now` belongs to the state and `u.value()`. On `Err`,
    /// `self` must be as before: compute in locals, commit at the end; the importer may then try a
    /// smaller step. Nearly always the answer is [`StepEnd::WHOLE`].
    fn step(
        &mut self,
        p: &Self::Parameters,
        u: &InputPolynomial<Self::Input>,
        now: &Self::Evaluation,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError>;

    /// [`step`](Self::step) with room for a solver, which the layer keeps from step to step.
    #[doc(hidden)]
    #[inline(always)]
    fn step_with_workspace(
        &mut self,
        _workspace: &mut SolverWorkspace<Self, Self::Input>,
        p: &Self::Parameters,
        u: &InputPolynomial<Self::Input>,
        now: &Self::Evaluation,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        self.step(p, u, now, t, h)
    }

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

    /// Adjoint derivative `weights · ∂output/∂input` at fixed state, one number in each Real input.
    /// There is a weight for each element of the Real outputs and local variables, in the order of
    /// the table. This default takes one directional derivative for each Real input; a model that
    /// has a shorter way overrides it. Only called if [`Info::with_directional_derivatives`] is
    /// declared.
    fn adjoint_derivative(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
        weights: &[f64],
    ) -> Result<Self::Input, ModelError> {
        adjoint_by_columns(self, p, u, now, weights)
    }

    /// Where the model's messages are, if it has any: asked for before and after `tune` and `step`,
    /// and after `initialize`.
    fn log(&mut self) -> Option<&mut Log> {
        None
    }

    /// A warning that arose in the last `initialize`, `tune` or `step`, handed out once. It is
    /// logged; the call still succeeds.
    fn take_warning(&mut self) -> Option<String> {
        None
    }
}

/// Work that outputs, derivatives and the step share: the layer makes it when one of them first
/// needs it, hands it to each of them, and drops it when the state, a parameter or an input
/// changes. Inputs that [`new`](Self::new) does not read say so by [`Variable::not_in_evaluation`];
/// setting them keeps it.
pub trait Evaluation<M: Model>: Sized + Send + 'static {
    /// The evaluation of this state, with these parameters and inputs.
    fn new(model: &M, p: &M::Parameters, u: &M::Input) -> Result<Self, ModelError>;
}

impl<M: Model> Evaluation<M> for () {
    #[inline]
    fn new(_model: &M, _p: &M::Parameters, _u: &M::Input) -> Result<Self, ModelError> {
        Ok(())
    }
}

/// A row of the table: name, place in the model's structs, and what the model description says
/// about it.
///
/// Constructors take (name, description, accessors). Singular ones (`input`, `integer_output` …)
/// make a scalar, plural ones a vector, whose length is that of the slice in the default values and
/// must not change.
pub struct Variable<M: Model> {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) causality: Causality,
    pub(crate) storage: Storage<M::Parameters, M::Input, M::Output>,
    /// `x`, not `x[1]`.
    pub(crate) scalar: bool,
    /// How many elements it has in each dimension; empty: one dimension, as long as the slice.
    pub(crate) shape: &'static [Length],
    /// Makes the vector that it is in longer or shorter.
    pub(crate) resize: Option<Resize<M::Parameters, M::Input, M::Output>>,
    /// A size, which other rows have as a length.
    pub(crate) structural: bool,
    pub(crate) tunable: bool,
    pub(crate) discrete: bool,
    /// Not read by the model's [`Evaluation`](crate::Evaluation).
    pub(crate) not_in_evaluation: bool,
    /// String setters read this parameter.
    pub(crate) read_by_string_setters: bool,
    /// Counts how often the importer has set this input.
    pub(crate) counter: Option<fn(&mut M::Input) -> &mut u32>,
    /// Value reference of the first element; None: the next one.
    pub(crate) at: Option<u32>,
    pub(crate) unit: Option<&'static str>,
    /// The definition of `unit`, where the row brings it along.
    pub(crate) own_unit: Option<&'static Unit>,
    /// Units element by element, where they differ.
    pub(crate) each_unit: &'static [&'static str],
    pub(crate) display_unit: Option<&'static str>,
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) nominal: Option<f64>,
    pub(crate) enumeration: Option<Enumeration>,
    /// What the derivative depends on, where the row is a state.
    pub(crate) rate_dependencies: Dependencies,
    pub(crate) dependencies: Dependencies,
    pub(crate) initial_dependencies: Dependencies,
}

impl_copy! { [M: Model] Variable<M>; }

/// The equations of a model for Model Exchange: those of [`Continuous`](crate::Continuous).
pub struct ModelExchange<M: Model> {
    pub(crate) derivatives: fn() -> &'static [Variable<M>],
    pub(crate) indicators: &'static [Variable<M>],
    pub(crate) states: fn(&M, &mut [f64]),
    pub(crate) set_states: fn(&mut M, &[f64]),
    pub(crate) differentiate: Equations<M, M>,
    pub(crate) indicate: Equations<M, [f64]>,
    pub(crate) event: Change<M, Event>,
    pub(crate) completed_step: Change<M, bool>,
    pub(crate) directional: Option<Directional<M>>,
}

/// Parameters, inputs, evaluation and time, and where the result goes.
type Equations<M, X> = fn(
    &M,
    &<M as Model>::Parameters,
    &<M as Model>::Input,
    &<M as Model>::Evaluation,
    f64,
    &mut X,
) -> Result<(), ModelError>;

/// Parameters, inputs and time.
type Change<M, T> =
    fn(&mut M, &<M as Model>::Parameters, &<M as Model>::Input, f64) -> Result<T, ModelError>;

/// [`Continuous::directional`](crate::Continuous::directional).
type Directional<M> = fn(
    &M,
    &<M as Model>::Parameters,
    &<M as Model>::Input,
    &<M as Model>::Evaluation,
    f64,
    (&M, &<M as Model>::Input),
    &mut M,
    Option<&mut <M as Model>::Output>,
) -> Result<(), ModelError>;

impl_copy! { [M: Model] ModelExchange<M>; }

impl<M: Model> ModelExchange<M> {
    /// The rows behind the table.
    pub(crate) fn rows() -> impl Iterator<Item = &'static Variable<M>> {
        (M::MODEL_EXCHANGE.into_iter()).flat_map(|x| (x.derivatives)().iter().chain(x.indicators))
    }
}

/// Every element of the Real outputs and local variables, in order.
pub(crate) fn real_outputs<M: Model>(y: &M::Output) -> impl Iterator<Item = f64> {
    M::variables()
        .iter()
        .filter_map(|row| match &row.storage {
            Storage::RealOut(field) => Some(field.slice(y)),
            _ => None,
        })
        .flatten()
        .copied()
}

/// Every element of the Real inputs: index in its row, and place.
pub(crate) fn real_inputs<M: Model>(
    u: &M::Input,
) -> impl Iterator<Item = (usize, &'static Accessor<M::Input, f64>)> {
    M::variables()
        .iter()
        .filter_map(|row| match &row.storage {
            Storage::RealIn(field) => Some(field),
            _ => None,
        })
        .flat_map(|field| (0..field.len(u)).map(move |i| (i, field)))
}

/// The adjoint derivative of a model from its directional derivatives: the columns of
/// ∂output/∂input one by one.
fn adjoint_by_columns<M: Model>(
    model: &M,
    p: &M::Parameters,
    u: &M::Input,
    now: &M::Evaluation,
    weights: &[f64],
) -> Result<M::Input, ModelError> {
    let (mut adjoint, mut du) = (zero::<M>(u), zero::<M>(u));
    for (i, field) in real_inputs::<M>(u) {
        *field.get_mut(&mut du, i) = 1.0;
        let column = model.directional_derivative(p, u, now, &du)?;
        *field.get_mut(&mut du, i) = 0.0;
        *field.get_mut(&mut adjoint, i) = (real_outputs::<M>(&column).zip(weights))
            .map(|(dy, weight)| weight * dy)
            .sum();
    }
    Ok(adjoint)
}

/// Inputs that are zero, with vectors as long as those of `like`.
pub(crate) fn zero<M: Model>(like: &M::Input) -> M::Input {
    let mut zero = M::Input::default();
    for row in M::variables() {
        let Some(Resize::Input(resize)) = row.resize else {
            continue;
        };
        if let Some(values) = row.storage.input_values(like) {
            resize(&mut zero, each!(Values, values, |values| values.len()));
        }
        if let Storage::RealIn(field) = &row.storage {
            field.slice_mut(&mut zero).fill(0.0);
        }
    }
    zero
}

/// As many of them as there are derivatives.
pub(crate) fn zeros<M: Model>(like: &M::Input) -> [M::Input; crate::MAX_INPUT_DERIVATIVE] {
    std::array::from_fn(|_| zero::<M>(like))
}
