//! The heavy-duty manipulator: geometry, closed loops, kinematics and dynamics.
//!
//! Minimal coordinates are `zeta[0..6]`: slew about +y, lift about +z, tilt about +z relative to
//! the lift boom, wrist about x, z, x. World frame: x forward, y up, z = x × y. Both closed loops
//! (lift triangle, tilt four-bar) are solved analytically, so all 13 bodies form a tree whose
//! joints turn as functions of one `zeta` each ([`Tree`]). Bodies are rigid, joints without play.
//!
//! Source: the paper's section on the manipulator; where a formula departs from the paper, its
//! doc comment says so.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // frames and symbols as in the paper

mod assembly;
mod base;
mod body;
mod boom_frame;
mod contact;
mod contact_force;
mod continuous;
mod dry_friction;
mod dynamics;
mod end_stop;
mod error;
mod factor;
mod gravity;
mod input;
mod lift;
mod load;
mod options;
mod output;
mod planar;
mod planar_body;
mod plant;
mod recursion;
mod reload;
mod saturate;
mod sensitivity;
mod state;
mod step;
mod tilt;
mod tip;
mod tree;
mod turning;
mod wrist_drive;

pub use body::{BODIES, Body};
pub use contact::Contact;
pub use continuous::INDICATORS;
pub use dry_friction::DryFriction;
pub use end_stop::EndStop;
pub use error::HdrmError;
pub use gravity::felt_gravity;
pub use input::Input;
pub use lift::Lift;
pub use load::Load;
pub use options::Options;
pub use output::Output;
pub use planar::Polar;
pub use plant::{Dynamics, Hdrm};
pub use saturate::saturate;
pub use state::State;
pub use step::StepError;
pub use tilt::{FourBar, Tilt};
pub use tip::Tip;
pub use tree::{Configuration, GeometryError, Link, Stroke, Tree};
pub use wrist_drive::{Slips, WristDrive, WristState};

/// The six joint coordinates, rad.
pub const DOF: usize = 6;
