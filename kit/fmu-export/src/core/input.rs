//! Inputs over a communication step, as values and time derivatives at its start, for models.

use super::storage::Accessor;
use serde::{Deserialize, Serialize};

/// Highest order of input derivatives that is used; higher orders are accepted and ignored.
pub const MAX_INPUT_DERIVATIVE: usize = 3;

/// `u(t + s) = Σ_k u⁽ᵏ⁾ sᵏ/k!`: the inputs over one communication step, `s` in s from its start.
///
/// Only Real inputs have derivatives; Integer and Boolean ones keep their value.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct InputPolynomial<I> {
    pub(crate) value: I,
    pub(crate) derivatives: [I; MAX_INPUT_DERIVATIVE],
    pub(crate) order: usize,
}

impl<I: Clone + Default> InputPolynomial<I> {
    /// Inputs that keep their values.
    pub fn held(value: I) -> Self {
        Self {
            value,
            derivatives: std::array::from_fn(|_| I::default()),
            order: 0,
        }
    }

    /// Inputs with time derivatives, first order first; at most [`MAX_INPUT_DERIVATIVE`] are used.
    pub fn with_derivatives(value: I, derivatives: &[I]) -> Self {
        let mut polynomial = Self::held(value);
        for (to, from) in polynomial.derivatives.iter_mut().zip(derivatives) {
            *to = from.clone();
            polynomial.order += 1;
        }
        polynomial
    }

    /// The inputs at the start of the step.
    #[inline]
    pub fn value(&self) -> &I {
        &self.value
    }

    /// Highest order of derivatives for this step; 0 if the inputs keep their values.
    #[inline]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The `k`-th time derivative (`k` = 0: the value), zero beyond [`order`](Self::order). Only
    /// its Real fields have a meaning.
    #[inline]
    pub fn derivative(&self, k: usize) -> I {
        self.known(k).cloned().unwrap_or_default()
    }

    /// The `k`-th derivative, if there is one.
    #[inline]
    fn known(&self, k: usize) -> Option<&I> {
        match k {
            0 => Some(&self.value),
            k if k <= self.order => Some(&self.derivatives[k - 1]),
            _ => None,
        }
    }

    /// Minimum and maximum of one input within a step of `h` s.
    pub(crate) fn range(&self, field: &Accessor<I, f64>, i: usize, h: f64) -> [f64; 2] {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.known(k).map_or(0.0, |u| field.get(u, i)));
        let at = |s: f64| a + s * (b + s / 2.0 * (c + s / 3.0 * d));
        let inside = |&s: &f64| 0.0 < s && s < h;
        // The extrema inside are the roots of b + c s + d/2 s²; the second form of the formula
        // holds for d = 0 too.
        let root = (c * c - 2.0 * b * d).sqrt(); // NaN, hence not inside, if there are none
        let sum = c + root.copysign(c);
        let extrema = [-sum / d, -2.0 * b / sum];
        (extrema.iter().filter(|s| inside(s)).copied())
            .chain([h])
            .map(at)
            .fold([a, a], |[least, most], x| {
                // Keep a NaN, so that it is found to be out of bounds.
                if x.is_nan() {
                    [x, x]
                } else {
                    [least.min(x), most.max(x)]
                }
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oracle: the values at 10⁵ times; between them the polynomial moves by less than its largest
    /// slope times their distance.
    #[test]
    fn the_range_holds_every_value_within_the_step() {
        let field: Accessor<f64, f64> = Accessor::Scalar(|u| u, |u| u);
        for (value, derivatives) in [
            (1.5, [0.0; 3]),
            (1.5, [2.0, 0.0, 0.0]),
            (1.5, [2.0, -7.0, 0.0]),
            (1.5, [-2.0, 7.0, 0.0]),
            (1.5, [2.0, -17.0, 60.0]), // both extrema inside
            (-0.5, [-2.0, 17.0, -60.0]),
            (0.25, [0.0, 3.0, -9.0]),
            (0.25, [0.5, 0.0, -9.0]),
            (0.25, [3.0, 1e-9, 1e-12]),
        ] {
            let h = 0.75;
            let u = InputPolynomial::with_derivatives(value, &derivatives);
            let [least, most] = u.range(&field, 0, h);
            let [b, c, d] = derivatives;
            let at = |k: i32| {
                let s = h * f64::from(k) / 1e5;
                value + b * s + c * s * s / 2.0 + d * s * s * s / 6.0
            };
            let steepest = b.abs() + h * (c.abs() + h * d.abs());
            let near = steepest * h / 1e5 + 1e-15;
            let found = (0..=100_000).map(at);
            let [low, high] = found.fold([value; 2], |[l, h], x| [l.min(x), h.max(x)]);
            assert!(
                (least - low).abs() <= near,
                "{derivatives:?}: {least} {low}"
            );
            assert!(
                (most - high).abs() <= near,
                "{derivatives:?}: {most} {high}"
            );
        }
    }
}
