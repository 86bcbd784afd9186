//! Tests in `check`: outputs depend on nothing but what they declare.

use super::model_check::{ModelCheck, output, texts};
use super::point::Point;
use crate::core::causality::Causality;
use crate::core::layout::Layout;
use crate::core::model::Variable;
use crate::core::storage::TypeNames;
use crate::{Evaluation, InputPolynomial, Model, ModelError, StepEnd};

impl<M: Model> ModelCheck<M> {
    /// Compares outputs with their declared dependencies on inputs, at the start and later states.
    pub(super) fn dependencies(&mut self) {
        let step = M::INFO.experiment.step;
        let Ok(mut model) = M::initialize(&self.start.0, &self.start.1, 0.0) else {
            return;
        };
        let mut point = self.start.clone();
        let first = output(&self.layout, &model, &point);
        for k in 0..8 {
            self.compare_inputs(&model, &point);
            self.compare_states(&model, &point);
            self.compare_rates(&model, &point);
            // At the ends of the ranges differences are too rough to compare with.
            if k < 4 {
                self.derivatives(&model, &point);
            }
            if let (Ok(first), Ok(now)) = (&first, output(&self.layout, &model, &point)) {
                self.compare_fixed(first, &now);
            }
            if advance(&mut model, &point, k as f64 * step, step).is_err() {
                return;
            }
            // Other inputs next time, as far as the model accepts them; from the fourth time on such
            // that lead to events which small changes never reach.
            for (n, element) in self.layout.samples() {
                if k >= 3 && element.1.causality == Causality::Input {
                    let others = point.over_range(element);
                    let other = others.get((k + n) % others.len().max(1));
                    if let Some(other) = other.filter(|at| output(&self.layout, &model, at).is_ok())
                    {
                        point = other.clone();
                    }
                    continue;
                }
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
        for (known, element) in self.layout.samples() {
            if element.1.causality != Causality::Input {
                continue;
            }
            let near = [1e-3, 0.2].into_iter().filter_map(|part| {
                let mut moved = point.clone();
                moved.perturb(element, part).then_some(moved)
            });
            for moved in near.chain(point.over_range(element)) {
                let Ok(found) = output(&self.layout, model, &moved) else {
                    continue;
                };
                self.compare(known, &expected, &found, false);
                if element.1.not_in_evaluation
                    && !keeps_evaluation(&self.layout, model, point, &moved)
                {
                    let name = self.name(known);
                    self.problems.insert(format!(
                        "`{name}`: the evaluation depends on it, but it is declared `not_in_evaluation`"
                    ));
                }
            }
        }
    }

    /// Compares outputs after initialization with their declared initial dependencies.
    pub(super) fn initial_dependencies(&mut self) {
        let Point(p, u) = &self.start;
        let layout = &Layout::new(p, u);
        let initial = |point: &Point<M>| {
            let model = M::initialize(&point.0, &point.1, 0.0)?;
            output(layout, &model, point)
        };
        let Ok(expected) = initial(&self.start) else {
            return;
        };
        for (known, element) in self.layout.samples() {
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

    /// Reports variables that must be fixed, but have changed after some steps.
    fn compare_fixed(&mut self, first: &[String], now: &[String]) {
        for (k, (i, row)) in self.layout.iter().enumerate() {
            if is_fixed(row) && first[k] != now[k] {
                let (name, kind) = (row.element_name(i), row.kind(&TypeNames::PLAIN));
                self.problems
                    .insert(format!("`{name}` changes in a step, but is {kind}"));
            }
        }
    }

    /// Reports the outputs that depend on element `known` without declaring it.
    pub(super) fn compare(
        &mut self,
        known: usize,
        expected: &[String],
        found: &[String],
        initially: bool,
    ) {
        for (k, (i, row)) in self.layout.iter().enumerate().collect::<Vec<_>>() {
            let is_declared = matches!(
                row.causality,
                Causality::Output | Causality::CalculatedParameter | Causality::Constant
            ) || row.storage.is_equation();
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
                    (self.name(k), row.kind(&TypeNames::PLAIN), self.name(known));
                self.problems
                    .insert(format!("`{output}` depends on `{known}`, but is {kind}"));
                continue;
            }
            let resolved = self.knowns.resolve(row, i, initially);
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

/// Whether its value is fixed by the initialization.
fn is_fixed<M: Model>(row: &Variable<M>) -> bool {
    matches!(
        row.causality,
        Causality::CalculatedParameter | Causality::Constant
    )
}

fn advance<M: Model>(
    model: &mut M,
    Point(p, u): &Point<M>,
    t: f64,
    h: f64,
) -> Result<StepEnd, ModelError> {
    let now = M::Evaluation::new(model, p, u)?;
    model.step(p, &InputPolynomial::held(u.clone()), &now, t, h)
}

/// Whether the evaluation at the old point gives the same outputs and step at the new one.
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
        model.step(p, &InputPolynomial::held(u.clone()), &now, 0.0, step)?;
        Ok((before, output(layout, &model, new)?))
    };
    let kept = with(M::Evaluation::new(model, &old.0, &old.1));
    let made = with(M::Evaluation::new(model, p, u));
    match (kept, made) {
        (Ok(kept), Ok(made)) => kept == made,
        (kept, made) => kept.is_err() == made.is_err(),
    }
}
