//! Saturation of a command, for the wrist's torques and drives and for the controller.

/// `x` saturated to ±`limit`. Unlike [`f64::clamp`] it does not panic for an invalid limit, which a
/// damaged saved state may have. NaN stays NaN.
#[inline(always)]
pub fn saturate(x: f64, limit: f64) -> f64 {
    if x.abs() > limit {
        limit.copysign(x)
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saturation_is_symmetric_and_senseless_limits_do_not_panic() {
        for x in [-3.0, -2.0, 0.5, 2.0, 7.0] {
            assert_eq!(saturate(x, 2.0), x.clamp(-2.0, 2.0));
        }
        assert!(saturate(f64::NAN, 2.0).is_nan());
        assert!(saturate(1.0, -2.0).is_finite() && saturate(1.0, f64::NAN) == 1.0);
    }
}
