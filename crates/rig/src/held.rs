//! What stays as it is over a substep: gates and brake.

use machine::Holding;

/// What a substep holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Whether the inverter's gates are on. While they are off no current flows: see
    /// [`Rig::switched`].
    pub gates: bool,
    /// What the brake does.
    pub brake: Holding,
}
