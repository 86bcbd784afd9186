//! One component after the other; a later one gets the mean effort that an earlier one exerted over
//! the step.

use anyhow::Result;

use crate::coupling::Coupling;

/// Step the components in their order, then pass all connections.
pub fn advance(coupling: &mut Coupling, t: f64, h: f64, end: f64) -> Result<()> {
    coupling.step_all(t, h, true)?;
    coupling.note_bonds(h, true);
    coupling.enter_events(end)?;
    coupling.pass(end)?;
    coupling.account(h);
    Ok(())
}
