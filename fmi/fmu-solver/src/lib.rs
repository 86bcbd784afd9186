//! Solvers of differential equations over one communication step, for models whose importer has
//! none.
//!
//! - [`Method::Fixed`]: the classical Runge–Kutta method of order 4 in equal internal steps.
//! - [`Method::Adaptive`]: the method of Dormand and Prince of order 5, which chooses its steps by
//!   a tolerance.
//! - [`Method::Stiff`]: the Rosenbrock method Rodas5P of order 5, which chooses its steps by a
//!   tolerance and stays stable where rates differ by orders of magnitude.
//!
//! All of them are one-step methods: what they carry from one communication step to the next is the
//! state and the length of the internal step to try first. Nothing is allocated in a step. Only
//! sums, products, quotients and square roots are used, so results have the same bits on every
//! machine if the system's have.

mod adaptive;
mod algorithm;
mod band_matrix;
mod dense_output;
mod dormand_prince;
mod rosenbrock;
mod runge_kutta;
mod sparsity_pattern;
mod system;

pub use sparsity_pattern::SparsityPattern;
pub use system::System;

use algorithm::{Algorithm, vectors};
use dense_output::{DenseOutput, Indicators};
use dormand_prince::DormandPrince;
use rosenbrock::Rosenbrock;
use runge_kutta::RungeKutta;
use std::fmt;

/// The tolerance of an internal step, where the importer gives none.
pub const TOLERANCE: f64 = 1e-6;

/// Most internal steps within one communication step.
const MOST_STEPS: f64 = 1e6;

/// How a system is integrated.
#[derive(Clone, Debug)]
pub enum Method {
    /// Runge–Kutta of order 4 in equal internal steps.
    Fixed,
    /// Dormand–Prince of order 5.
    Adaptive,
    /// Rodas5P of order 5, with a Jacobian of this pattern.
    Stiff(SparsityPattern),
}

/// Why a communication step could not be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure<E> {
    /// What the system says.
    System(E),
    /// So many internal steps would be needed, each of at most so many s.
    TooManySteps(f64, f64),
    /// So many s after the start of the communication step, an internal step of so many s is still
    /// too long for the tolerance.
    TooShort(f64, f64),
    /// The state of this index has become infinite or no number: this value.
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

/// What a solver has done since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Internal steps that were taken.
    pub steps: u64,
    /// Internal steps that were tried and not taken: their error was too large.
    pub rejected: u64,
    /// Jacobians that were evaluated.
    pub jacobians: u64,
}

/// A solver with all the room that it needs.
pub struct Solver {
    algorithm: AnyAlgorithm,
    workspace: Workspace,
}

enum AnyAlgorithm {
    Fixed(RungeKutta),
    Adaptive(DormandPrince),
    Stiff(Box<Rosenbrock>),
}

/// What all methods need.
struct Workspace {
    nominal: Vec<f64>,
    tolerance: f64,
    /// What an internal step may at most be, s.
    longest: f64,
    /// States at the start and the end of an internal step.
    x: Vec<f64>,
    end: Vec<f64>,
    /// The estimate of the errors of an internal step; then the states at an event within.
    error: Vec<f64>,
    dense_output: DenseOutput,
    indicators: Indicators,
    counts: Counts,
}

impl Solver {
    /// For states of these nominal values (their sizes, > 0) and so many event indicators. No
    /// internal step is longer than `longest`, s, which may be infinite where a tolerance chooses.
    /// An indicator that changes its sign twice within one is not seen.
    #[must_use]
    pub fn new(method: Method, nominal: Vec<f64>, indicators: usize, longest: f64) -> Self {
        let n = nominal.len();
        let [x, end, error] = vectors(n);
        Self {
            algorithm: match method {
                Method::Fixed => AnyAlgorithm::Fixed(RungeKutta::new(n)),
                Method::Adaptive => AnyAlgorithm::Adaptive(DormandPrince::new(n)),
                Method::Stiff(pattern) => AnyAlgorithm::Stiff(Box::new(Rosenbrock::new(pattern))),
            },
            workspace: Workspace {
                nominal,
                tolerance: TOLERANCE,
                longest,
                x,
                end,
                error,
                dense_output: DenseOutput(vectors(if indicators > 0 { n } else { 0 })),
                indicators: Indicators(vectors(indicators)),
                counts: Counts::default(),
            },
        }
    }

    /// The error that an internal step may have, relative to a state or its nominal value,
    /// whichever is larger: [`TOLERANCE`] until it is said. The fixed method has none.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.workspace.tolerance = tolerance;
    }

    /// What has been done so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.workspace.counts
    }

    /// Moves the states `x` on from the time `t` by `h`, both s, or to the first event. `first` is
    /// the internal step to try first, s (0: not known), and then that of the next communication
    /// step. On an error both are as before.
    ///
    /// The answer is the time of the event after `t`, s, if there was one: the states are those
    /// just behind it, and whoever has dealt with it calls again with what is left of `h`.
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
        workspace.x.copy_from_slice(x);
        if !workspace.indicators.is_empty() {
            system.indicators(0.0, x, &mut workspace.indicators.0[0])?;
        }
        let (event, next) = match &mut self.algorithm {
            AnyAlgorithm::Fixed(method) => (workspace.fixed_steps(method, system, (t, h))?, *first),
            AnyAlgorithm::Adaptive(method) => {
                workspace.adaptive_steps(method, system, (t, h), *first)?
            }
            AnyAlgorithm::Stiff(method) => {
                workspace.adaptive_steps(&mut **method, system, (t, h), *first)?
            }
        };
        if let Some((state, value)) = workspace.x.iter().enumerate().find(|(_, x)| !x.is_finite()) {
            return Err(Failure::NotFinite(state, *value));
        }
        x.copy_from_slice(&workspace.x);
        *first = next;
        Ok(event)
    }
}

impl Workspace {
    /// In equal internal steps, so that the last one ends at `t` + `h`; or to the first event.
    fn fixed_steps<A: Algorithm, S: System>(
        &mut self,
        method: &mut A,
        system: &mut S,
        (t, h): (f64, f64),
    ) -> Result<Option<f64>, Failure<S::Error>> {
        let steps = (h / self.longest).ceil();
        if steps > MOST_STEPS {
            return Err(Failure::TooManySteps(steps, self.longest));
        }
        let dt = h / steps;
        for k in 0..steps as u32 {
            let s = f64::from(k) * dt;
            method.begin(system, (t, s, dt), &self.x, &self.nominal)?;
            method.step(system, (s, dt), &self.x, &mut self.end, &mut self.error)?;
            if let Some(event) = self.accept_step(method, system, t, (s, dt))? {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }

    /// Takes the internal step that was tried last, to its end or to the first event on the way.
    fn accept_step<A: Algorithm, S: System>(
        &mut self,
        method: &mut A,
        system: &mut S,
        t: f64,
        (s, dt): (f64, f64),
    ) -> Result<Option<f64>, Failure<S::Error>> {
        self.counts.steps += 1;
        let (step, indicators, dense) = ((s, dt), &mut self.indicators, &mut self.dense_output);
        if !indicators.is_empty() {
            system.indicators(s + dt, &self.end, &mut indicators.0[1])?;
            if indicators.has_event() {
                let ends = [&self.x[..], &self.end[..]];
                method.dense_output(system, step, ends, dense)?;
                // As finely as times can be told apart.
                let finest = 4.0 * f64::EPSILON * (t.abs() + s + dt) / dt;
                let at = indicators.locate(system, step, finest, (dense, ends), &mut self.error)?;
                std::mem::swap(&mut self.x, &mut self.error);
                return Ok(Some(s + at * dt));
            }
            indicators.0.swap(0, 1);
        }
        std::mem::swap(&mut self.x, &mut self.end);
        Ok(None)
    }
}
