//! The schedules of a run, which the master calls: the order in which outputs are read, inputs set
//! and components stepped. `standard` does each once for all components. The others
//! pass values in the order of direct feedthrough, and read outputs again after inputs were set.

mod choice;
pub(crate) mod rates;
mod standard;
pub(crate) mod thread_plan;

use anyhow::Result;

pub use choice::{Between, Jitter, STEP, Schedule, Stepping, steps_in};
pub use rates::parse_rate;

use crate::exchange::coupling::Coupling;

/// The first exchange, at the start time `t`, s.
pub(crate) fn begin(schedule: Schedule, coupling: &mut Coupling, t: f64) -> Result<()> {
    match schedule {
        Schedule::Standard => {
            coupling.read(t)?;
            coupling.watch_unconnected(t)
        }
        _ => {
            coupling.watch_unconnected(t)?;
            coupling.pass(t)?;
            coupling.pass_derivatives(t)
        }
    }
}

/// Prepare the instances at `t`, s, for the step from there; afterwards the times of their next
/// events are known.
pub(crate) fn prepare(schedule: Schedule, coupling: &mut Coupling, t: f64) -> Result<()> {
    match schedule {
        Schedule::Standard => standard::prepare(coupling, t),
        _ => coupling.leave_events(t),
    }
}

/// A communication step from `t` by `h` that ends at `end`, all s, and the exchange there.
pub(crate) fn advance(
    schedule: Schedule,
    coupling: &mut Coupling,
    [t, h, end]: [f64; 3],
) -> Result<()> {
    if schedule == Schedule::Standard {
        return standard::advance(coupling, [t, h, end]);
    }
    let gives_means = schedule == Schedule::GaussSeidel;
    coupling.step_all(t, h, gives_means)?;
    coupling.record_bonds(h, gives_means);
    coupling.enter_events(end)?;
    coupling.watch_unconnected(end)?;
    coupling.pass(end)?;
    coupling.account(h);
    coupling.pass_derivatives(end)
}
