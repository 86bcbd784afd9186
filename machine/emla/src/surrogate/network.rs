//! Evaluates the network for `Surrogate`: fixed shapes, no allocation, same bits on every machine.
//!
//! Source: `[paper]` Eq. (eq:dnn_structure), `y = W_6·σ(… σ(W_1·x + b_1) …) + b_6`, σ = tanh.
//! Weights of one input are contiguous, so that the compiler vectorises the inner loop over the
//! outputs. Every sum is over the inputs in their order, and product and sum are rounded
//! separately, because a fused operation does not exist everywhere (x86 before 2013, WebAssembly).
//! So the instruction set, also chosen at run time on x86-64, changes only the speed.

use crate::tanh;

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

    /// `W·x + b` for `B` inputs, which share the loads of the weights; registers hold `LANES`.
    #[inline(always)]
    fn affine<const LANES: usize, const B: usize>(&self, x: &[[f64; IN]; B]) -> [[f64; OUT]; B] {
        const { assert!(IN.is_multiple_of(2) && OUT.is_multiple_of(2)) };
        let mut y = [self.bias; B];
        let mut first = 0;
        // Some eight sums in flight hide the latency of an addition and still fit 16 registers;
        // where registers are widest there are 32.
        let widest = match (LANES, B) {
            (8, 1) => 48,
            (8, _) | (4, _) => 16,
            _ => 8,
        };
        self.add_blocks::<48, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<32, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<16, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<8, B>(x, &mut y, &mut first, widest);
        self.add_blocks::<2, B>(x, &mut y, &mut first, widest);
        y
    }

    /// Adds `W·x` to the outputs from `first` on in blocks of `N` while as many are left, unless
    /// `N` exceeds `widest`. Even and odd inputs have separate sums, for parallel additions.
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
            *y_j = tanh::series(*y_j);
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

    /// Scaled outputs of `B` scaled inputs, with the processor's best instruction set.
    pub(super) fn evaluate<const B: usize>(&self, x: [[f64; 2]; B]) -> [[f64; 2]; B] {
        #[cfg(target_arch = "x86_64")]
        return pulp::Arch::new().dispatch(Forward { network: self, x });
        #[cfg(not(target_arch = "x86_64"))]
        self.forward::<2, B>(&x)
    }

    /// Scaled outputs of `B` scaled inputs with registers of `LANES` numbers. Only the widest can
    /// hold the sums of several points; otherwise one point at a time is faster.
    #[inline(always)]
    fn forward<const LANES: usize, const B: usize>(&self, x: &[[f64; 2]; B]) -> [[f64; 2]; B] {
        if LANES == 8 {
            return self.layers::<LANES, B>(x);
        }
        let mut y = [[0.0; 2]; B];
        for (y, x) in y.iter_mut().zip(x) {
            [*y] = self.layers::<LANES, 1>(&[*x]);
        }
        y
    }

    #[inline(always)]
    fn layers<const LANES: usize, const B: usize>(&self, x: &[[f64; 2]; B]) -> [[f64; 2]; B] {
        let a = self.l1.hidden::<LANES, B>(x);
        let a = self.l2.hidden::<LANES, B>(&a);
        let a = self.l3.hidden::<LANES, B>(&a);
        let a = self.l4.hidden::<LANES, B>(&a);
        let a = self.l5.hidden::<LANES, B>(&a);
        self.l6.affine::<LANES, B>(&a)
    }
}

/// [`Network::forward`] for the run-time choice of the instruction set: compiled and vectorised
/// once for each generation of x86-64 processors.
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

#[cfg(test)]
mod tests {
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
}
