//! Checks of a model against its table that need the model to run: for the tests of its author.

mod derivatives;
mod start;

use super::dependencies::Knowns;
use super::layout::{Element, Layout};
use super::value::Value;
use super::variable::{Causality, Dependencies, Names, Place, Variable};
use crate::{Evaluation, InputPolynomial, Model, ModelError, StepEnd};
use std::collections::{BTreeMap, BTreeSet};

/// What is wrong with a model's table, as far as trying can tell; empty if nothing is.
///
/// - [`model_description`](crate::model_description) finds no mistake.
/// - The model initializes, gives outputs that are finite and in their enumerations, and steps, all with its start values; the
///   derivatives it declares are there.
/// - Each input and parameter reads back what was written, and writing it changes no other one: accessors of one row are of one
///   field, and no two rows share a field. No two outputs do.
/// - Outputs follow no input and no parameter but those that they declare, while stepping and initially.
/// - Directional derivatives, if the model has them, are those that differences of the outputs give, and adjoint derivatives are their
///   transpose.
/// - Calculated parameters follow the parameters they declare and nothing else; constants nothing at all.
/// - The model's [`Evaluation`] follows no input that is declared to be beside it.
///
/// ```
/// # use fmu_export::*; use serde::{Deserialize, Serialize};
/// # #[derive(Clone, Serialize, Deserialize)] struct Lag; #[derive(Clone, Copy, Default, Serialize, Deserialize)] struct Nothing;
/// # impl Model for Lag { type Parameters = Nothing; type Input = Nothing; type Output = Nothing; type Evaluation = ();
/// # const INFO: Info = Info::new("Lag", "lag"); fn variables() -> &'static [Variable<Self>] { &[] }
/// # fn defaults() -> (Nothing, Nothing) { (Nothing, Nothing) }
/// # fn initialize(_: &Nothing, _: &Nothing, _: f64) -> Result<Self, ModelError> { Ok(Lag) }
/// # fn output(&self, _: &Nothing, _: &Nothing, _: &()) -> Result<Nothing, ModelError> { Ok(Nothing) }
/// # fn step(&mut self, _: &Nothing, _: &InputPolynomial<Nothing>, _: &(), _: f64, _: f64) -> Result<StepEnd, ModelError> { Ok(StepEnd::WHOLE) } }
/// assert_eq!(fmu_export::check::<Lag>(), [""; 0]);
/// ```
pub fn check<M: Model>() -> Vec<String> {
    if let Err(reason) = crate::model_description::<M>() {
        return vec![reason];
    }
    let mut trial = Trial::<M>::new();
    trial.accessors();
    trial.texts();
    trial.outputs();
    trial.start();
    if trial.problems.is_empty() {
        trial.dependencies();
        trial.initial_dependencies();
    }
    trial.problems.into_iter().collect()
}

/// Runs `$then` with the place of an input or a parameter that is a number, and where it lives in a [`Point`].
macro_rules! known {
    ($row:expr, $point:expr, |$place:ident, $owner:ident| $then:expr) => {
        match &$row.place {
            Place::RealIn($place) => {
                let $owner = $point.u();
                Some($then)
            }
            Place::IntegerIn($place) => {
                let $owner = $point.u();
                Some($then)
            }
            Place::BooleanIn($place) => {
                let $owner = $point.u();
                Some($then)
            }
            Place::RealParameter($place) => {
                let $owner = $point.p();
                Some($then)
            }
            Place::IntegerParameter($place) => {
                let $owner = $point.p();
                Some($then)
            }
            Place::BooleanParameter($place) => {
                let $owner = $point.p();
                Some($then)
            }
            _ => None,
        }
    };
}

/// Parameters and inputs.
struct Point<M: Model>(M::Parameters, M::Input);

impl<M: Model> Clone for Point<M> {
    fn clone(&self) -> Self {
        Self(self.0.clone(), self.1)
    }
}

impl<M: Model> Point<M> {
    fn p(&mut self) -> &mut M::Parameters {
        &mut self.0
    }

    fn u(&mut self) -> &mut M::Input {
        &mut self.1
    }

    /// The number in an element, as text: equal texts are equal bits.
    fn read(&mut self, (i, row): Element<M>) -> Option<String> {
        known!(row, self, |place, owner| place.get(owner, i).to_string())
    }

    /// Counts that all inputs are set, to what they are.
    fn set_inputs(&mut self) {
        for counter in M::variables().iter().filter_map(|row| row.counter) {
            let count = counter(&mut self.1);
            *count = count.wrapping_add(1);
        }
    }

    /// Moves an element by a part of its size, to another value that is allowed; false if there is none.
    fn perturb(&mut self, (i, row): Element<M>, part: f64) -> bool {
        known!(row, self, |place, owner| {
            let value = place.get(owner, i);
            let moved = value.moved(part, row);
            let other = moved
                .into_iter()
                .find(|v| !v.is_same(value) && v.is_allowed(row));
            if let Some(other) = other {
                *place.get_mut(owner, i) = other;
            }
            other.is_some()
        })
        .unwrap_or(false)
    }
}

/// Values near another one.
trait Nearby: Value {
    fn moved<M: Model>(self, part: f64, row: &Variable<M>) -> Vec<Self>;
}

impl Nearby for f64 {
    fn moved<M: Model>(self, part: f64, row: &Variable<M>) -> Vec<f64> {
        let size = row.nominal.unwrap_or(1.0).max(self.abs());
        let steps = [
            part,
            -part,
            0.1 * part,
            -0.1 * part,
            1e-3 * part,
            -1e-3 * part,
        ];
        steps.iter().map(|part| self + part * size).collect()
    }
}

impl Nearby for i32 {
    fn moved<M: Model>(self, _part: f64, _row: &Variable<M>) -> Vec<i32> {
        vec![self.saturating_add(1), self.saturating_sub(1)]
    }
}

impl Nearby for bool {
    fn moved<M: Model>(self, _part: f64, _row: &Variable<M>) -> Vec<bool> {
        vec![!self]
    }
}

struct Trial<M: Model> {
    layout: Layout<M>,
    knowns: Knowns,
    start: Point<M>,
    problems: BTreeSet<String>,
}

impl<M: Model> Trial<M> {
    fn new() -> Self {
        let (p, u) = M::defaults();
        let layout = Layout::new(&p, &u);
        Self {
            knowns: Knowns::new(&layout),
            layout,
            start: Point(p, u),
            problems: BTreeSet::new(),
        }
    }

    fn name(&self, element: usize) -> String {
        let (i, row) = self.layout.iter().nth(element).expect("counted");
        row.element_name(i)
    }

    /// Writes each input and parameter, and reads all.
    fn accessors(&mut self) {
        let elements: Vec<_> = self.layout.iter().collect();
        let read = |point: &mut Point<M>| -> Vec<_> {
            elements
                .iter()
                .map(|&element| point.read(element))
                .collect()
        };
        let before = read(&mut self.start.clone());
        for (k, &element) in elements.iter().enumerate() {
            let mut point = self.start.clone();
            let lengths = known!(element.1, point, |place, owner| {
                (place.slice(owner).len(), place.slice_mut(owner).len())
            });
            if lengths.is_some_and(|(read, write)| read != write) {
                let problem = format!("`{}`: its accessors are of different fields", self.name(k));
                self.problems.insert(problem);
                continue;
            }
            if !point.perturb(element, 0.25) {
                continue;
            }
            let after = read(&mut point);
            if after[k] == before[k] {
                let problem = format!("`{}`: its accessors are of different fields", self.name(k));
                self.problems.insert(problem);
            }
            for other in (0..elements.len()).filter(|&j| j != k && after[j] != before[j]) {
                let names = [self.name(k.min(other)), self.name(k.max(other))];
                let problem = format!("`{}` and `{}` share a field", names[0], names[1]);
                self.problems.insert(problem);
            }
        }
    }

    /// Looks where the outputs are.
    fn outputs(&mut self) {
        let y = M::Output::default();
        let mut places = BTreeMap::new();
        for (k, (i, row)) in self.layout.iter().enumerate() {
            if row.causality == Causality::Constant {
                continue; // in no field; the compiler may put equal ones in one place
            }
            let address = match &row.place {
                Place::RealOut(place) => (&raw const place.slice(&y)[i]).addr(),
                Place::IntegerOut(place) => (&raw const place.slice(&y)[i]).addr(),
                Place::BooleanOut(place) => (&raw const place.slice(&y)[i]).addr(),
                _ => continue,
            };
            if let Some(first) = places.insert(address, k) {
                let problem = format!(
                    "`{}` and `{}` share a field",
                    self.name(first),
                    self.name(k)
                );
                self.problems.insert(problem);
            }
        }
    }

    /// Outputs at fixed states against each input, at points away from the start.
    fn dependencies(&mut self) {
        let step = M::INFO.experiment.step;
        let Ok(mut model) = M::initialize(&self.start.0, &self.start.1, 0.0) else {
            return;
        };
        let mut point = self.start.clone();
        let first = output(&self.layout, &model, &point);
        for k in 0..4 {
            self.compare_inputs(&model, &point);
            self.derivatives(&model, &point);
            if let (Ok(first), Ok(now)) = (&first, output(&self.layout, &model, &point)) {
                self.compare_fixed(first, &now);
            }
            if advance(&mut model, &point, f64::from(k) * step, step).is_err() {
                return;
            }
            // Some other inputs next time, as far as the model takes them.
            let elements: Vec<_> = self.layout.iter().collect();
            for (n, &element) in elements.iter().enumerate() {
                let mut moved = point.clone();
                let part = 0.01 * (1.0 + ((7 * n + 3) % 11) as f64);
                if element.1.causality == Causality::Input
                    && moved.perturb(element, part)
                    && output(&self.layout, &model, &moved).is_ok()
                {
                    point = moved;
                }
            }
        }
    }

    fn compare_inputs(&mut self, model: &M, point: &Point<M>) {
        let Ok(expected) = output(&self.layout, model, point) else {
            return;
        };
        for (known, element) in self.layout.iter().enumerate().collect::<Vec<_>>() {
            for part in [1e-3, 0.2] {
                let mut moved = point.clone();
                if element.1.causality != Causality::Input || !moved.perturb(element, part) {
                    continue;
                }
                let Ok(found) = output(&self.layout, model, &moved) else {
                    continue;
                };
                self.compare(known, &expected, &found, false);
                if element.1.beside_evaluation
                    && !keeps_evaluation(&self.layout, model, point, &moved)
                {
                    let name = self.name(known);
                    self.problems.insert(format!(
                        "`{name}`: the evaluation follows it, though it is declared to be beside it"
                    ));
                }
            }
        }
    }

    /// Outputs after initialization against each input and parameter.
    fn initial_dependencies(&mut self) {
        let Point(p, u) = &self.start;
        let layout = &Layout::new(p, u);
        let initial = |point: &Point<M>| {
            let model = M::initialize(&point.0, &point.1, 0.0)?;
            output(layout, &model, point)
        };
        let Ok(expected) = initial(&self.start) else {
            return;
        };
        for (known, element) in self.layout.iter().enumerate().collect::<Vec<_>>() {
            for part in [1e-3, 0.2] {
                let mut moved = self.start.clone();
                if !moved.perturb(element, part) {
                    continue;
                }
                if let Ok(found) = initial(&moved) {
                    self.compare(known, &expected, &found, true);
                }
            }
        }
    }

    /// Reports what must be fixed, and is another after some steps.
    fn compare_fixed(&mut self, first: &[String], now: &[String]) {
        for (k, (i, row)) in self.layout.iter().enumerate() {
            if is_fixed(row) && first[k] != now[k] {
                let (name, kind) = (row.element_name(i), row.kind(&Names::PLAIN));
                self.problems
                    .insert(format!("`{name}` changes in a step, but is {kind}"));
            }
        }
    }

    /// Reports the outputs that follow element `known` without saying so.
    fn compare(&mut self, known: usize, expected: &[String], found: &[String], initially: bool) {
        for (k, (i, row)) in self.layout.iter().enumerate().collect::<Vec<_>>() {
            let is_declared = matches!(
                row.causality,
                Causality::Output | Causality::CalculatedParameter | Causality::Constant
            );
            if !is_declared || expected[k] == found[k] {
                continue;
            }
            let (_, of) = self.layout.iter().nth(known).expect("counted");
            let may_follow = match row.causality {
                Causality::Constant => false,
                Causality::CalculatedParameter => of.causality == Causality::Parameter,
                _ => true,
            };
            if !may_follow {
                let (output, kind, known) =
                    (self.name(k), row.kind(&Names::PLAIN), self.name(known));
                self.problems
                    .insert(format!("`{output}` depends on `{known}`, but is {kind}"));
                continue;
            }
            let declared: Dependencies = if initially {
                row.initial_dependencies
            } else {
                row.dependencies
            };
            let resolved = self.knowns.resolve(declared, i, initially);
            if let Ok(Some(elements)) = resolved
                && !elements.contains(&known)
            {
                let (output, known) = (self.name(k), self.name(known));
                let when = if initially { " initially" } else { "" };
                self.problems.insert(format!(
                    "`{output}` depends{when} on `{known}`, which it does not declare"
                ));
            }
        }
    }
}

/// Whether its value is settled in the initialization.
fn is_fixed<M: Model>(row: &Variable<M>) -> bool {
    matches!(
        row.causality,
        Causality::CalculatedParameter | Causality::Constant
    )
}

/// All outputs, as texts by element.
fn output<M: Model>(
    layout: &Layout<M>,
    model: &M,
    point: &Point<M>,
) -> Result<Vec<String>, ModelError> {
    let now = M::Evaluation::of(model, &point.0, &point.1)?;
    Ok(texts(layout, &model.output(&point.0, &point.1, &now)?))
}

fn texts<M: Model>(layout: &Layout<M>, y: &M::Output) -> Vec<String> {
    let text = |(i, row): Element<M>| match &row.place {
        Place::RealOut(place) => format!("{:x}", place.get(y, i).to_bits()),
        Place::IntegerOut(place) => place.get(y, i).to_string(),
        Place::BooleanOut(place) => place.get(y, i).to_string(),
        Place::StringOut(get) => get(y).to_owned(),
        _ => String::new(),
    };
    layout.iter().map(text).collect()
}

fn advance<M: Model>(
    model: &mut M,
    Point(p, u): &Point<M>,
    t: f64,
    h: f64,
) -> Result<StepEnd, ModelError> {
    let now = M::Evaluation::of(model, p, u)?;
    model.step(p, &InputPolynomial::held(*u), &now, t, h)
}

/// Whether an evaluation of one point serves for another one: in outputs now, and after a step.
fn keeps_evaluation<M: Model>(
    layout: &Layout<M>,
    model: &M,
    old: &Point<M>,
    new: &Point<M>,
) -> bool {
    let Point(p, u) = new;
    let with = |now: Result<M::Evaluation, ModelError>| -> Result<_, ModelError> {
        let (now, mut model) = (now?, model.clone());
        let before = texts(layout, &model.output(p, u, &now)?);
        let step = M::INFO.experiment.step;
        model.step(p, &InputPolynomial::held(*u), &now, 0.0, step)?;
        Ok((before, output(layout, &model, new)?))
    };
    let kept = with(M::Evaluation::of(model, &old.0, &old.1));
    let made = with(M::Evaluation::of(model, p, u));
    match (kept, made) {
        (Ok(kept), Ok(made)) => kept == made,
        (kept, made) => kept.is_err() == made.is_err(),
    }
}
