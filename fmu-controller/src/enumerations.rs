//! Enumerations of the FMU `Controller`, for `table` and `model`: names and numbers of values.

use fmu_export::Items;
use vdc::{Cause, Level, MODES, Mode, RateCommand, Stage};

pub(crate) static MODE: Items<(Mode, bool), { MODES.len() }> =
    Items::new("Mode", "how much of the controller is at work", MODES);

#[rustfmt::skip] // an item a line
pub(crate) static LEVEL: Items<Level, 2> = Items::new("Level", "what the controller follows", [
    (Level::Machine, "machine", "the tip's reference, through inverse kinematics and decomposition"),
    (Level::Actuator, "actuator", "the inputs reference.rod_*, each actuator by itself"),
]);

/// Values of the parameter `trajectory`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TrajectoryItem {
    Cubic,
    Triangular,
    External,
    Rates,
    Path,
}

#[rustfmt::skip] // an item a line
pub(crate) static TRAJECTORY: Items<TrajectoryItem, 5> = Items::new("Trajectory", "desired motion of the tip", [
    (TrajectoryItem::Cubic, "cubic", "edges of a cube"),
    (TrajectoryItem::Triangular, "triangular", "a triangle in the boom plane"),
    (TrajectoryItem::External, "external", "the inputs reference.*"),
    (TrajectoryItem::Rates, "rates", "the inputs rate.joint or rate.tip, an operator's"),
    (TrajectoryItem::Path, "path", "the path that path_file names"),
]);

#[rustfmt::skip] // an item a line
pub(crate) static RATE_COMMAND: Items<RateCommand, 2> = Items::new("RateCommand", "what commanded rates are of", [
    (RateCommand::Joint, "joint", "the six joints, by the inputs rate.joint"),
    (RateCommand::Tip, "tip", "the tip in the world, by the inputs rate.tip"),
]);

#[rustfmt::skip] // an item a line
pub(crate) static SUPERVISOR: Items<Stage, 7> = Items::new("Supervisor", "what the supervisor does", [
    (Stage::Off, "off", "nothing"),
    (Stage::Watching, "watching", "it watches for swinging"),
    (Stage::Frozen, "frozen", "nothing adapts any longer"),
    (Stage::Lowered, "lowered", "the gains are lowered besides"),
    (Stage::Stopping, "stopping", "the joints come to rest"),
    (Stage::Braking, "braking", "the brakes are applied, the gates still on"),
    (Stage::Stopped, "stopped", "the brakes hold rods and wrist, the gates are off"),
]);

#[rustfmt::skip] // an item a line
pub(crate) static CAUSE: Items<Cause, 11> = Items::new("Cause", "why the supervisor acts", [
    (Cause::None, "none", "it does not act"),
    (Cause::Swinging, "swinging", "a rod swings"),
    (Cause::Overload, "overload", "the force of a rod stays at its limit and above its rating"),
    (Cause::Tripped, "tripped", "a drive has tripped"),
    (Cause::Following, "following", "the tip does not follow its reference, or its error jumps"),
    (Cause::JointEncoder, "joint_encoder", "a joint's encoder, its motor and its rod tell different motions"),
    (Cause::JointRate, "joint_rate", "a joint's angle is not the integral of its rate"),
    (Cause::Stale, "stale", "a reading no longer changes"),
    (Cause::Torque, "torque", "a motor's torque does not fit the force of its rod: a brake drags, or a sensor errs"),
    (Cause::Current, "current", "a drive does not give the commanded current"),
    (Cause::WristRate, "wrist_rate", "a joint of the wrist runs away"),
]);

#[cfg(test)]
mod tests {
    use super::*;

    /// The outputs `supervisor.state` and `supervisor.cause` are places among the values.
    #[test]
    fn stages_have_the_numbers_of_their_places() {
        for stage in [
            Stage::Off,
            Stage::Watching,
            Stage::Frozen,
            Stage::Lowered,
            Stage::Stopping,
            Stage::Braking,
            Stage::Stopped,
        ] {
            assert_eq!(SUPERVISOR.number(stage), stage as i32 + 1);
        }
        for number in 1..=11 {
            assert_eq!(CAUSE.item(number).expect("a cause") as i32 + 1, number);
        }
    }
}
