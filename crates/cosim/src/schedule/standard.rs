//! Get all, set all, step all: what FMI 2.0 promises between masters and FMUs.

use anyhow::Result;

use crate::coupling::Coupling;

/// Read all outputs at the start time.
pub fn begin(coupling: &mut Coupling, t: f64) -> Result<()> {
    coupling.read(t)
}

/// Set all inputs, in Event Mode where discrete ones change.
pub fn prepare(coupling: &mut Coupling, t: f64) -> Result<()> {
    coupling.write(t)?;
    coupling.settle(t)
}

/// Step all components, read all outputs.
pub fn advance(coupling: &mut Coupling, t: f64, h: f64, end: f64) -> Result<()> {
    coupling.step_all(t, h, false)?;
    coupling.note_bonds(h, false);
    coupling.read(end)?;
    coupling.account(h);
    Ok(())
}
