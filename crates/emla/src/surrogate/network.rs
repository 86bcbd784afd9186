//! The network itself: fixed shapes, no allocation, the same bits on every machine.
//!
//! Source: `[paper]` Eq. (eq:dnn_structure), `y = W_6·σ(… σ(W_1·x + b_1) …) + b_6`, σ = tanh.
//! Weights are stored with the outputs side by side, so that the inner loop runs over
//! neighbouring memory and the compiler vectorises it. Every sum is taken over the inputs in
//! their order, and product and sum are rounded apart, because a fused operation does not exist
//! everywhere (x86 before 2013, WebAssembly). So the instructions that are chosen, when the code is
//! compiled or on x86-64 at run time, change the speed, never a bit of the result.

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

    /// `W·x + b` for `B` inputs at once (they share the loads of the weights), on registers of
    /// `LANES` numbers.
    #[inline(always)]
    fn affine<const LANES: usize, const B: usize>(&self, x: &[[f64; IN]; B]) -> [[f64; OUT]; B] {
        const { assert!(IN.is_multiple_of(2) && OUT.is_multiple_of(2)) };
        let mut y = [self.bias; B];
        let mut first = 0;
        // Some eight sums in flight hide the latency of an addition and still fit 16 registers;
        // where registers are widest there are 32.
        let widest = match (LANES, B) {
            (8, 1) => 48,
            (8, _) | (4, 1) => 16,
            (4, _) | (_, 1) => 8,
            _ => 4,
        };
        self.add_blocks::<48, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<32, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<16, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<8, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<4, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<2, B>(x, &mut y, &mut first, widest);
        y
    }

    /// Adds `W·x` to the outputs from `first` on, `N` at a time as long as so many are left, unless
    /// `N` is more than the `widest` block. Even and odd inputs have a sum each, so that additions
    /// do not wait for each other.
    #[inline(always)]
    fn add_blocks<const N: usize, const B: usize>(
        &self,
        x: &[[f64; IN]; B],
        y: &mut [[f64; OUT]; B],
        first: &mut usize,
        widest: usize,
    ) {
        while N <= widest && *first + N <= OUT {
            let block = *first..*first + N;
            let (mut even, mut odd) = ([[0.0; N]; B], [[0.0; N]; B]);
            for (pair, [row_even, row_odd]) in self.weights.as_chunks::<2>().0.iter().enumerate() {
                let (w_even, w_odd) = (&row_even[block.clone()], &row_odd[block.clone()]);
                for b in 0..B {
                    let (x_even, x_odd) = (x[b][2 * pair], x[b][2 * pair + 1]);
                    for j in 0..N {
                        even[b][j] += w_even[j] * x_even;
                        odd[b][j] += w_odd[j] * x_odd;
                    }
                }
            }
            for (b, y) in y.iter_mut().enumerate() {
                for (j, y) in y[block.clone()].iter_mut().enumerate() {
                    *y += even[b][j] + odd[b][j];
                }
            }
            *first += N;
        }
    }

    /// `tanh(W·x + b)`.
    #[inline(always)]
    fn hidden<const LANES: usize, const B: usize>(&self, x: &[[f64; IN]; B]) -> [[f64; OUT]; B] {
        let mut y = self.affine::<LANES, B>(x);
        for y_j in y.as_flattened_mut() {
            *y_j = tanh_series(*y_j);
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
        #[cfg(target_arch = "x86_64")]
        return pulp::Arch::new().dispatch(Forward { network: self, x });
        #[cfg(not(target_arch = "x86_64"))]
        self.forward::<2, B>(&x)
    }

    #[inline(always)]
    fn forward<const LANES: usize, const B: usize>(&self, x: &[[f64; 2]; B]) -> [[f64; 2]; B] {
        let a = self.l1.hidden::<LANES, B>(x);
        let a = self.l2.hidden::<LANES, B>(&a);
        let a = self.l3.hidden::<LANES, B>(&a);
        let a = self.l4.hidden::<LANES, B>(&a);
        let a = self.l5.hidden::<LANES, B>(&a);
        self.l6.affine::<LANES, B>(&a)
    }
}

/// [`Network::forward`] as a task for the run-time choice of instructions: it is compiled once for
/// each kind of x86-64 processor, and the compiler vectorises it for that.
#[cfg(target_arch = "x86_64")]
struct Forward<'a, const B: usize> {
    network: &'a Network,
    x: [[f64; 2]; B],
}

#[cfg(target_arch = "x86_64")]
impl<const B: usize> pulp::WithSimd for Forward<'_, B> {
    type Output = [[f64; 2]; B];

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        match S::F64_LANES {
            8 => self.network.forward::<8, B>(&self.x),
            4 => self.network.forward::<4, B>(&self.x),
            _ => self.network.forward::<2, B>(&self.x),
        }
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
    tanh_series(x)
}

/// tanh without a branch or a call, so that a loop over it vectorises.
///
/// `tanh x = 1 − 2/(e^{2x} + 1)`, `e^{2x} = 2ⁿ·e^r`, `n = round(2x/ln 2)`. The series is summed in pairs (Estrin), which
/// the processor computes side by side, unlike Horner's chain. NaN stays NaN.
#[inline(always)]
fn tanh_series(x: f64) -> f64 {
    let x = if x > SATURATION { SATURATION } else { x };
    let x = if x < -SATURATION { -SATURATION } else { x };
    let y = 2.0 * x;
    let shifted = y * std::f64::consts::LOG2_E + ROUND;
    let r = (shifted - ROUND) * -std::f64::consts::LN_2 + y;
    let [c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11] = INVERSE_FACTORIALS;
    let (r2, r4) = (r * r, r * r * (r * r));
    let low = (c3 * r + c2) * r2 + (c1 * r + c0);
    let middle = (c7 * r + c6) * r2 + (c5 * r + c4);
    let high = (c11 * r + c10) * r2 + (c9 * r + c8);
    let series = (high * r4 + middle) * r4 + low;
    // The lowest bits of `shifted` hold n; in the exponent's place they are the factor 2ⁿ.
    let two_n = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    1.0 - 2.0 / (series * two_n + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surrogate;

    /// What every processor of this kind has, and sums of one register each, give the bits of the
    /// widest instructions found here.
    #[test]
    fn the_instruction_set_does_not_show() {
        let surrogate = Surrogate::reference();
        let network = surrogate.network();
        for k in 0..300 {
            let x = points(k);
            assert_eq!(network.evaluate(x), network.forward::<2, 2>(&x), "{x:?}");
        }
    }

    /// FNV-1a over the bits of 600 outputs, the same on every target: seen on x86-64 and on
    /// WebAssembly, with SIMD128 and without. It changes with the shipped network and with the
    /// arithmetic.
    #[test]
    fn the_bits_are_those_of_every_target() {
        let surrogate = Surrogate::reference();
        let network = surrogate.network();
        let outputs = (0..300).flat_map(|k| network.evaluate(points(k)));
        let bytes = outputs.flatten().flat_map(|y| y.to_bits().to_le_bytes());
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        });
        assert_eq!(hash, 0x2e66_7cda_d4d6_475a, "{hash:#x}");
    }

    /// Two points, made without a library's sine, which may differ from one system to another.
    fn points(k: u32) -> [[f64; 2]; 2] {
        let spread = |step: f64| (step * f64::from(k)).rem_euclid(2.0) - 1.0;
        [[spread(0.37), spread(0.073)], [spread(0.91), spread(0.019)]]
    }

    /// The physics' tanh saturates exactly where the series has come to ±1.
    #[test]
    fn saturation_is_no_jump() {
        assert_eq!(tanh_series(SATURATION), 1.0);
        for x in [21.0, 400.0, 1e3, 1e300] {
            assert_eq!((tanh_series(x), tanh_series(-x)), (1.0, -1.0), "{x}");
        }
        assert_eq!(tanh(-SATURATION), tanh_series(-SATURATION));
        assert!(tanh(18.0) < 1.0 && tanh(18.0) == tanh_series(18.0));
    }
}
