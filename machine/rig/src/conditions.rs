//! What stays as it is over a substep: gates and brake.

use machine_file::Holding;

/// Conditions that do not change during a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions {
    /// Whether the inverter's gates are on. While they are off no current flows: see
    /// [`Rig::update_gates`].
    pub gates: bool,
    /// What the brake does.
    pub brake: Holding,
}
