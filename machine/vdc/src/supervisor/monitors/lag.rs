//! First-order lags, for the monitors.

/// Share of a step that a first-order lag reaches in a time of `over` time constants.
pub(super) fn share(over: f64) -> f64 {
    -libm::expm1(-over)
}
