//! The schedule `standard`, called by `schedule`: get all outputs, set all inputs, step all
//! components. FMI 2.0 guarantees nothing more.

use anyhow::Result;

use crate::exchange::algebraic_loop::LoopStage;
use crate::exchange::bond::BondSlots;
use crate::exchange::coupling::{Coupling, Saved};
use crate::instance::At;

/// Set all inputs, in Event Mode if discrete ones change.
pub fn prepare(coupling: &mut Coupling, t: f64) -> Result<()> {
    coupling.exchange.write(&coupling.instances, At::Time(t))?;
    coupling.settle(t)
}

/// Step all components from `t` by `h` and read all outputs at `end`, all s. If loops are solved,
/// the step is repeated until the inputs of a loop over the step equal its outputs at the end.
pub fn advance(coupling: &mut Coupling, [t, h, end]: [f64; 3]) -> Result<()> {
    match coupling.exchange.over_step.take() {
        None => step(coupling, [t, h, end])?,
        Some(mut unknowns) => {
            let saved = &coupling.save(t)?;
            let flow = |bond: &BondSlots| coupling.exchange.values[bond.flow_slot];
            let flows: Vec<f64> = coupling.bonds.iter().map(flow).collect();
            let repeated = &mut RepeatedStep {
                coupling,
                saved,
                time: [t, h, end],
            };
            let solved = unknowns.solve(repeated, At::Time(end));
            coupling.exchange.over_step = Some(unknowns);
            solved?;
            // Those before the step differ from those given over a repeated one.
            for (bond_step, flow) in coupling.bond_steps.iter_mut().zip(flows) {
                bond_step.flow_before = flow;
            }
        }
    }
    coupling.account(h);
    coupling.watch_unconnected(end)
}

fn step(coupling: &mut Coupling, [t, h, end]: [f64; 3]) -> Result<()> {
    coupling.step_all(t, h, false)?;
    coupling.record_bonds(h, false);
    coupling.read(end)
}

/// A step that is repeated until the unknowns among its inputs are found.
struct RepeatedStep<'a> {
    coupling: &'a mut Coupling,
    saved: &'a Saved,
    /// Start, length and end of the step, s.
    time: [f64; 3],
}

impl LoopStage for RepeatedStep<'_> {
    fn values(&mut self) -> &mut [f64] {
        &mut self.coupling.exchange.values
    }

    fn write_and_read(&mut self) -> Result<()> {
        prepare(self.coupling, self.time[0])?;
        step(self.coupling, self.time)
    }

    fn rewind(&mut self) -> Result<()> {
        self.coupling.restore(self.saved, self.time[0])
    }
}
