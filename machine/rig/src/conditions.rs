//! The discrete conditions that are constant over a substep: gates and brake.

use machine_file::BrakeState;

/// Conditions that do not change during a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions {
    /// Whether the inverter's gates are on; while they are off no current flows
    /// ([`Rig::update_gates`]).
    pub gates: bool,
    pub brake: BrakeState,
}
