//! The network itself: fixed shapes, no allocation, the same bits on every machine.
//!
//! Source: `[paper]` Eq. (eq:dnn_structure), `y = W_6·σ(… σ(W_1·x + b_1) …) + b_6`, σ = tanh.
//! Weights are stored with the outputs side by side, so that the inner loop runs over
//! neighbouring memory and the compiler vectorises it. Every sum is taken over the inputs in
//! their order, and product and sum are always fused (rounded once), in software where the processor
//! has no such instruction (x86 before 2013): the instruction set that is found at run time changes
//! the speed, never a bit of the result.

use pulp::{Arch, Scalar, Simd, WithSimd};

/// One affine layer; aligned to cache lines, as wide loads that cross them cost double.
#[repr(align(64))]
#[derive(Clone, Debug)]
pub(super) struct Layer<const IN: usize, const OUT: usize> {
    /// `weights[i][j]` leads from input `i` to output `j`.
    pub(super) weights: [[f64; OUT]; IN],
    pub(super) bias: [f64; OUT],
}

impl<const IN: usize, const OUT: usize> Layer<IN, OUT> {
    pub(super) const ZERO: Self = Self {
        weights: [[0.0; OUT]; IN],
        bias: [0.0; OUT],
    };

    /// `W·x + b` for `B` inputs at once (they share the loads of the weights).
    #[inline(always)]
    fn affine<S: Simd, const B: usize>(&self, simd: S, x: &[[f64; IN]; B]) -> [[f64; OUT]; B] {
        let mut y = [self.bias; B];
        let mut first = 0;
        // Eight sums in flight hide the latency of an addition and still fit 16 registers; where vectors are widest there are 32.
        while B == 1 && S::F64_LANES == 8 && first + 6 * S::F64_LANES <= OUT {
            self.add_columns::<S, B, 6>(simd, x, &mut y, first);
            first += 6 * S::F64_LANES;
        }
        while B == 1 && first + 4 * S::F64_LANES <= OUT {
            self.add_columns::<S, B, 4>(simd, x, &mut y, first);
            first += 4 * S::F64_LANES;
        }
        while first + 2 * S::F64_LANES <= OUT {
            self.add_columns::<S, B, 2>(simd, x, &mut y, first);
            first += 2 * S::F64_LANES;
        }
        while first + S::F64_LANES <= OUT {
            self.add_columns::<S, B, 1>(simd, x, &mut y, first);
            first += S::F64_LANES;
        }
        while first < OUT {
            self.add_columns::<Scalar, B, 1>(Scalar, x, &mut y, first);
            first += 1;
        }
        y
    }

    /// Add `W·x` to the outputs `first..first + V·lanes`; even and odd inputs have a sum each, so
    /// that additions do not wait for each other.
    #[inline(always)]
    fn add_columns<S: Simd, const B: usize, const V: usize>(
        &self,
        simd: S,
        x: &[[f64; IN]; B],
        y: &mut [[f64; OUT]; B],
        first: usize,
    ) {
        let columns = first..first + V * S::F64_LANES;
        let mut even = [[simd.splat_f64s(0.0); V]; B];
        let mut odd = [[simd.splat_f64s(0.0); V]; B];
        for (pair, rows) in self.weights.as_chunks::<2>().0.iter().enumerate() {
            let w_even = S::as_simd_f64s(&rows[0][columns.clone()]).0;
            let w_odd = S::as_simd_f64s(&rows[1][columns.clone()]).0;
            for b in 0..B {
                let x_even = simd.splat_f64s(x[b][2 * pair]);
                let x_odd = simd.splat_f64s(x[b][2 * pair + 1]);
                for v in 0..V {
                    even[b][v] = simd.mul_add_f64s(w_even[v], x_even, even[b][v]);
                    odd[b][v] = simd.mul_add_f64s(w_odd[v], x_odd, odd[b][v]);
                }
            }
        }
        for (b, y) in y.iter_mut().enumerate() {
            let y = S::as_mut_simd_f64s(&mut y[columns.clone()]).0;
            for v in 0..V {
                y[v] = simd.add_f64s(y[v], simd.add_f64s(even[b][v], odd[b][v]));
            }
        }
    }

    /// `tanh(W·x + b)`.
    #[inline(always)]
    fn hidden<S: Simd, const B: usize>(&self, simd: S, x: &[[f64; IN]; B]) -> [[f64; OUT]; B] {
        let mut y = self.affine(simd, x);
        for y_j in y.as_flattened_mut() {
            *y_j = tanh_series(*y_j, f64::mul_add);
        }
        y
    }
}

/// The six layers between scaled inputs and scaled outputs.
#[derive(Clone, Debug)]
pub(super) struct Network {
    pub(super) l1: Layer<2, 64>,
    pub(super) l2: Layer<64, 48>,
    pub(super) l3: Layer<48, 32>,
    pub(super) l4: Layer<32, 16>,
    pub(super) l5: Layer<16, 8>,
    pub(super) l6: Layer<8, 2>,
}

impl Network {
    pub(super) const ZERO: Self = Self {
        l1: Layer::ZERO,
        l2: Layer::ZERO,
        l3: Layer::ZERO,
        l4: Layer::ZERO,
        l5: Layer::ZERO,
        l6: Layer::ZERO,
    };

    /// Scaled outputs of `B` scaled inputs, with the best instructions this processor has.
    pub(super) fn evaluate<const B: usize>(&self, x: [[f64; 2]; B]) -> [[f64; 2]; B] {
        Arch::new().dispatch(Forward { network: self, x })
    }

    #[inline(always)]
    fn forward<S: Simd, const B: usize>(&self, simd: S, x: &[[f64; 2]; B]) -> [[f64; 2]; B] {
        let a = self.l1.hidden(simd, x);
        let a = self.l2.hidden(simd, &a);
        let a = self.l3.hidden(simd, &a);
        let a = self.l4.hidden(simd, &a);
        let a = self.l5.hidden(simd, &a);
        self.l6.affine(simd, &a)
    }
}

/// [`Network::forward`] as a task for the run-time choice of instructions.
struct Forward<'a, const B: usize> {
    network: &'a Network,
    x: [[f64; 2]; B],
}

impl<const B: usize> WithSimd for Forward<'_, B> {
    type Output = [[f64; 2]; B];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.network.forward(simd, &self.x)
    }
}

/// Beyond this argument tanh differs from ±1 by less than half a unit in the last place.
const SATURATION: f64 = 19.1;

/// 1.5·2⁵²: adding it rounds a number of moderate size to an integer in the lowest mantissa bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// `1/k!`, k = 0 … 11. Beyond, e^r misses by |r|¹²/12! ≤ 6.4e-15 for |r| ≤ ln(2)/2.
const INVERSE_FACTORIALS: [f64; 12] = [
    1.0,
    1.0,
    0.5,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
];

/// Largest absolute error of [`tanh`].
///
/// `1 − 2/(e + 1)` passes on a quarter of the relative error of `e` at 0, twice
/// `e/(e+1)²` elsewhere, never more than half: 3.2e-15 from the series, 2e-15 from rounding.
#[cfg(test)]
pub(super) const TANH_ERROR: f64 = 6e-15;

/// tanh for the equations of the physics. Beyond saturation, where the friction of a moving actuator is, the
/// series is not computed; its value there is ±1 too.
pub(crate) fn tanh(x: f64) -> f64 {
    if x.abs() >= SATURATION {
        return 1.0_f64.copysign(x);
    }
    tanh_series(x, |a, b, c| a * b + c)
}

/// tanh without a branch or a call, so that a loop over it vectorises.
///
/// `tanh x = 1 − 2/(e^{2x} + 1)`, `e^{2x} = 2ⁿ·e^r`, `n = round(2x/ln 2)`. The series is summed in pairs (Estrin), which
/// the processor computes side by side, unlike Horner's chain. NaN stays NaN.
#[inline(always)]
fn tanh_series(x: f64, mul_add: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let x = if x > SATURATION { SATURATION } else { x };
    let x = if x < -SATURATION { -SATURATION } else { x };
    let y = 2.0 * x;
    let shifted = mul_add(y, std::f64::consts::LOG2_E, ROUND);
    let r = mul_add(shifted - ROUND, -std::f64::consts::LN_2, y);
    let [c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11] = INVERSE_FACTORIALS;
    let (r2, r4) = (r * r, r * r * (r * r));
    let low = mul_add(mul_add(c3, r, c2), r2, mul_add(c1, r, c0));
    let middle = mul_add(mul_add(c7, r, c6), r2, mul_add(c5, r, c4));
    let high = mul_add(mul_add(c11, r, c10), r2, mul_add(c9, r, c8));
    let series = mul_add(mul_add(high, r4, middle), r4, low);
    // The lowest bits of `shifted` hold n; in the exponent's place they are the factor 2ⁿ.
    let two_n = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    1.0 - 2.0 / mul_add(series, two_n, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surrogate;

    /// One lane and fused operations in software give the bits of the widest instructions found here.
    #[test]
    fn the_instruction_set_does_not_show() {
        let surrogate = Surrogate::reference();
        let network = surrogate.network();
        for k in 0..300 {
            let x = [
                [(0.37 * f64::from(k)).sin(), (0.73 * f64::from(k)).cos()],
                [(0.91 * f64::from(k)).cos(), (0.19 * f64::from(k)).sin()],
            ];
            assert_eq!(network.evaluate(x), network.forward(Scalar, &x), "{x:?}");
        }
    }

    /// The physics' tanh saturates exactly where the series has come to ±1.
    #[test]
    fn saturation_is_no_jump() {
        let series = |x| tanh_series(x, |a, b, c| a * b + c);
        assert_eq!(series(SATURATION), 1.0);
        for x in [21.0, 400.0, 1e3, 1e300] {
            assert_eq!((series(x), series(-x)), (1.0, -1.0), "{x}");
        }
        assert_eq!(tanh(-SATURATION), series(-SATURATION));
        assert!(tanh(18.0) < 1.0 && tanh(18.0) == series(18.0));
    }
}
