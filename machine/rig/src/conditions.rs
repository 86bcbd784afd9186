//! Gates and brake, constant over a substep; `switching` sets them for the equations of motion.

use machine_file::BrakeState;

/// Conditions that do not change during a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions {
    /// Whether the inverter's gates are on; while they are off no current flows
    /// ([`Rig::update_gates`]).
    pub gates: bool,
    pub brake: BrakeState,
}
