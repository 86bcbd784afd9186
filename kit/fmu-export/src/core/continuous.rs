//! Models that are differential equations with events: what Model Exchange, and a solver of the
//! layer, need of them beside [`Model`].

use super::error::ModelError;
use super::event::Event;
use super::model::{Model, ModelExchange, Variable};
use super::sizes;

/// A model whose equations an importer can integrate: states that its derivatives move
/// continuously, and events that change anything else.
///
/// Each state is a Real output or local variable of the table. Its derivative, and each event
/// indicator, is a variable behind the table. A model that is also to be exported for Model
/// Exchange says so in its `impl Model`:
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
/// All methods are called with parameters and inputs inside their declared bounds and finite, and
/// with finite states.
pub trait Continuous: Model {
    /// A row for the derivative of each state, [`Variable::derivative_of`] a scalar or
    /// [`Variable::derivatives_of`] a vector of the table, in the order of the states. What they
    /// depend on are inputs and states, by name.
    fn derivative_rows() -> &'static [Variable<Self>];
    /// A row for each event indicator, [`Variable::indicator`].
    const INDICATORS: &'static [Variable<Self>] = &[];
    /// Whether [`directional`](Self::directional) is written; differences take its place.
    const HAS_DIRECTIONAL: bool = false;

    /// Reads the states, in their units, into `x`.
    fn states(&self, x: &mut [f64]);

    /// The inverse of [`states`](Self::states).
    fn set_states(&mut self, x: &[f64]);

    /// Writes the time derivative of each state, per s, where the state is in `dx`. That is a copy
    /// of some state of the model, of which nothing else is looked at.
    fn derivatives(
        &self,
        p: &Self::Parameters,
        u: &Self::Input,
        now: &Self::Evaluation,
        t: f64,
        dx: &mut Self,
    ) -> Result<(), ModelError>;

    /// Writes the event indicators into `z`. Something happens where one of them passes from
    /// positive to not positive or back: whoever integrates stops just behind that place and calls
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

    /// Does what happens at the time `t`, s, if anything: changes of discrete states, jumps of
    /// continuous ones. It is called after the initialization, at events, and where inputs have
    /// jumped. On `Err`, `self` must be as before.
    fn event(
        &mut self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _t: f64,
    ) -> Result<Event, ModelError> {
        Ok(Event::NONE)
    }

    /// Called when an integrator has accepted a step to `t`, s; whether [`event`](Self::event) must
    /// be called there.
    fn completed_step(
        &mut self,
        _p: &Self::Parameters,
        _u: &Self::Input,
        _t: f64,
    ) -> Result<bool, ModelError> {
        Ok(false)
    }

    /// How derivatives (into `dx`) and, where they are asked for, outputs (into `y`) change along a
    /// change of the states (in `seed.0`) and of the inputs (`seed.1`): the Jacobian times that
    /// direction. Only called if [`HAS_DIRECTIONAL`](Self::HAS_DIRECTIONAL).
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

/// Where the equations are looked at: parameters, inputs, their evaluation, and time, s.
pub(crate) type EvaluationPoint<'a, M> = (
    &'a <M as Model>::Parameters,
    &'a <M as Model>::Input,
    &'a <M as Model>::Evaluation,
    f64,
);

impl<M: Model> ModelExchange<M> {
    /// Writes the derivatives of all states into `dx`. `rate` is a copy of some state of the model.
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

    /// The derivatives of all `states`, and behind them the event indicators, in `numbers`.
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

    /// How the outputs change along a change of the states, `dx`, and of the inputs, `du`. In the
    /// place of `dx` comes how the derivatives change. None where the model does not say it.
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
    /// What `impl Continuous` says, for [`Model::MODEL_EXCHANGE`].
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
