//! [`Ode`], for authors who use derives: differential equations as [`Model`] and [`Continuous`].

use super::solver::{SolverName, solver};
use super::{Input, Name, Output, Parameters, Path};
use crate::core::sizes::{self, fit_start_values};
use crate::core::solver_step::solve;
use crate::core::solver_workspace::SolverWorkspace;
use crate::{
    Continuous, Event, Info, InputPolynomial, Log, Model, ModelError, ModelExchange, StepEnd,
    Variable,
};
use fmu_solver::Solver;
use serde::{Serialize, de::DeserializeOwned};
use std::marker::PhantomData;

/// The state of a model of ordinary differential equations; implemented by `#[derive(State)]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not the state of a model",
    note = "write `#[derive(State)] #[fmu(parameters = …, input = …, output = …)]` on it; what the model does not have is left out, but \
            one of the three must be there"
)]
pub trait State: Vector + Clone + Default + Serialize + DeserializeOwned + Send + 'static {
    /// The model's parameters.
    type P: Parameters + Send + 'static;
    /// The model's inputs.
    type U: Input + Send + 'static;
    /// The model's outputs in addition to its state.
    type Y: Output + Send + 'static;

    /// Name, default experiment and files.
    const INFO: Info;
    /// Longest internal step, s.
    const MAX_STEP: f64;
    /// The solver for Co-Simulation.
    const SOLVER: SolverName;
    /// The default tolerance, for solvers that use one.
    const TOLERANCE: f64;
    /// Whether the model supports Model Exchange.
    const MODEL_EXCHANGE: bool;

    /// The state at the start.
    fn start(p: &Self::P, u: &Self::U) -> Self;

    /// The table of variables: parameters, inputs, states, outputs.
    fn table() -> &'static [Variable<Self>]
    where
        Self: Model;

    /// The rows of the derivatives, for Model Exchange and solvers with step size control.
    fn derivatives() -> &'static [Variable<Self>]
    where
        Self: Model;
}

/// The continuous states in a field or struct, as a sequence of numbers.
#[expect(clippy::len_without_is_empty, reason = "a state has at least one")]
pub trait Vector: Sized {
    /// The number of states.
    fn len(&self) -> usize;

    /// Copies the states to the front of `to`; returns the rest of `to`.
    fn read<'a>(&self, to: &'a mut [f64]) -> &'a mut [f64];

    /// Sets the states from the front of `from`; returns the rest of `from`.
    fn write<'a>(&mut self, from: &'a [f64]) -> &'a [f64];

    /// Copies the states of all elements in order.
    #[inline]
    fn read_all<'a>(all: &[Self], to: &'a mut [f64]) -> &'a mut [f64] {
        all.iter().fold(to, |to, element| element.read(to))
    }

    /// The inverse of [`read_all`](Self::read_all).
    #[inline]
    fn write_all<'a>(all: &mut [Self], from: &'a [f64]) -> &'a [f64] {
        all.iter_mut()
            .fold(from, |from, element| element.write(from))
    }

    /// Name and value of the first state that is not finite.
    fn not_finite(&self) -> Option<(&'static str, f64)>;
}

/// A struct of states within that of a model: `#[derive(State)]` without further structs.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be a part of a state",
    label = "not a type of state",
    note = "a state is an f64, an array or a Vec of f64, or a struct with #[derive(State)]; with `#[fmu(discrete)]`, what only events \
            change, any type of variable; with `#[fmu(skip)]`, what is no variable, any type",
    note = "an enumeration is written `#[fmu(discrete)]` and `Choice<{Self}>`; the derives know types by their names, so an alias is not known"
)]
pub trait StatePart: Vector + Output {}

impl Vector for f64 {
    fn len(&self) -> usize {
        1
    }

    #[inline]
    fn read<'a>(&self, to: &'a mut [f64]) -> &'a mut [f64] {
        to[0] = *self;
        &mut to[1..]
    }

    #[inline]
    fn write<'a>(&mut self, from: &'a [f64]) -> &'a [f64] {
        *self = from[0];
        &from[1..]
    }

    #[inline]
    fn read_all<'a>(all: &[f64], to: &'a mut [f64]) -> &'a mut [f64] {
        let (to, rest) = to.split_at_mut(all.len());
        to.copy_from_slice(all);
        rest
    }

    #[inline]
    fn write_all<'a>(all: &mut [f64], from: &'a [f64]) -> &'a [f64] {
        let (from, rest) = from.split_at(all.len());
        all.copy_from_slice(from);
        rest
    }

    fn not_finite(&self) -> Option<(&'static str, f64)> {
        (!self.is_finite()).then_some(("", *self))
    }
}

macro_rules! vectors {
    ($([$($parameters:tt)*] $type:ty;)*) => {$(
        impl<T: Vector, $($parameters)*> Vector for $type {
            fn len(&self) -> usize {
                self.iter().map(T::len).sum()
            }

            #[inline]
            fn read<'a>(&self, to: &'a mut [f64]) -> &'a mut [f64] {
                T::read_all(self, to)
            }

            #[inline]
            fn write<'a>(&mut self, from: &'a [f64]) -> &'a [f64] {
                T::write_all(self, from)
            }

            fn not_finite(&self) -> Option<(&'static str, f64)> {
                self.iter().find_map(T::not_finite)
            }
        }
    )*};
}

vectors! { [const N: usize] [T; N]; [] Vec<T>; }

/// A model of ordinary differential equations: `x' = f(x, p, u, t)`, `y = g(x, p, u)`, x the state
/// `Self`.
///
/// In Co-Simulation the model is integrated by the Runge–Kutta method of order 4, in equal internal
/// steps of at most `#[fmu(max_step = …)]`, 1 ms by default. With `#[fmu(solver = "adaptive")]` or
/// `"stiff"`, internal steps are as long as the importer's tolerance allows
/// ([`solver`](crate::solver)). Events are located within internal steps. Inputs follow their
/// derivatives, if the importer sets them. A step that cannot be done is discarded.
///
/// With `#[fmu(model_exchange)]` on the state, importers can integrate the model themselves.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a model",
    note = "write `impl Ode for {Self}` with its equations, or `impl Model for {Self}`"
)]
pub trait Ode: State {
    /// Writes the time derivative of each continuous state, per s, into the field of that state in
    /// `dx`; the other fields of `dx` are not used.
    fn derivative(&self, p: &Self::P, u: &Self::U, t: f64, dx: &mut Self);

    /// Compares parameters and completes the state at the start, `t`, s, after the `start` values. An
    /// `Err` refuses the initialization with its text. States that it changes declare what of,
    /// `#[fmu(initially_depends_on(…))]`.
    fn begin(&mut self, _p: &Self::P, _u: &Self::U, _t: f64) -> Result<(), ModelError> {
        Ok(())
    }

    /// Whether the equations hold at this state, these inputs and this time. An `Err` ends the step
    /// with its text; solvers with a tolerance first try a shorter internal step.
    fn valid(&self, _p: &Self::P, _u: &Self::U, _t: f64) -> Result<(), ModelError> {
        Ok(())
    }

    /// Reacts to tunable parameters that were changed after initialization; see [`Model::tune`].
    fn tuned(&mut self, _p: &Self::P) -> Result<(), ModelError> {
        Ok(())
    }

    /// The log to which `begin`, `tuned` and `event` write warnings and other messages: a field
    /// `#[fmu(skip)] log: Log`.
    fn messages(&mut self) -> Option<&mut Log> {
        None
    }

    /// See [`Continuous::completed_step`]; of Model Exchange only.
    fn completed(&mut self, _p: &Self::P, _u: &Self::U, _t: f64) -> Result<bool, ModelError> {
        Ok(false)
    }

    /// Whether [`directional`](Self::directional) is implemented; else differences replace it.
    const HAS_DIRECTIONAL: bool = false;

    /// Writes the change of all derivatives, ∂f/∂x·δx + ∂f/∂u·δu, into `dx`, for a change `seed.0`
    /// of the states and `seed.1` of the inputs. The stiff solver computes its Jacobian with it,
    /// and importers may request it; [`check`](crate::check) compares it with differences.
    fn directional(
        &self,
        _p: &Self::P,
        _u: &Self::U,
        _t: f64,
        _seed: (&Self, &Self::U),
        _dx: &mut Self,
    ) {
    }

    /// The same for [`outputs`](Self::outputs), into `dy`, which is zero before.
    fn outputs_directional(
        &self,
        _p: &Self::P,
        _u: &Self::U,
        _seed: (&Self, &Self::U),
        _dy: &mut Self::Y,
    ) {
    }

    /// Event indicators: [`Variable::indicator`].
    const INDICATORS: &'static [Variable<Self>] = &[];

    /// See [`Continuous::indicators`].
    fn indicators(&self, _p: &Self::P, _u: &Self::U, _t: f64, _z: &mut [f64]) {}

    /// See [`Continuous::event`]. In Co-Simulation it is called at the end of initialization, at the
    /// events within steps, and where a step starts after something was set or at a time event.
    fn event(&mut self, _p: &Self::P, _u: &Self::U, _t: f64) -> Event {
        Event::NONE
    }

    /// The outputs in addition to the state. Required if `#[fmu(output = …)]` names a struct.
    fn outputs(&self, _p: &Self::P, _u: &Self::U) -> Self::Y {
        const {
            assert!(
                size_of::<Self::Y>() == 0,
                "`fn outputs` is missing in `impl Ode`: the model has a struct of outputs"
            );
        }
        Self::Y::default()
    }

    /// The same, written into `y`, whose `Vec`s have the right length. Implemented instead of
    /// [`outputs`](Self::outputs) for outputs that contain a `Vec`.
    #[inline]
    fn outputs_into(&self, p: &Self::P, u: &Self::U, y: &mut Self::Y) {
        *y = self.outputs(p, u);
    }
}

/// The FMI outputs of an [`Ode`]: its state and its outputs.
#[derive(Clone, Default)]
pub struct StateAndOutputs<S: State> {
    state: S,
    outputs: S::Y,
}

/// Paths to the fields of [`StateAndOutputs`].
macro_rules! paths {
    ($($(#[$doc:meta])* $path:ident to $field:ident: $type:ty;)*) => {$(
        $(#[$doc])*
        pub struct $path<S>(PhantomData<S>);

        impl<S: State> Path for $path<S> {
            type From = StateAndOutputs<S>;
            type To = $type;
            const NAME: Name = Name::EMPTY;

            #[inline]
            fn get(from: &StateAndOutputs<S>) -> &$type {
                &from.$field
            }

            #[inline]
            fn get_mut(from: &mut StateAndOutputs<S>) -> &mut $type {
                &mut from.$field
            }
        }
    )*};
}

paths! {
    /// The path to the state in [`StateAndOutputs`].
    StatePath to state: S;
    /// The path to the outputs in [`StateAndOutputs`].
    OutputsPath to outputs: S::Y;
}

impl<S: Ode> Model for S {
    type Parameters = S::P;
    type Input = S::U;
    type Output = StateAndOutputs<S>;
    type Evaluation = ();

    const INFO: Info = match S::SOLVER {
        SolverName::Fixed => S::INFO.with_input_derivatives(),
        _ => S::INFO
            .with_input_derivatives()
            .with_tolerance(S::TOLERANCE),
    };
    const MODEL_EXCHANGE: Option<ModelExchange<S>> = if S::MODEL_EXCHANGE {
        ModelExchange::from_continuous()
    } else {
        None
    };

    const EVENTS: Option<ModelExchange<S>> = ModelExchange::from_continuous();

    fn variables() -> &'static [Variable<Self>] {
        S::table()
    }

    fn defaults() -> (S::P, S::U) {
        fit_start_values::<S>((S::P::start(), S::U::start()))
    }

    fn initialize(p: &S::P, u: &S::U, t: f64) -> Result<Self, ModelError> {
        let mut state = S::start(p, u);
        state.begin(p, u, t)?;
        finite(state, "at the start")
    }

    fn tune(&mut self, p: &S::P) -> Result<(), ModelError> {
        let before = self.clone();
        self.tuned(p).inspect_err(|_| self.clone_from(&before))
    }

    fn log(&mut self) -> Option<&mut Log> {
        self.messages()
    }

    fn output(&self, p: &S::P, u: &S::U, now: &()) -> Result<StateAndOutputs<S>, ModelError> {
        let mut y = sizes::output::<S>(p);
        self.output_into(p, u, now, &mut y)?;
        Ok(y)
    }

    fn output_into(
        &self,
        p: &S::P,
        u: &S::U,
        _now: &(),
        y: &mut StateAndOutputs<S>,
    ) -> Result<(), ModelError> {
        y.state.clone_from(self);
        self.outputs_into(p, u, &mut y.outputs);
        Ok(())
    }

    fn step(
        &mut self,
        p: &S::P,
        u: &InputPolynomial<S::U>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        self.step_with_workspace(&mut SolverWorkspace::default(), p, u, &(), t, h)
    }

    fn step_with_workspace(
        &mut self,
        workspace: &mut SolverWorkspace<S, S::U>,
        p: &S::P,
        u: &InputPolynomial<S::U>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let n = self.len();
        solve(self, workspace, make_solver, n, state_name, (p, u), (t, h))
    }
}

/// The solver of a model like this one. Each state is set to its number, so that its row can read
/// the position of the state.
fn make_solver<S: Ode>(like: &S) -> Result<Solver, ModelError> {
    let numbers: Vec<f64> = (0..like.len()).map(|k| k as f64).collect();
    let (mut state, outputs) = (like.clone(), S::Y::default());
    state.write(&numbers);
    let sizes = (numbers.len(), <S as Ode>::INDICATORS.len());
    solver(
        S::SOLVER,
        sizes,
        S::derivatives(),
        &StateAndOutputs { state, outputs },
        S::MAX_STEP,
    )
}

/// The name of the state with this index, found by setting it to `value`, which is not finite.
fn state_name<S: Ode>(x: &mut S, state: usize, value: f64) -> &'static str {
    let mut states = vec![0.0; x.len()];
    states[state] = value;
    x.write(&states);
    x.not_finite().map_or("", |(name, _)| name)
}

impl<S: Ode> Continuous for S {
    fn derivative_rows() -> &'static [Variable<S>] {
        S::derivatives()
    }

    const INDICATORS: &'static [Variable<S>] = <S as Ode>::INDICATORS;
    const HAS_DIRECTIONAL: bool = <S as Ode>::HAS_DIRECTIONAL;

    #[inline]
    fn states(&self, x: &mut [f64]) {
        self.read(x);
    }

    #[inline]
    fn set_states(&mut self, x: &[f64]) {
        self.write(x);
    }

    #[inline]
    fn derivatives(
        &self,
        p: &S::P,
        u: &S::U,
        _now: &(),
        t: f64,
        dx: &mut S,
    ) -> Result<(), ModelError> {
        self.valid(p, u, t)?;
        self.derivative(p, u, t, dx);
        Ok(())
    }

    fn directional(
        &self,
        p: &S::P,
        u: &S::U,
        _now: &(),
        t: f64,
        seed: (&S, &S::U),
        dx: &mut S,
        y: Option<&mut StateAndOutputs<S>>,
    ) -> Result<(), ModelError> {
        Ode::directional(self, p, u, t, seed, dx);
        if let Some(y) = y {
            // All but the continuous states stays zero.
            let mut x = vec![0.0; self.len()];
            seed.0.read(&mut x);
            y.state.write(&x);
            self.outputs_directional(p, u, seed, &mut y.outputs);
        }
        Ok(())
    }

    fn indicators(
        &self,
        p: &S::P,
        u: &S::U,
        _now: &(),
        t: f64,
        z: &mut [f64],
    ) -> Result<(), ModelError> {
        Ode::indicators(self, p, u, t, z);
        Ok(())
    }

    fn event(&mut self, p: &S::P, u: &S::U, t: f64) -> Result<Event, ModelError> {
        Ok(Ode::event(self, p, u, t))
    }

    fn completed_step(&mut self, p: &S::P, u: &S::U, t: f64) -> Result<bool, ModelError> {
        self.completed(p, u, t)
    }
}

fn finite<S: State>(x: S, when: &str) -> Result<S, ModelError> {
    match x.not_finite() {
        None => Ok(x),
        Some((name, value)) => Err(ModelError::new(format!(
            "`{name}` became {value} {when}; it must be finite"
        ))),
    }
}
