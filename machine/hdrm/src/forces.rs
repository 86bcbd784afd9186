//! Force laws of the plant: contact with a plane, end stops, joint friction, wrist drives and brakes.

pub(crate) mod contact;
pub(crate) mod contact_force;
pub(crate) mod dry_friction;
pub(crate) mod end_stop;
pub(crate) mod saturate;
pub(crate) mod wrist_brake;
pub(crate) mod wrist_drive;
