//! Get all, set all, step all: what FMI 2.0 promises between masters and FMUs.

use anyhow::Result;

use crate::exchange::algebraic_loop::LoopStage;
use crate::exchange::coupling::{Coupling, Saved};
use crate::instance::At;

/// Read all outputs at the start time.
pub fn begin(coupling: &mut Coupling, t: f64) -> Result<()> {
    coupling.read(t)
}

/// Set all inputs, in Event Mode where discrete ones change.
pub fn prepare(coupling: &mut Coupling, t: f64) -> Result<()> {
    coupling.write(t)?;
    coupling.settle(t)
}

/// Step all components, read all outputs. Where loops are solved, that is repeated until the inputs
/// of a loop have had over the step what its outputs are at the end.
pub fn advance(coupling: &mut Coupling, t: f64, h: f64, end: f64) -> Result<()> {
    match coupling.exchange.over_step.take() {
        None => make(coupling, t, h, end)?,
        Some(mut unknowns) => {
            let saved = &coupling.save(t)?;
            let flows = coupling.flows();
            let step = &mut RepeatedStep {
                coupling,
                saved,
                time: [t, h, end],
            };
            let solved = unknowns.solve(step, At::Time(end));
            coupling.exchange.over_step = Some(unknowns);
            solved?;
            coupling.note_flows_before(&flows);
        }
    }
    coupling.account(h);
    Ok(())
}

fn make(coupling: &mut Coupling, t: f64, h: f64, end: f64) -> Result<()> {
    coupling.step_all(t, h, false)?;
    coupling.note_bonds(h, false);
    coupling.read(end)
}

/// A step whose inputs are sought.
struct RepeatedStep<'a> {
    coupling: &'a mut Coupling,
    saved: &'a Saved,
    /// From, by and to, s.
    time: [f64; 3],
}

impl LoopStage for RepeatedStep<'_> {
    fn values(&mut self) -> &mut [f64] {
        &mut self.coupling.exchange.values
    }

    fn write_and_read(&mut self) -> Result<()> {
        let [t, h, end] = self.time;
        prepare(self.coupling, t)?;
        make(self.coupling, t, h, end)
    }

    fn rewind(&mut self) -> Result<()> {
        self.coupling.restore(self.saved, self.time[0])
    }
}
