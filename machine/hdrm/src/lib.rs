//! Model of the heavy-duty manipulator (HDRM): rigid-body kinematics and dynamics with both closed
//! loops, end stops, friction, contact, load and a moving base. The FMU `Hdrm` wraps it; the
//! controller, `motion-check` and studies use its kinematics, the last two its dynamics too.
//!
//! Minimal coordinates are `zeta[0..6]`: slew about +y, lift about +z, tilt about +z relative to
//! the lift boom, wrist about x, z, x. World frame: x forward, y up, z = x × y. Both closed loops
//! (lift triangle, tilt four-bar) are solved analytically, so all 13 bodies form a tree in which
//! each joint depends on one `zeta` ([`Tree`]). Bodies are rigid, joints have no backlash.
//!
//! Source: the paper's section on the manipulator; doc comments name departures from it.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // frames and symbols as in the paper

mod dynamics;
mod forces;
mod geometry;
mod load;
mod plant;

pub use dynamics::gravity::felt_gravity;
pub use forces::contact::Contact;
pub use forces::dry_friction::DryFriction;
pub use forces::end_stop::EndStop;
pub use forces::saturate::saturate;
pub use forces::wrist_brake::WristBrake;
pub use forces::wrist_drive::{Slips, WristDrive, WristState};
pub use geometry::body::{BODIES, Body};
pub use geometry::lift::Lift;
pub use geometry::planar::Polar;
pub use geometry::tilt::{FourBar, Tilt};
pub use geometry::tip::Tip;
pub use geometry::tree::{Configuration, GeometryError, Link, Stroke, Tree};
pub use load::Load;
pub use plant::continuous::INDICATORS;
pub use plant::error::HdrmError;
pub use plant::input::Input;
pub use plant::options::Options;
pub use plant::output::Output;
pub use plant::state::State;
pub use plant::step::StepError;
pub use plant::{Dynamics, Hdrm};

/// The six joint coordinates, rad.
pub const DOF: usize = 6;
