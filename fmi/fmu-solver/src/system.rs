//! What a solver integrates.

/// Differential equations x' = f(t, x) over one communication step. Times `s` are in s from its
/// start, so that a system can look at inputs as they change within the step.
///
/// A method that cannot evaluate gives an error; solvers with a step size of their own then try a
/// smaller one.
pub trait System {
    /// Why something cannot be evaluated.
    type Error;

    /// The time derivatives `dx` of the states `x` at `s`, per s.
    ///
    /// # Errors
    /// The derivatives cannot be evaluated there.
    fn derivative(&mut self, s: f64, x: &[f64], dx: &mut [f64]) -> Result<(), Self::Error>;

    /// The directional derivative `change` = ∂f/∂x · `seed` at `s` and `x`; false if the system has
    /// none, and differences take its place.
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

    /// The event indicators `z` at `s` and `x`. An event is where one of them passes from positive
    /// to not positive or back. Only called where there are some.
    ///
    /// # Errors
    /// The indicators cannot be evaluated there.
    fn indicators(&mut self, _s: f64, _x: &[f64], _z: &mut [f64]) -> Result<(), Self::Error> {
        Ok(())
    }
}
