//! [`Model`], the trait that a model implements, and [`Variable`], a row of its table of variables.

use super::causality::{Causality, Dependencies};
use super::enumeration::Enumeration;
use super::error::ModelError;
use super::event::{Event, Tick};
use super::impl_copy::impl_copy;
use super::info::Info;
use super::input::InputPolynomial;
use super::length::{Length, Resize};
use super::log::Log;
use super::packed_file::PackedFile;
use super::solver_workspace::SolverWorkspace;
use super::step_end::StepEnd;
use super::storage::{Accessor, Storage, each};
use super::type_definition::TypeDefinition;
use fmi_units::Unit;
use serde::{Serialize, de::DeserializeOwned};
use std::path::Path;

/// Setter of a String parameter: receives the parameters, the text, and the FMU's resources folder
/// if the importer gave one.
pub type SetString<M> =
    fn(&mut <M as Model>::Parameters, &str, Option<&Path>) -> Result<(), String>;

/// A model that can be exported: its state is `Self`; parameters, inputs and outputs are plain
/// structs.
///
/// This crate manages parameters, inputs, time, call order, saved states and messages; the model
/// does the physics. All methods are called with finite parameters and inputs within their bounds.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a model",
    note = "write `impl Model for {Self}`, or `impl Ode for {Self}` where `{Self}` derives `State`"
)]
pub trait Model: Clone + Serialize + DeserializeOwned + Send + 'static {
    /// FMI parameters, all of them.
    type Parameters: Clone + Serialize + DeserializeOwned + Send + 'static;
    /// FMI inputs. The type also holds their time derivatives and the seeds of directional
    /// derivatives, so `Default` must be zero.
    type Input: Clone + Default + Serialize + DeserializeOwned + Send + 'static;
    /// FMI outputs and local variables.
    type Output: Clone + Default + Send + 'static;
    /// Results that outputs, derivatives and the step share, computed once for a state, parameters
    /// and inputs; `()` if there are none.
    type Evaluation: Evaluation<Self>;

    /// Names, default experiment, files.
    const INFO: Info;

    /// The equations of a model that supports Model Exchange:
    /// [`ModelExchange::from_continuous`]`()` if it implements [`Continuous`](crate::Continuous).
    const MODEL_EXCHANGE: Option<ModelExchange<Self>> = None;

    /// The equations of a model whose events the crate handles in Co-Simulation too: at the end of
    /// initialization, within steps, and in Event Mode of FMI 3.0. None: its own `step` handles them.
    #[doc(hidden)]
    const EVENTS: Option<ModelExchange<Self>> = None;

    /// The clocks of the model, whose value references follow all others. An importer of FMI 3.0
    /// ticks them; in FMI 2.0, and for importers without Event Mode, the crate does.
    const CLOCKS: &'static [Clock<Self>] = &[];

    /// Whether the FMU offers Scheduled Execution, in which the importer computes each clock's part
    /// of the model by itself; only for a model that has clocks and no continuous states.
    const SCHEDULED_EXECUTION: bool = false;

    /// The table of variables, from which value references, getters and setters, and
    /// `modelDescription.xml` are made.
    fn variables() -> &'static [Variable<Self>];

    /// Start values of parameters and inputs.
    fn defaults() -> (Self::Parameters, Self::Input);

    /// The state at the start time `t`, s. Called at the end of initialization, and earlier when an
    /// output is read after something was set. Relations between parameters are checked here.
    fn initialize(p: &Self::Parameters, u: &Self::Input, t: f64) -> Result<Self, ModelError>;

    /// Adopts tunable parameters that were changed after initialization. On `Err`, `self` must be
    /// as before. A model that reads `p` in each call and caches nothing keeps this default.
    fn tune(&mut self, _p: &Self::Parameters) -> Result<(), ModelError> {
        Ok(())
    }

    /// The outputs, finite, for the state and the CURRENT inputs; called once per change of either.
    fn output(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
    ) -> Result<Self::Output, ModelError>;

    /// Writes the outputs into `y`, for outputs that contain a `Vec`, which then need not be
    /// allocated anew. The default calls [`output`](Self::output).
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

    /// The same at the time `t`, s, for outputs that depend on it; needs
    /// [`HAS_TIMED_OUTPUTS`](Self::HAS_TIMED_OUTPUTS). [`check`](crate::check) looks at the outputs at
    /// the start time, by [`output`](Self::output).
    #[inline]
    fn output_at(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
        _t: f64,
        y: &mut Self::Output,
    ) -> Result<(), ModelError> {
        self.output_into(p, u, now, y)
    }

    /// Whether [`output_at`](Self::output_at) is implemented.
    const HAS_TIMED_OUTPUTS: bool = false;

    /// Advances from `t` by `h`, both s; `now` is the evaluation of the state and `u.value()`. On
    /// `Err`, `self` must be as before: compute in locals, commit at the end; the importer may then
    /// try a smaller step. The usual result is [`StepEnd::WHOLE`].
    fn step(
        &mut self,
        p: &Self::Parameters,
        u: &InputPolynomial<Self::Input>,
        now: &Self::Evaluation,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError>;

    /// [`step`](Self::step) with a solver's workspace, which the instance keeps between steps.
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

    /// Adjoint derivative `weights · ∂output/∂input` at fixed state, in the Real inputs of the
    /// result. There is a weight for each element of the Real outputs and local variables, in the
    /// order of the table. The default computes one directional derivative for each Real input.
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

    /// The model's log, if any; used before and after `tune` and `step`, and after `initialize`.
    fn log(&mut self) -> Option<&mut Log> {
        None
    }

    /// A warning from the last `initialize`, `tune` or `step`, to be logged; the call succeeds.
    fn take_warning(&mut self) -> Option<String> {
        None
    }
}

/// Results that outputs, derivatives and the step share. The instance computes them when one of
/// these first needs them, passes them to each, and drops them when the state, a parameter or an
/// input changes, except an input with [`Variable::not_in_evaluation`].
pub trait Evaluation<M: Model>: Sized + Send + 'static {
    /// Computes the results for this state, parameters and inputs.
    fn new(model: &M, p: &M::Parameters, u: &M::Input) -> Result<Self, ModelError>;
}

impl<M: Model> Evaluation<M> for () {
    #[inline]
    fn new(_model: &M, _p: &M::Parameters, _u: &M::Input) -> Result<Self, ModelError> {
        Ok(())
    }
}

/// A row of the table: a variable's name, field in the model's structs, and FMI attributes.
///
/// Constructors take (name, description, accessors). Singular ones (`input`, `integer_output` …)
/// make a scalar, plural ones a vector, as long as the slice in the start values.
pub struct Variable<M: Model> {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) causality: Causality,
    pub(crate) storage: Storage<M::Parameters, M::Input, M::Output>,
    /// `x`, not `x[1]`.
    pub(crate) scalar: bool,
    /// The length of each dimension; empty: one dimension, as long as the slice.
    pub(crate) shape: &'static [Length],
    /// Changes the length of the row's `Vec`.
    pub(crate) resize: Option<Resize<M::Parameters, M::Input, M::Output>>,
    /// A size, which may be the length of other rows.
    pub(crate) structural: bool,
    pub(crate) tunable: bool,
    pub(crate) discrete: bool,
    /// The clocks that it belongs to.
    pub(crate) clocks: &'static [&'static str],
    /// The variable with its value at the tick before.
    pub(crate) previous: Option<&'static str>,
    /// Not read by the model's [`Evaluation`](crate::Evaluation).
    pub(crate) not_in_evaluation: bool,
    /// String setters read this parameter.
    pub(crate) read_by_string_setters: bool,
    /// The file that the start value of a String parameter stands for.
    pub(crate) packed_file: Option<PackedFile>,
    /// Counts how often the importer has set this input.
    pub(crate) counter: Option<fn(&mut M::Input) -> &mut u32>,
    /// Value reference of the first element; None: the next one.
    pub(crate) at: Option<u32>,
    pub(crate) unit: Option<&'static str>,
    /// The row's own definition of `unit`.
    pub(crate) own_unit: Option<&'static Unit>,
    /// The unit of the derivative, if the row is a state.
    pub(crate) rate_unit: Option<&'static str>,
    /// Units element by element, where they differ.
    pub(crate) each_unit: &'static [&'static str],
    pub(crate) display_unit: Option<&'static str>,
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) nominal: Option<f64>,
    pub(crate) enumeration: Option<Enumeration>,
    /// The type of a Real row.
    pub(crate) declared_type: Option<&'static TypeDefinition>,
    /// Further names, with descriptions.
    pub(crate) aliases: &'static [(&'static str, &'static str)],
    /// The row has one of them.
    pub(crate) is_alias: bool,
    /// What the bytes of a Binary row are.
    pub(crate) mime_type: &'static str,
    /// The input or output of which this one is the time derivative.
    pub(crate) rate_of: Option<&'static str>,
    /// The dependencies of the derivative, if the row is a state.
    pub(crate) rate_dependencies: Option<&'static [&'static str]>,
    pub(crate) dependencies: Dependencies,
    pub(crate) initial_dependencies: Dependencies,
}

impl_copy! { [M: Model] Variable<M>; }

/// What a clock computes at a tick, of parameters and inputs. On `Err` the tick has not been.
pub type OnTick<M> =
    fn(&mut M, &<M as Model>::Parameters, &<M as Model>::Input, Tick) -> Result<(), ModelError>;

/// A clock of a model, a row of [`Model::CLOCKS`](crate::Model::CLOCKS). Clocks that tick at one
/// time do so in the order of that table, which is that of their priorities.
///
/// Variables belong to a clock by [`Variable::clocks`], with derives `#[fmu(clock = sample)]`.
pub struct Clock<M: Model> {
    pub(crate) row: Variable<M>,
    pub(crate) timing: Timing<M>,
    /// Delay of the first tick of a periodic clock, s.
    pub(crate) shift: f64,
    /// An output clock that ticks in the instant after the one that has caused it.
    pub(crate) ticks_later: bool,
    pub(crate) on_tick: OnTick<M>,
}

/// When a clock ticks.
pub(crate) enum Timing<M: Model> {
    Constant(f64),
    Fixed(f64),
    Calculated(fn(&M::Parameters) -> f64),
    Tunable(fn(&M::Parameters) -> f64),
    Changing(fn(&M, &M::Parameters) -> f64),
    Countdown(fn(&mut M) -> Option<f64>),
    Triggered,
    Output(fn(&mut M) -> bool),
}

impl_copy! { [M: Model] Clock<M>; [M: Model] Timing<M>; }

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

/// A function of model, parameters, inputs, evaluation and time, which writes its result.
type Equations<M, X> = fn(
    &M,
    &<M as Model>::Parameters,
    &<M as Model>::Input,
    &<M as Model>::Evaluation,
    f64,
    &mut X,
) -> Result<(), ModelError>;

/// A function that changes the model, of parameters, inputs and time.
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
    /// The rows of derivatives and event indicators, which follow those of the table.
    pub(crate) fn rows() -> impl Iterator<Item = &'static Variable<M>> {
        (M::MODEL_EXCHANGE.into_iter()).flat_map(|x| (x.derivatives)().iter().chain(x.indicators))
    }
}

/// The values of all Real outputs and local variables, in order.
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

/// All elements of Real inputs: index in the row, and the row's accessor.
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

/// The adjoint derivative from directional derivatives, one for each column of ∂output/∂input.
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

/// Zero inputs, with vectors as long as those of `like`.
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

/// Zero derivatives of the inputs.
pub(crate) fn zeros<M: Model>(like: &M::Input) -> [M::Input; crate::MAX_INPUT_DERIVATIVE] {
    std::array::from_fn(|_| zero::<M>(like))
}
