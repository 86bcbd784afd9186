//! Tests in `check`: a model's directional derivatives agree with differences of the outputs, and
//! its adjoint derivatives with the directional ones.

use super::model_check::ModelCheck;
use super::point::Point;
use crate::core::derivatives::ROOT_OF_EPSILON;
use crate::core::layout::Element;
use crate::core::model::{real_inputs, real_outputs, zero};
use crate::core::storage::Storage;
use crate::core::value::Value;
use crate::{Evaluation, Model, ModelError};

/// Relative deviation allowed between a derivative and a difference, beyond the difference's error.
const TOLERANCE: f64 = 1e-4;
/// Rounding of the sums in the transpose identity, relative to their terms.
const ROUNDING: f64 = 1e-10;

/// Weights from 0.5 to 1.5 of either sign; neighbouring weights differ.
fn weight(k: usize) -> f64 {
    let size = 0.5 + ((5 * k + 3) % 11) as f64 / 10.0;
    if k.is_multiple_of(3) { -size } else { size }
}

/// Whether a derivative deviates from a difference; `far` is the difference with twice the step.
fn is_far(said: f64, found: f64, far: f64, rounding: f64) -> bool {
    let scale = said.abs().max(found.abs());
    let error = TOLERANCE * scale + 4.0 * (found - far).abs() + rounding;
    (said - found).is_nan() || (said - found).abs() > error
}

/// The inputs with one of them changed by `by`, if that is within its bounds.
pub(super) fn shift_input<M: Model>(
    u: &M::Input,
    (i, row): Element<M>,
    by: f64,
) -> Option<M::Input> {
    let Storage::RealIn(field) = &row.storage else {
        return None;
    };
    let mut u = u.clone();
    let value = field.get_mut(&mut u, i);
    *value += by;
    value.is_allowed(row).then_some(u)
}

impl<M: Model> ModelCheck<M> {
    /// Checks the derivatives of a model in one state.
    pub(super) fn derivatives(&mut self, model: &M, point: &Point<M>) {
        if !M::INFO.directional_derivatives {
            return;
        }
        // An input that counts its sets has an effect only once it was set.
        let mut point = point.clone();
        point.set_inputs();
        let Point(p, u) = &point;
        let Ok(now) = M::Evaluation::new(model, p, u) else {
            return;
        };
        let directional = |du: &M::Input| {
            let dy = model.directional_derivative(p, u, &now, du)?;
            Ok::<Vec<f64>, ModelError>(real_outputs::<M>(&dy).collect())
        };
        let result = (|| {
            let columns = self.columns(model, &point, &directional)?;
            self.transpose(model, &point, &now, &columns, &directional)
        })();
        if let Err(error) = result {
            self.problems.insert(format!("derivatives: {error}"));
        }
    }

    /// Compares the derivatives with respect to each Real input with differences. A second
    /// difference with twice the step estimates their error, which is large near a kink.
    fn columns(
        &mut self,
        model: &M,
        point: &Point<M>,
        directional: &impl Fn(&M::Input) -> Result<Vec<f64>, ModelError>,
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let elements: Vec<_> = self.layout.iter().enumerate().collect();
        let outputs = self.real_outputs();
        let at = |u: M::Input| {
            let now = M::Evaluation::new(model, &point.0, &u).ok()?;
            let y = model.output(&point.0, &u, &now).ok()?;
            Some(real_outputs::<M>(&y).collect::<Vec<_>>())
        };
        let mut columns = Vec::new();
        for (known, element) in elements {
            let (i, row) = element;
            let Storage::RealIn(field) = &row.storage else {
                continue;
            };
            let mut du = zero::<M>(&point.1);
            *field.get_mut(&mut du, i) = 1.0;
            let column = directional(&du)?;
            let size = row.nominal.unwrap_or(1.0).max(field.get(&point.1, i).abs());
            self.compare_column(known, &outputs, size, &column, |by| {
                at(shift_input::<M>(&point.1, element, by)?)
            });
            columns.push(column);
        }
        Ok(columns)
    }

    /// The positions of the Real outputs and local variables.
    pub(super) fn real_outputs(&self) -> Vec<usize> {
        let elements = self.layout.iter().enumerate();
        let outputs = elements.filter(|(_, (_, row))| matches!(row.storage, Storage::RealOut(_)));
        outputs.map(|(k, _)| k).collect()
    }

    /// Compares the model's derivative `said` of the elements `of` with respect to `known`, of
    /// magnitude `size`, with differences; `at` computes the elements with `known` changed. At a
    /// kink, any slope between those of its two sides is accepted.
    pub(super) fn compare_column(
        &mut self,
        known: usize,
        of: &[usize],
        size: f64,
        said: &[f64],
        at: impl Fn(f64) -> Option<Vec<f64>>,
    ) {
        let step = ROOT_OF_EPSILON * size;
        let around = |step: f64| Some([at(-step)?, at(step)?]);
        let (Some(y), Some(near), Some(far)) = (at(0.0), around(step), around(2.0 * step)) else {
            return;
        };
        for (k, &said) in said.iter().enumerate() {
            let central =
                |[less, more]: &[Vec<f64>; 2], step: f64| (more[k] - less[k]) / (2.0 * step);
            let (found, far) = (central(&near, step), central(&far, 2.0 * step));
            let (left, right) = ((y[k] - near[0][k]) / step, (near[1][k] - y[k]) / step);
            let side = match (left.min(right), left.max(right)) {
                (low, high) if low.is_nan() || high.is_nan() => found,
                (low, high) => said.max(low).min(high),
            };
            let rounding = 1e3 * f64::EPSILON * y[k].abs() / step;
            if said.is_nan() || is_far(said, side, far + (side - found), rounding) {
                let (output, input) = (self.name(of[k]), self.name(known));
                self.problems.insert(format!(
                    "the directional derivative of `{output}` by `{input}` is {said:.4e}, differences of the output give {found:.4e}"
                ));
            }
        }
    }

    /// With any u and v: `J v` is the columns of J times v, and `v · (Jᵀ u)` = `u · (J v)`.
    fn transpose(
        &mut self,
        model: &M,
        point: &Point<M>,
        now: &M::Evaluation,
        columns: &[Vec<f64>],
        directional: &impl Fn(&M::Input) -> Result<Vec<f64>, ModelError>,
    ) -> Result<(), ModelError> {
        let mut v = zero::<M>(&point.1);
        for (n, (i, field)) in real_inputs::<M>(&point.1).enumerate() {
            *field.get_mut(&mut v, i) = weight(n);
        }
        let outputs = columns.first().map_or(0, Vec::len);
        let u: Vec<_> = (0..outputs).map(|k| weight(k + 1)).collect();
        let adjoint = model.adjoint_derivative(&point.0, &point.1, now, &u)?;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let forward = dot(&u, &directional(&v)?);
        let (mut by_columns, mut backward, mut size) = (0.0, 0.0, 0.0);
        for (n, ((i, field), column)) in real_inputs::<M>(&v).zip(columns).enumerate() {
            backward += weight(n) * field.get(&adjoint, i);
            by_columns += weight(n) * dot(&u, column);
            size += column.iter().map(|x| 2.25 * x.abs()).sum::<f64>(); // 1.5² is the largest product of weights
        }
        for (found, what) in [
            (by_columns, "its own columns"),
            (backward, "the adjoint derivative"),
        ] {
            if (forward - found).is_nan() || (forward - found).abs() > ROUNDING * size {
                self.problems.insert(format!(
                    "the directional derivative u·(J v) = {forward:.4} must be v·(J' u) = {found:.4} by {what}"
                ));
            }
        }
        Ok(())
    }
}
