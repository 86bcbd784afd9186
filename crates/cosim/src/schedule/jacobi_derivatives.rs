//! As the schedule `jacobi`, with first time derivatives passed besides the values.

use anyhow::Result;

use super::jacobi;
use crate::coupling::Coupling;

/// Pass values and derivatives.
pub fn exchange(coupling: &mut Coupling, t: f64) -> Result<()> {
    coupling.pass(t)?;
    coupling.pass_derivatives(t)
}

/// Step all components, then pass values and derivatives.
pub fn advance(coupling: &mut Coupling, t: f64, h: f64, end: f64) -> Result<()> {
    jacobi::advance(coupling, t, h, end)?;
    coupling.pass_derivatives(end)
}
