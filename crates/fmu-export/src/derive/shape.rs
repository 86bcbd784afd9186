//! The solver that a state takes in Co-Simulation, with sizes and dependencies from its rows.

use super::ode::{Ode, Seen};
use crate::ModelError;
use crate::core::causality::{Causality, Dependencies};
use crate::core::dependencies::elements;
use crate::core::model::Variable;
use crate::core::place::Place;
use crate::solver::{Method, Pattern, Solver};

/// What `#[fmu(solver = …)]` says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverName {
    /// Nothing: the Runge–Kutta method of order 4 in equal internal steps.
    Fixed,
    /// `"adaptive"`: the explicit method of Dormand and Prince.
    Adaptive,
    /// `"stiff"`: the Rosenbrock method Rodas5P.
    Stiff,
}

/// Most states whose derivatives may each read all of them, with a method for stiff models: its
/// equations take 3 n² numbers.
const MOST_FULL: usize = 4096;

/// A row of states: their places among all, in the order of their elements.
struct Row<S: Ode> {
    row: &'static Variable<S>,
    rate: &'static Variable<S>,
    places: Vec<usize>,
}

/// The rows of the states. Each state is given its number, which then is what its row reads.
fn rows<S: Ode>(like: &S) -> Vec<Row<S>> {
    let numbers: Vec<f64> = (0..like.len()).map(|k| k as f64).collect();
    let mut state = like.clone();
    state.write(&numbers);
    let seen = Seen {
        state,
        outputs: S::Y::default(),
    };
    let find = |rate: &'static Variable<S>| {
        let row = S::table().iter().find(|row| row.name == rate.name)?;
        let Place::RealOut(place) = &row.place else {
            return None;
        };
        let places = place.slice(&seen).iter().map(|x| *x as usize).collect();
        Some(Row { row, rate, places })
    };
    S::derivatives().iter().filter_map(find).collect()
}

/// The solver of a model like this one.
pub(super) fn solver<S: Ode>(like: &S) -> Result<Solver, ModelError> {
    let (n, rows) = (like.len(), rows(like));
    let mut nominal = vec![1.0; n];
    for row in &rows {
        for place in &row.places {
            nominal[*place] = row.row.nominal.map_or(1.0, f64::abs);
        }
    }
    let method = match S::SOLVER {
        SolverName::Fixed => Method::Fixed,
        SolverName::Adaptive => Method::Adaptive,
        SolverName::Stiff => Method::Stiff(pattern(n, &rows)?),
    };
    Ok(Solver::new(
        method,
        nominal,
        <S as Ode>::INDICATORS.len(),
        S::MAX_STEP,
    ))
}

/// What derivatives read; all of the states where it is not said.
fn pattern<S: Ode>(n: usize, rows: &[Row<S>]) -> Result<Pattern, ModelError> {
    let is_said = |row: &Row<S>| matches!(row.rate.dependencies, Dependencies::Same(_));
    let said: usize = rows.iter().map(|row| row.places.len()).sum();
    if said < n || !rows.iter().all(is_said) {
        if n > MOST_FULL {
            return Err(ModelError::new(format!(
                "a solver for stiff models of {n} states must know which states each derivative reads: say \
                 `rate_depends_on(…)` of each state, or have at most {MOST_FULL}"
            )));
        }
        return Ok(Pattern::full(n));
    }
    let find = |name: &str| {
        let state = rows.iter().find(|row| row.row.name == name);
        let is_input = |row: &&Variable<S>| row.name == name && row.causality == Causality::Input;
        match state {
            Some(state) => Some((&state.places[..], 0..state.places.len())),
            None => S::table()
                .iter()
                .find(is_input)
                .map(|_| (&[][..], 0..usize::MAX)),
        }
    };
    let mut pairs = Vec::new();
    for row in rows {
        let Dependencies::Same(lists) = row.rate.dependencies else {
            continue;
        };
        for (i, place) in row.places.iter().enumerate() {
            for name in lists.into_iter().flatten() {
                let Some((places, range)) = elements(name, i, find) else {
                    let state = row.row.name;
                    return Err(ModelError::new(format!(
                        "the rate of `{state}` depends on `{name}`; it must be an input or state of the table"
                    )));
                };
                let states = places.get(range).unwrap_or_default(); // none of an input
                pairs.extend(states.iter().map(|state| (*place, *state)));
            }
        }
    }
    Ok(Pattern::new(n, pairs))
}
