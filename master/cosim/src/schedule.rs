//! In which order outputs are read, inputs are set and components are stepped: at once
//! (`standard`), or by stages in the order of direct feedthrough (`staged`).

mod choice;
pub mod thread_plan;
pub(crate) mod rates;
mod staged;
mod standard;

use anyhow::Result;

pub use choice::{Between, Jitter, STEP, Schedule, Stepping, steps_in};
pub use rates::parse_rate;

use crate::exchange::coupling::Coupling;

/// The first exchange, at the start time `t`, s.
pub(crate) fn begin(schedule: Schedule, coupling: &mut Coupling, t: f64) -> Result<()> {
    match schedule {
        Schedule::Standard => standard::begin(coupling, t),
        _ => staged::pass(coupling, t),
    }
}

/// What the instances are given at `t`, s, before the step from there; afterwards it is known when
/// their next events are.
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
    match schedule {
        Schedule::Standard => standard::advance(coupling, t, h, end),
        // One component after the other: a later one gets the mean effort that an earlier one
        // exerted over the step.
        Schedule::GaussSeidel => staged::advance(coupling, t, h, end, true),
        // All from the values at the communication point, held over the step or with derivatives.
        Schedule::Jacobi | Schedule::JacobiDerivatives => {
            staged::advance(coupling, t, h, end, false)
        }
    }
}
