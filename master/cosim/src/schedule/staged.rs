//! Outputs are read again after inputs were set, in the order of direct feedthrough.

use anyhow::Result;

use crate::exchange::coupling::Coupling;

/// Pass all connections, and derivatives where the schedule has some.
pub fn pass(coupling: &mut Coupling, t: f64) -> Result<()> {
    coupling.pass(t)?;
    coupling.pass_derivatives(t)
}

/// Step the components in their order, then pass all connections. With `gives_means` a component
/// gets the mean efforts of those before it.
pub fn advance(coupling: &mut Coupling, t: f64, h: f64, end: f64, gives_means: bool) -> Result<()> {
    coupling.step_all(t, h, gives_means)?;
    coupling.note_bonds(h, gives_means);
    coupling.enter_events(end)?;
    coupling.pass(end)?;
    coupling.account(h);
    coupling.pass_derivatives(end)
}
