//! [`Continuous`]: what a model of differential equations with events implements in addition to
//! [`Model`], for Model Exchange and for the solvers of this crate.

use super::error::ModelError;
use super::event::Event;
use super::model::{Model, ModelExchange, Variable};
use super::sizes;

/// A model whose equations an importer can integrate: continuous states with derivatives, and
/// events that change states discontinuously.
///
/// Each state is a Real output or local variable of the table. The derivatives and the event
/// indicators have rows of their own, whose value references follow those of the table. A model
/// that is also exported for Model Exchange says so in its `impl Model`:
///
/// ```
/// # use fmu_export::*; use serde::{Deserialize, Serialize};
/// # #[derive(Clone, Copy, Default, Serialize, Deserialize)] struct Nothing;
/// # #[derive(Clone, Copy, Default)] struct Output { height: f64, speed: f64 }
/// #[derive(Clone, Serialize, Deserialize)]
/// struct Ball { height: f64, speed: f64 }
///
/// impl Model for Ball {
///     const MODEL_EXCHANGE: Option<ModelExchange<Self>> = ModelExchange::from_continuous();
/// #   type Parameters = Nothing; type Input = Nothing; type Output = Output; type Evaluation = ();
/// #   const INFO: Info = Info::new("Ball", "ball");
/// #   fn variables() -> &'static [Variable<Self>] { const { &[row!(Variable<Ball>, output height, "Height").unit("m").depends_on(&[]).initially_depends_on(&[]),
/// #       row!(Variable<Ball>, output speed, "Speed").unit("m/s").depends_on(&[]).initially_depends_on(&[])] } }
/// #   fn defaults() -> (Nothing, Nothing) { (Nothing, Nothing) }
/// #   fn initialize(_: &Nothing, _: &Nothing, _: f64) -> Result<Self, ModelError> { Ok(Ball { height: 1.0, speed: 0.0 }) }
/// #   fn output(&self, _: &Nothing, _: &Nothing, _: &()) -> Result<Output, ModelError> { Ok(Output { height: self.height, speed: self.speed }) }
/// #   fn step(&mut self, _: &Nothing, _: &InputPolynomial<Nothing>, _: &(), _: f64, h: f64) -> Result<StepEnd, ModelError> { self.height += h * self.speed; Ok(StepEnd::WHOLE) }
///     // …
/// }
///
/// impl Continuous for Ball {
///     fn derivative_rows() -> &'static [Variable<Self>] {
///         const {
///             &[
///                 Variable::derivative_of("height").unit("m/s").depends_on(&["speed"]),
///                 Variable::derivative_of("speed").unit("m/s2").depends_on(&[]),
///             ]
///         }
///     }
///     const INDICATORS: &'static [Variable<Self>] =
///         &[Variable::indicator("impact", "Height above the ground").unit("m")];
///
///     fn states(&self, x: &mut [f64]) { x.copy_from_slice(&[self.height, self.speed]); }
///     fn set_states(&mut self, x: &[f64]) { (self.height, self.speed) = (x[0], x[1]); }
///     fn derivatives(&self, _p: &Nothing, _u: &Nothing, _now: &(), _t: f64, dx: &mut Self) -> Result<(), ModelError> {
///         (dx.height, dx.speed) = (self.speed, -9.81);
///         Ok(())
///     }
///     fn indicators(&self, _p: &Nothing, _u: &Nothing, _now: &(), _t: f64, z: &mut [f64]) -> Result<(), ModelError> {
///         z[0] = self.height;
///         Ok(())
///     }
///     fn event(&mut self, _p: &Nothing, _u: &Nothing, _t: f64) -> Result<Event, ModelError> {
///         if self.height <= 0.0 && self.speed < 0.0 { self.speed *= -0.7; }
///         Ok(Event::NONE)
///     }
/// }
/// # assert_eq!(check::<Ball>(), [""; 0]);
/// ```
///
/// Methods are called with finite states, and finite parameters and inputs within their bounds.
pub trait Continuous: Model {
    /// One row per state, in the order of the states: [`Variable::derivative_of`] for a scalar,
    /// [`Variable::derivatives_of`] for a vector. Each depends on inputs and states, by name.
    fn derivative_rows() -> &'static [Variable<Self>];
    /// A row for each event indicator, [`Variable::indicator`].
    const INDICATORS: &'static [Variable<Self>] = &[];
    /// Whether [`directional`](Self::directional) is implemented; else differences replace it.
    const HAS_DIRECTIONAL: bool = false;

    /// Reads the states, in their units, into `x`.
    fn states(&self, x: &mut [f64]);

    /// The inverse of [`states`](Self::states).
    fn set_states(&mut self, x: &[f64]);

    /// Writes the time derivative of each state, per s, into the field of that state in `dx`, a
    /// clone of a model that serves as storage: what its other fields hold does not matter.
    fn derivatives(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
        t: f64,
        dx: &mut Self,
    ) -> Result<(), ModelError>;

    /// Writes all event indicators, finite numbers, into `z`. An event occurs where one of them changes from
    /// positive to not positive or back: the integrator stops just after that time and calls
    /// [`event`](Self::event).
    fn indicators(
        &self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _now: &Self::Evaluation,
        _t: f64,
        _z: &mut [f64],
    ) -> Result<(), ModelError> {
        Ok(())
    }

    /// Handles an event at the time `t`, s: changes discrete states, or lets continuous ones jump.
    /// Called after initialization, at events, and when inputs have jumped; there may be nothing to
    /// do. On `Err`, `self` must be as before.
    fn event(
        &mut self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _t: f64,
    ) -> Result<Event, ModelError> {
        Ok(Event::NONE)
    }

    /// Called when the integrator has accepted a step to `t`, s. Returns whether
    /// [`event`](Self::event) must be called there.
    fn completed_step(
        &mut self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _t: f64,
    ) -> Result<bool, ModelError> {
        Ok(false)
    }

    /// The Jacobian times a direction: the changes of the derivatives (into `dx`) and, if
    /// requested, of the outputs (into `y`) for a change of the states (`seed.0`) and of the inputs
    /// (`seed.1`). Only called if [`HAS_DIRECTIONAL`](Self::HAS_DIRECTIONAL).
    #[expect(clippy::too_many_arguments, reason = "what it is a derivative of")]
    fn directional(
        &self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _now: &Self::Evaluation,
        _t: f64,
        _seed: (&Self, &Self::Input),
        _dx: &mut Self,
        _y: Option<&mut Self::Output>,
    ) -> Result<(), ModelError> {
        Err(ModelError::new("directional is not implemented"))
    }
}

/// Where the equations are evaluated: parameters, inputs, their [`Evaluation`], and time, s.
pub(crate) type EvaluationPoint<'a, M> = (
    &'a <M as Model>::Parameters,
    &'a <M as Model>::Input,
    &'a <M as Model>::Evaluation,
    f64,
);

impl<M: Model> ModelExchange<M> {
    /// Writes the derivatives of all states into `dx`; `rate` is a scratch copy of the model.
    pub(crate) fn write_derivatives(
        &self,
        model: &M,
        (p, u, now, t): EvaluationPoint<M>,
        rate: &mut M,
        dx: &mut [f64],
    ) -> Result<(), ModelError> {
        (self.differentiate)(model, p, u, now, t, rate)?;
        (self.states)(rate, dx);
        Ok(())
    }

    /// Writes the derivatives of all `states` into `numbers`, followed by the event indicators.
    pub(crate) fn derivatives_and_indicators(
        &self,
        model: &M,
        at: EvaluationPoint<M>,
        rate: &mut M,
        states: usize,
        numbers: &mut [f64],
    ) -> Result<(), ModelError> {
        let (dx, z) = numbers.split_at_mut(states);
        self.write_derivatives(model, at, rate, dx)?;
        let (p, u, now, t) = at;
        (self.indicate)(model, p, u, now, t, z)
    }

    /// The change of the outputs for a change `dx` of the states and `du` of the inputs; `dx` is
    /// replaced by the change of the derivatives. None if the model does not implement it.
    pub(crate) fn directional_derivative(
        &self,
        model: &M,
        (p, u, now, t): EvaluationPoint<M>,
        dx: &mut [f64],
        du: &M::Input,
    ) -> Option<Result<M::Output, ModelError>> {
        let directional = self.directional?;
        let (mut seed, mut rate) = (model.clone(), model.clone());
        (self.set_states)(&mut seed, dx);
        let mut dy = sizes::output::<M>(p);
        let done = directional(model, p, u, now, t, (&seed, du), &mut rate, Some(&mut dy));
        (self.states)(&rate, dx);
        Some(done.map(|()| dy))
    }
}

impl<M: Continuous> ModelExchange<M> {
    /// The equations of an `impl Continuous`, for [`Model::MODEL_EXCHANGE`].
    pub const fn from_continuous() -> Option<Self> {
        Some(Self {
            derivatives: M::derivative_rows,
            indicators: M::INDICATORS,
            states: M::states,
            set_states: M::set_states,
            differentiate: M::derivatives,
            indicate: M::indicators,
            event: M::event,
            completed_step: M::completed_step,
            directional: if M::HAS_DIRECTIONAL {
                Some(M::directional)
            } else {
                None
            },
        })
    }
}
