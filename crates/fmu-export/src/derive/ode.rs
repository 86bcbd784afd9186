//! Models that are ordinary differential equations.

use super::{Input, Name, Output, Parameters, Path};
use crate::core::sizes::fitted;
use crate::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use serde::{Serialize, de::DeserializeOwned};
use std::marker::PhantomData;

/// Most internal steps within one communication step.
const MOST_STEPS: f64 = 1e6;

/// The state of a model of ordinary differential equations; `#[derive(State)]` writes it.
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
    /// What the model puts out beside its state.
    type Y: Output + Send + 'static;

    /// What the model says about itself.
    const INFO: Info;
    /// Longest internal step, s.
    const MAX_STEP: f64;

    /// The state at the start.
    fn start(p: &Self::P, u: &Self::U) -> Self;

    /// The table of variables: parameters, inputs, states, outputs.
    fn table() -> &'static [Variable<Self>]
    where
        Self: Model;
}

/// Numbers that can be integrated.
pub trait Vector: Sized {
    /// `self + factor · rate`.
    #[must_use]
    fn plus(&self, factor: f64, rate: &Self) -> Self;

    /// The name of the first number that is not finite, and the number.
    fn not_finite(&self) -> Option<(&'static str, f64)>;
}

impl Vector for f64 {
    #[inline]
    fn plus(&self, factor: f64, rate: &f64) -> f64 {
        self + factor * rate
    }

    fn not_finite(&self) -> Option<(&'static str, f64)> {
        (!self.is_finite()).then_some(("", *self))
    }
}

impl<T: Vector, const N: usize> Vector for [T; N] {
    #[inline]
    fn plus(&self, factor: f64, rate: &Self) -> Self {
        std::array::from_fn(|i| self[i].plus(factor, &rate[i]))
    }

    fn not_finite(&self) -> Option<(&'static str, f64)> {
        self.iter().find_map(Vector::not_finite)
    }
}

impl Vector for Vec<f64> {
    fn plus(&self, factor: f64, rate: &Self) -> Self {
        self.iter()
            .zip(rate)
            .map(|(x, rate)| x + factor * rate)
            .collect()
    }

    fn not_finite(&self) -> Option<(&'static str, f64)> {
        self.iter().find_map(Vector::not_finite)
    }
}

/// A model of ordinary differential equations: `x' = f(x, p, u, t)`, `y = g(x, p, u)`, x the state
/// `Self`.
///
/// It is solved by the Runge–Kutta method of order 4 in equal internal steps that end where the
/// communication step ends, none longer than `#[fmu(max_step = …)]` says, 1 ms if it says nothing.
/// Inputs follow their derivatives, if the importer gives them. A step that leaves a state that is
/// not finite is discarded.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a model",
    note = "write `impl Ode for {Self}` with its equations, or `impl Model for {Self}`"
)]
pub trait Ode: State {
    /// Time derivative of each state, per s.
    fn derivative(&self, p: &Self::P, u: &Self::U, t: f64) -> Self;

    /// What the model puts out beside its state. Must be written where `#[fmu(output = …)]` names a
    /// struct.
    fn outputs(&self, _p: &Self::P, _u: &Self::U) -> Self::Y {
        const {
            assert!(
                size_of::<Self::Y>() == 0,
                "`fn outputs` is missing in `impl Ode`: the model has a struct of outputs"
            );
        }
        Self::Y::default()
    }
}

/// What an importer sees of a model: its state and its outputs.
pub struct Seen<S: State> {
    state: S,
    outputs: S::Y,
}

impl<S: State> Clone for Seen<S> {
    fn clone(&self) -> Self {
        Self {
            state: self.state.clone(),
            outputs: self.outputs.clone(),
        }
    }
}

impl<S: State> Default for Seen<S> {
    fn default() -> Self {
        Self {
            state: S::default(),
            outputs: S::Y::default(),
        }
    }
}

/// Ways to the fields of [`Seen`].
macro_rules! ways {
    ($($(#[$doc:meta])* $way:ident to $field:ident: $type:ty;)*) => {$(
        $(#[$doc])*
        pub struct $way<S>(PhantomData<S>);

        impl<S: State> Path for $way<S> {
            type From = Seen<S>;
            type To = $type;
            const NAME: Name = Name::EMPTY;

            #[inline]
            fn get(from: &Seen<S>) -> &$type {
                &from.$field
            }

            #[inline]
            fn get_mut(from: &mut Seen<S>) -> &mut $type {
                &mut from.$field
            }
        }
    )*};
}

ways! {
    /// The way to the state in [`Seen`].
    SeenState to state: S;
    /// The way to the outputs in [`Seen`].
    SeenOutputs to outputs: S::Y;
}

impl<S: Ode> Model for S {
    type Parameters = S::P;
    type Input = S::U;
    type Output = Seen<S>;
    type Evaluation = ();

    const INFO: Info = S::INFO.with_input_derivatives();

    fn variables() -> &'static [Variable<Self>] {
        S::table()
    }

    fn defaults() -> (S::P, S::U) {
        fitted::<S>((S::P::start(), S::U::start()))
    }

    fn initialize(p: &S::P, u: &S::U, _t: f64) -> Result<Self, ModelError> {
        finite(S::start(p, u), "at the start")
    }

    fn output(&self, p: &S::P, u: &S::U, _now: &()) -> Result<Seen<S>, ModelError> {
        Ok(Seen {
            state: self.clone(),
            outputs: self.outputs(p, u),
        })
    }

    fn output_into(
        &self,
        p: &S::P,
        u: &S::U,
        _now: &(),
        y: &mut Seen<S>,
    ) -> Result<(), ModelError> {
        y.state.clone_from(self);
        y.outputs = self.outputs(p, u);
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
        let n = (h / S::MAX_STEP).ceil();
        if n > MOST_STEPS {
            let longest = S::MAX_STEP;
            return Err(ModelError::new(format!(
                "{n} internal steps of at most {longest} s would be needed; there must be at most {MOST_STEPS}"
            )));
        }
        let dt = h / n; // internal steps divide h, so the last one ends at t + h
        let mut x = self.clone();
        for k in 0..n as u32 {
            x = runge_kutta(x, p, u, t, f64::from(k) * dt, dt);
        }
        *self = finite(x, "at the end of the step")?;
        Ok(StepEnd::WHOLE)
    }
}

/// One internal step of `dt` s from `s` s after `t`: the classical method of order 4.
#[inline]
fn runge_kutta<S: Ode>(x: S, p: &S::P, u: &InputPolynomial<S::U>, t: f64, s: f64, dt: f64) -> S {
    let (half, end) = (s + 0.5 * dt, s + dt);
    let (u_start, u_half, u_end) = (u.at::<S>(s), u.at::<S>(half), u.at::<S>(end));
    let a = x.derivative(p, &u_start, t + s);
    let b = x.plus(0.5 * dt, &a).derivative(p, &u_half, t + half);
    let c = x.plus(0.5 * dt, &b).derivative(p, &u_half, t + half);
    let d = x.plus(dt, &c).derivative(p, &u_end, t + end);
    (x.plus(dt / 6.0, &a).plus(dt / 3.0, &b))
        .plus(dt / 3.0, &c)
        .plus(dt / 6.0, &d)
}

fn finite<S: State>(x: S, when: &str) -> Result<S, ModelError> {
    match x.not_finite() {
        None => Ok(x),
        Some((name, value)) => Err(ModelError::new(format!(
            "`{name}` became {value} {when}; it must be finite"
        ))),
    }
}
