//! A hyperbolic tangent for the network and for friction and gear in `maps`; it is bit-identical on
//! every machine and can be inlined and vectorised.

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

/// Largest absolute error.
///
/// `1 − 2/(e + 1)` passes on a quarter of the relative error of `e` at 0, twice
/// `e/(e+1)²` elsewhere, never more than half: 3.2e-15 from the series, 2e-15 from rounding.
#[cfg(test)]
pub(crate) const ERROR: f64 = 6e-15;

/// tanh for the equations of the physics. Beyond saturation, where the friction of a moving
/// actuator is, the series is not computed; its value there is ±1 too.
pub(crate) fn tanh(x: f64) -> f64 {
    if x.abs() >= SATURATION {
        return 1.0_f64.copysign(x);
    }
    series(x)
}

/// tanh without a branch or a call, so that a loop over it vectorises.
///
/// `tanh x = 1 − 2/(e^{2x} + 1)`, `e^{2x} = 2ⁿ·e^r`, `n = round(2x/ln 2)`. The series is summed in
/// pairs (Estrin), which the processor computes side by side, unlike Horner's chain. NaN stays NaN.
#[inline(always)]
pub(crate) fn series(x: f64) -> f64 {
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

    /// The physics' tanh saturates exactly where the series has come to ±1.
    #[test]
    fn saturation_is_no_jump() {
        assert_eq!(series(SATURATION), 1.0);
        for x in [21.0, 400.0, 1e3, 1e300] {
            assert_eq!((series(x), series(-x)), (1.0, -1.0), "{x}");
        }
        assert_eq!(tanh(-SATURATION), series(-SATURATION));
        assert!(tanh(18.0) < 1.0 && tanh(18.0) == series(18.0));
    }

    /// Oracle: the standard library. The bound is derived at [`ERROR`].
    #[test]
    fn fast_tanh_keeps_its_error() {
        let mut worst: f64 = 0.0;
        for k in -2_000_000..=2_000_000 {
            let x = f64::from(k) * 1.1e-5;
            worst = worst.max((tanh(x) - x.tanh()).abs());
        }
        assert!(worst < ERROR, "{worst:e}");
        assert!(worst > 0.05 * ERROR, "bound is not sharp: {worst:e}");
        assert_eq!(tanh(f64::INFINITY), 1.0);
        assert_eq!(tanh(-1e300), -1.0);
        assert!(tanh(f64::NAN).is_nan());
    }
}
