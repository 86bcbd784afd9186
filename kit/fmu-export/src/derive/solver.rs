//! Makes the solver of an [`Ode`](super::Ode) for Co-Simulation, with nominal values and the
//! sparsity pattern of the Jacobian from the rows of its states.

use crate::core::causality::{Causality, Dependencies};
use crate::core::dependencies::elements;
use crate::core::model::Variable;
use crate::core::storage::Storage;
use crate::{Model, ModelError};
use fmu_solver::{Method, Solver, SparsityPattern};

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
    indices: Vec<usize>,
}

/// The rows of the states; in `numbered`, the value of each state is its index.
fn rows<M: Model>(rates: &'static [Variable<M>], numbered: &M::Output) -> Vec<Row<M>> {
    let find = |rate: &'static Variable<M>| {
        let row = M::variables().iter().find(|row| row.name == rate.name)?;
        let Storage::RealOut(field) = &row.storage else {
            return None;
        };
        let indices = field.slice(numbered).iter().map(|x| *x as usize).collect();
        Some(Row { row, rate, indices })
    };
    rates.iter().filter_map(find).collect()
}

/// The solver of a model with `n` states and `indicators`, whose derivatives have the rows `rates`;
/// in `numbered`, the value of each state is its index.
pub(super) fn solver<M: Model>(
    name: SolverName,
    (n, indicators): (usize, usize),
    rates: &'static [Variable<M>],
    numbered: &M::Output,
    longest: f64,
) -> Result<Solver, ModelError> {
    let rows = rows(rates, numbered);
    let mut nominal = vec![1.0; n];
    for row in &rows {
        for index in &row.indices {
            nominal[*index] = row.row.nominal.map_or(1.0, f64::abs);
        }
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
            Some(state) => Some((&state.indices[..], 0..state.indices.len())),
            None => {
                M::variables().iter().find(is_input)?;
                Some((&[][..], 0..usize::MAX))
            }
        }
    };
    let mut pairs = Vec::new();
    for row in rows {
        let Dependencies::Same(lists) = row.rate.dependencies else {
            continue;
        };
        for (i, index) in row.indices.iter().enumerate() {
            for name in lists.into_iter().flatten() {
                let Some((indices, range)) = elements(name, i, find) else {
                    let state = row.row.name;
                    return Err(ModelError::new(format!(
                        "the rate of `{state}` depends on `{name}`; it must be an input or state of the table"
                    )));
                };
                let states = indices.get(range).unwrap_or_default(); // none of an input
                pairs.extend(states.iter().map(|state| (*index, *state)));
            }
        }
    }
    Ok(SparsityPattern::new(n, pairs))
}
