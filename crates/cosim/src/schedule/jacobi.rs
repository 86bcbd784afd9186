//! All components stepped from the values at the communication point, held over the step.

use anyhow::Result;

use crate::coupling::Coupling;

/// Step all components, then pass all connections.
pub fn advance(coupling: &mut Coupling, t: f64, h: f64, end: f64) -> Result<()> {
    coupling.step_all(t, h, false)?;
    coupling.note_bonds(h, false);
    coupling.enter_events(end)?;
    coupling.pass(end)?;
    coupling.account(h);
    Ok(())
}
