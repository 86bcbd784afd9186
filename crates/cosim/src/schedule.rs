//! In which order outputs are read, inputs are set and components are stepped: one file a schedule.

mod choice;
mod gauss_seidel;
mod jacobi;
mod jacobi_derivatives;
pub(crate) mod rates;
mod standard;

use anyhow::Result;

pub use choice::{Between, Jitter, STEP, Schedule, Stepping, steps_in};
pub use rates::parse_rate;

use crate::coupling::Coupling;

/// The first exchange, at the start time `t`, s.
pub(crate) fn begin(schedule: Schedule, coupling: &mut Coupling, t: f64) -> Result<()> {
    match schedule {
        Schedule::Standard => standard::begin(coupling, t),
        Schedule::GaussSeidel | Schedule::Jacobi => coupling.pass(t),
        Schedule::JacobiDerivatives => jacobi_derivatives::exchange(coupling, t),
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
        Schedule::GaussSeidel => gauss_seidel::advance(coupling, t, h, end),
        Schedule::Jacobi => jacobi::advance(coupling, t, h, end),
        Schedule::JacobiDerivatives => jacobi_derivatives::advance(coupling, t, h, end),
    }
}
