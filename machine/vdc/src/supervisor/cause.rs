//! Why the supervisor acts: the values of the output `supervisor.cause`.

use serde::{Deserialize, Serialize};

/// Why the supervisor acts. New causes are appended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cause {
    /// It does not act, or a reset ends what it did.
    #[default]
    None,
    /// A rod swings.
    Swinging,
    /// The force of a rod stays at its limit and above its rating.
    Overload,
    /// A drive has tripped.
    Tripped,
    /// The tip does not follow its reference, or its error jumps.
    Following,
    /// A joint's encoder and its motor, or its rod, tell different motions.
    JointEncoder,
    /// A joint's angle is not the integral of its rate.
    JointRate,
    /// A reading no longer changes.
    Stale,
    /// A motor's torque does not fit the force of its rod: a brake drags, or a sensor errs.
    Torque,
    /// A drive does not give the commanded current.
    Current,
    /// A joint of the wrist runs away.
    WristRate,
}
