//! Makes the solver of a model for Co-Simulation, with nominal values and the sparsity pattern of the
//! Jacobian from the rows of its states; and [`solved!`](crate::solved), by which an `impl Model` has
//! one.

use super::causality::{Causality, Dependencies};
use super::continuous::Continuous;
use super::dependencies::elements;
use super::error::ModelError;
use super::input::InputPolynomial;
use super::model::{Model, Variable};
use super::sizes;
use super::solver_step::solve;
use super::solver_workspace::SolverWorkspace;
use super::step_end::StepEnd;
use super::storage::Storage;
use fmu_solver::{Method, Solver, SparsityPattern};
use std::ops::Range;

/// The solver that `#[fmu(solver = …)]` names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverName {
    /// Without the attribute: the Runge–Kutta method of order 4 in equal internal steps.
    Fixed,
    /// `"adaptive"`: the explicit method of Dormand and Prince.
    Adaptive,
    /// `"stiff"`: the Rosenbrock method Rodas5P.
    Stiff,
}

/// Most states of a stiff model with a full Jacobian, for which the solver stores 3 n² numbers.
const MOST_FULL: usize = 4096;

/// A row of states, the row of their derivatives, and the indices of the states.
struct Row<M: Model> {
    row: &'static Variable<M>,
    rate: &'static Variable<M>,
    indices: Range<usize>,
}

/// The rows of the states, which are in the order of their derivatives.
fn rows<M: Model>(rates: &'static [Variable<M>], p: &M::Parameters) -> Vec<Row<M>> {
    let (y, mut next) = (sizes::output::<M>(p), 0);
    let find = |rate: &'static Variable<M>| {
        let row = M::variables().iter().find(|row| row.name == rate.name)?;
        let Storage::RealOut(field) = &row.storage else {
            return None;
        };
        let from = next;
        next += field.slice(&y).len();
        let indices = from..next;
        Some(Row { row, rate, indices })
    };
    rates.iter().filter_map(find).collect()
}

/// A step of a model with [`solved!`](crate::solved).
#[doc(hidden)]
pub fn solved_step<M: Continuous>(
    model: &mut M,
    workspace: &mut SolverWorkspace<M, M::Input>,
    (name, longest): (SolverName, f64),
    (p, u): (&M::Parameters, &InputPolynomial<M::Input>),
    (t, h): (f64, f64),
) -> Result<StepEnd, ModelError> {
    let states = || rows(M::derivative_rows(), p);
    let n = workspace
        .states()
        .unwrap_or_else(|| states().last().map_or(0, |row| row.indices.end));
    let sizes = (n, M::INDICATORS.len());
    let make = |_: &M| solver::<M>(name, sizes, M::derivative_rows(), p, longest);
    let name = |_: &mut M, state: usize, _: f64| {
        let row = states()
            .into_iter()
            .find(|row| row.indices.contains(&state));
        row.map_or("", |row| row.row.name)
    };
    solve(model, workspace, make, n, name, (p, u), (t, h))
}

/// Gives an `impl Model` that is also [`Continuous`] a solver for Co-Simulation: `solved!(Fixed,
/// 1e-3)` with the longest internal step, s, `solved!(Adaptive)` or `solved!(Stiff)`.
///
/// It defines `step` and lets the crate find and handle the events; [`solver`](crate::solver) says
/// which one to take. [`Info::with_input_derivatives`](crate::Info::with_input_derivatives) holds,
/// and for `Adaptive` and `Stiff` [`Info::with_tolerance`](crate::Info::with_tolerance).
#[macro_export]
macro_rules! solved {
    (Fixed, $longest:expr) => { $crate::solved!(@ Fixed, $longest); };
    ($solver:ident) => { $crate::solved!(@ $solver, f64::INFINITY); };
    ($solver:ident, $longest:expr) => { $crate::solved!(@ $solver, $longest); };
    (@ $solver:ident, $longest:expr) => {
        const EVENTS: Option<$crate::ModelExchange<Self>> = $crate::ModelExchange::from_continuous();

        fn step(
            &mut self,
            p: &Self::Parameters,
            u: &$crate::InputPolynomial<Self::Input>,
            now: &Self::Evaluation,
            t: f64,
            h: f64,
        ) -> Result<$crate::StepEnd, $crate::ModelError> {
            self.step_with_workspace(&mut Default::default(), p, u, now, t, h)
        }

        fn step_with_workspace(
            &mut self,
            workspace: &mut $crate::SolverWorkspace<Self, Self::Input>,
            p: &Self::Parameters,
            u: &$crate::InputPolynomial<Self::Input>,
            _now: &Self::Evaluation,
            t: f64,
            h: f64,
        ) -> Result<$crate::StepEnd, $crate::ModelError> {
            let solver = ($crate::SolverName::$solver, $longest);
            $crate::solved_step(self, workspace, solver, (p, u), (t, h))
        }
    };
}

/// The solver of a model with `n` states and `indicators`, whose derivatives have the rows `rates`.
pub(crate) fn solver<M: Model>(
    name: SolverName,
    (n, indicators): (usize, usize),
    rates: &'static [Variable<M>],
    p: &M::Parameters,
    longest: f64,
) -> Result<Solver, ModelError> {
    let rows = rows(rates, p);
    let mut nominal = vec![1.0; n];
    for row in &rows {
        nominal[row.indices.clone()].fill(row.row.nominal.map_or(1.0, f64::abs));
    }
    let method = match name {
        SolverName::Fixed => Method::Fixed,
        SolverName::Adaptive => Method::Adaptive,
        SolverName::Stiff => Method::Stiff(pattern(n, &rows)?),
    };
    Ok(Solver::new(method, nominal, indicators, longest))
}

/// The states that each derivative reads; all of them if a row does not declare it.
fn pattern<M: Model>(n: usize, rows: &[Row<M>]) -> Result<SparsityPattern, ModelError> {
    let is_said = |row: &Row<M>| matches!(row.rate.dependencies, Dependencies::Same(_));
    let said: usize = rows.iter().map(|row| row.indices.len()).sum();
    if said < n || !rows.iter().all(is_said) {
        if n > MOST_FULL {
            return Err(ModelError::new(format!(
                "a solver for stiff models of {n} states must know which states each derivative reads: say \
                 `rate_depends_on(…)` of each state, or have at most {MOST_FULL}"
            )));
        }
        return Ok(SparsityPattern::full(n));
    }
    let find = |name: &str| {
        let state = rows.iter().find(|row| row.row.name == name);
        let is_input = |row: &&Variable<M>| row.name == name && row.causality == Causality::Input;
        match state {
            Some(state) => Some((state.indices.clone(), 0..state.indices.len())),
            None => {
                M::variables().iter().find(is_input)?;
                Some((0..0, 0..usize::MAX))
            }
        }
    };
    let mut pairs = Vec::new();
    for row in rows {
        let Dependencies::Same(names) = row.rate.dependencies else {
            continue;
        };
        for (i, index) in row.indices.clone().enumerate() {
            for name in names {
                let Some((indices, range)) = elements(name, i, find) else {
                    let state = row.row.name;
                    return Err(ModelError::new(format!(
                        "the rate of `{state}` depends on `{name}`; it must be an input or state of the table"
                    )));
                };
                // None of an input, whose indices are empty.
                let states = indices.skip(range.start).take(range.len());
                pairs.extend(states.map(|state| (index, state)));
            }
        }
    }
    Ok(SparsityPattern::new(n, pairs))
}
