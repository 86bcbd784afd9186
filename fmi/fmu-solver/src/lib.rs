//! Solves ordinary differential equations with events: [`Solver`] over one communication step, for
//! `fmu-export`; [`Integrator`] over any number of them, for an importer that integrates models.
//!
//! - [`Method::Fixed`]: the classical Runge–Kutta method of order 4 in equal internal steps.
//! - [`Method::Adaptive`]: the method of Dormand and Prince of order 5, which chooses its steps by
//!   a tolerance.
//! - [`Method::Stiff`]: the Rosenbrock method Rodas5P of order 5, which chooses its steps by a
//!   tolerance and stays stable where rates differ by orders of magnitude.
//!
//! All of them are one-step methods: from one communication step to the next they keep only the
//! length of the internal step to try first. Nothing is allocated in a step. Only sums, products,
//! quotients and square roots are used, so results have the same bits on every platform.

#![cfg_attr(doctest, doc = include_str!("../README.md"))]
#![forbid(unsafe_code)]

mod adaptive;
mod algorithm;
mod band_matrix;
mod dense_output;
mod dormand_prince;
mod integrator;
mod rosenbrock;
mod runge_kutta;
mod sparsity_pattern;
mod system;

pub use integrator::{Choice, Integrator, Stop};
pub use sparsity_pattern::SparsityPattern;
pub use system::System;

use algorithm::{Algorithm, Step, vectors};
use dense_output::Indicators;
use dormand_prince::DormandPrince;
use rosenbrock::Rosenbrock;
use runge_kutta::RungeKutta;
use std::fmt;

/// The default tolerance of an internal step.
pub const TOLERANCE: f64 = 1e-6;

/// Most internal steps within one communication step.
const MOST_STEPS: f64 = 1e6;

/// An integration method.
#[derive(Clone, Debug)]
pub enum Method {
    /// Runge–Kutta of order 4 in equal internal steps.
    Fixed,
    /// Dormand–Prince of order 5.
    Adaptive,
    /// Rodas5P of order 5, with this sparsity pattern of the Jacobian.
    Stiff(SparsityPattern),
}

/// Why a communication step could not be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure<E> {
    /// An error of the system.
    System(E),
    /// Too many internal steps: their number, and their maximum length, s.
    TooManySteps(f64, f64),
    /// The error is above the tolerance even with the shortest internal step: time from the start
    /// of the communication step, and length of the internal step, s.
    TooShort(f64, f64),
    /// A state became infinite or NaN: its index and value.
    NotFinite(usize, f64),
}

impl<E> From<E> for Failure<E> {
    fn from(error: E) -> Self {
        Self::System(error)
    }
}

impl<E: fmt::Display> fmt::Display for Failure<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(error) => error.fmt(f),
            Self::TooManySteps(steps, longest) => write!(
                f,
                "{steps} internal steps of at most {longest} s would be needed; there must be at most {MOST_STEPS}"
            ),
            Self::TooShort(s, dt) => write!(
                f,
                "the error of an internal step of {dt} s is above the tolerance, {s} s after the start of the step"
            ),
            Self::NotFinite(state, value) => write!(
                f,
                "state {state} became {value} at the end of the step; it must be finite"
            ),
        }
    }
}

/// Counts of a solver's work since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Accepted internal steps.
    pub steps: u64,
    /// Internal steps that were rejected because their error was too large.
    pub rejected: u64,
    /// Jacobians that were evaluated.
    pub jacobians: u64,
}

/// A solver with its workspace.
pub struct Solver {
    algorithm: AnyAlgorithm,
    workspace: Workspace,
}

enum AnyAlgorithm {
    Fixed(RungeKutta),
    Adaptive(DormandPrince),
    Stiff(Box<Rosenbrock>),
}

/// The workspace that all methods share.
struct Workspace {
    tolerance: f64,
    /// Maximum length of an internal step, s.
    longest: f64,
    step: Step,
    indicators: Indicators,
    counts: Counts,
}

impl Solver {
    /// A solver for states with these nominal values (magnitudes, > 0) and this number of event
    /// indicators. No internal step is longer than `longest`, s, which may be infinite for methods
    /// with a tolerance. Of two sign changes of an indicator in one internal step the first is found
    /// if a parabola shows the indicator's course there: through its values at both ends and in the
    /// middle.
    #[must_use]
    pub fn new(method: Method, nominal: Vec<f64>, indicators: usize, longest: f64) -> Self {
        let n = nominal.len();
        Self {
            algorithm: match method {
                Method::Fixed => AnyAlgorithm::Fixed(RungeKutta::new(n)),
                Method::Adaptive => AnyAlgorithm::Adaptive(DormandPrince::new(n)),
                Method::Stiff(pattern) => AnyAlgorithm::Stiff(Box::new(Rosenbrock::new(pattern))),
            },
            workspace: Workspace::new(nominal, indicators, longest, indicators > 0),
        }
    }

    /// Sets the allowed error of an internal step, relative to a state or its nominal value,
    /// whichever is larger; [`TOLERANCE`] by default. The fixed method does not use it.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.workspace.tolerance = tolerance;
    }

    /// The counts so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.workspace.counts
    }

    /// What comes next does not follow the last event, or that left the states as they were: an
    /// indicator that returns at once is then another event.
    pub fn forget_event(&mut self) {
        self.workspace.indicators.fired.fill(false);
    }

    /// The first indicator that has changed its sign at the last event, by its index.
    #[must_use]
    pub fn event_indicator(&self) -> Option<usize> {
        let fired = &self.workspace.indicators.fired;
        fired.iter().position(|fired| *fired)
    }

    /// Advances the states `x` from the time `t` by `h`, both s, or to the first event. `first` is
    /// the internal step to try first, s (0: not known), and afterwards that for the next
    /// communication step. On an error both are as before.
    ///
    /// Returns the time of the event after `t`, s, if there was one: the states are those just
    /// after it. Once the event is handled, call again with the rest of `h`. An indicator that then
    /// returns at once, within a thousandth of an internal step, has not left its side: a ball that
    /// is thrown back is above the floor. See [`Solver::forget_event`].
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn advance<S: System>(
        &mut self,
        system: &mut S,
        (t, h): (f64, f64),
        x: &mut [f64],
        first: &mut f64,
    ) -> Result<Option<f64>, Failure<S::Error>> {
        let workspace = &mut self.workspace;
        workspace.step.x.copy_from_slice(x);
        (workspace.step.t, workspace.step.s) = (t, 0.0);
        if !workspace.indicators.is_empty() {
            system.indicators(0.0, x, &mut workspace.indicators.values[0])?;
        }
        let (event, next) = match &mut self.algorithm {
            AnyAlgorithm::Fixed(method) => (workspace.fixed_steps(method, system, h)?, *first),
            AnyAlgorithm::Adaptive(method) => {
                workspace.adaptive_steps(method, system, h, *first)?
            }
            AnyAlgorithm::Stiff(method) => {
                workspace.adaptive_steps(&mut **method, system, h, *first)?
            }
        };
        let end = &workspace.step.x;
        if let Some((state, value)) = end.iter().enumerate().find(|(_, x)| !x.is_finite()) {
            return Err(Failure::NotFinite(state, *value));
        }
        x.copy_from_slice(end);
        *first = next;
        Ok(event)
    }
}

impl Workspace {
    /// For states with these nominal values; `is_dense`: states within an internal step are asked
    /// for.
    fn new(nominal: Vec<f64>, indicators: usize, longest: f64, is_dense: bool) -> Self {
        let n = nominal.len();
        let [x, end, error] = vectors(n);
        Self {
            tolerance: TOLERANCE,
            longest,
            step: Step {
                t: 0.0,
                s: 0.0,
                dt: 0.0,
                nominal,
                x,
                end,
                error,
                dense: vectors(if is_dense { n } else { 0 }),
            },
            indicators: Indicators::new(indicators),
            counts: Counts::default(),
        }
    }

    /// Advances in equal internal steps to the end of the communication step or the first event.
    fn fixed_steps<A: Algorithm, S: System>(
        &mut self,
        method: &mut A,
        system: &mut S,
        h: f64,
    ) -> Result<Option<f64>, Failure<S::Error>> {
        let steps = (h / self.longest).ceil();
        if steps > MOST_STEPS {
            return Err(Failure::TooManySteps(steps, self.longest));
        }
        self.step.dt = h / steps;
        for k in 0..steps as u32 {
            self.step.s = f64::from(k) * self.step.dt;
            method.begin(system, &self.step)?;
            method.step(system, &mut self.step)?;
            if let Some(event) = self.accept_step(method, system)? {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }

    /// Accepts the last internal step, to its end or to the first event in it.
    fn accept_step<A: Algorithm, S: System>(
        &mut self,
        method: &mut A,
        system: &mut S,
    ) -> Result<Option<f64>, Failure<S::Error>> {
        self.counts.steps += 1;
        let (step, indicators) = (&mut self.step, &mut self.indicators);
        if !indicators.is_empty() {
            method.rough_output(system, step)?;
            if indicators.find(system, step)?.is_some() {
                method.dense_output(system, step)?;
                // The exact states may have no event where the rough ones have.
                if let Some(within) = indicators.find(system, step)? {
                    let at = indicators.locate(system, step, within)?;
                    std::mem::swap(&mut step.x, &mut step.error);
                    return Ok(Some(step.s + at * step.dt));
                }
            }
            indicators.pass();
        }
        std::mem::swap(&mut step.x, &mut step.end);
        Ok(None)
    }
}
