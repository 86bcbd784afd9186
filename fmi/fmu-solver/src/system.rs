//! [`System`]: the differential equations that a solver integrates, implemented by `fmu-export`.

/// Differential equations x' = f(t, x) with event indicators, over one communication step. Times
/// `s` are in s from its start, so that a system can evaluate inputs that change within the step.
///
/// A method returns an error if it cannot evaluate; adaptive solvers then try a smaller step.
pub trait System {
    /// Why something cannot be evaluated.
    type Error;

    /// The time derivatives `dx` of the states `x` at `s`, per s.
    ///
    /// # Errors
    /// The derivatives cannot be evaluated there.
    fn derivative(&mut self, s: f64, x: &[f64], dx: &mut [f64]) -> Result<(), Self::Error>;

    /// The directional derivative `change` = ∂f/∂x · `seed` at `s` and `x`; returns false if the
    /// system has none, and differences are used.
    ///
    /// # Errors
    /// The derivatives cannot be evaluated there.
    fn directional(
        &mut self,
        _s: f64,
        _x: &[f64],
        _seed: &[f64],
        _change: &mut [f64],
    ) -> Result<bool, Self::Error> {
        Ok(false)
    }

    /// Whether a shorter step may help after this error; otherwise the solver returns it.
    fn may_retry(&self, _error: &Self::Error) -> bool {
        true
    }

    /// The event indicators `z` at `s` and `x`, if there are any. An event occurs where one of them
    /// changes from positive to not positive or back.
    ///
    /// # Errors
    /// The indicators cannot be evaluated there.
    fn indicators(&mut self, _s: f64, _x: &[f64], _z: &mut [f64]) -> Result<(), Self::Error> {
        Ok(())
    }
}
