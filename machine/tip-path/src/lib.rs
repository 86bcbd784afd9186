//! Paths of the manipulator's tip, as an operator gives them.
//!
//! A [`PathFile`] holds waypoints or samples, as JSON or CSV, or is one of the test paths of ISO
//! 9283. With the pose in which the tip starts it becomes a [`TipPath`]: position, orientation,
//! their rates and the load as functions of time, each twice continuously differentiable and at
//! rest at both ends. [`check`] compares what the path demands with what a machine can do, before
//! anything moves.
//!
//! World frame: x forward, y up, z = x × y; m, s, kg; quaternions w, x, y, z. Time counts from the
//! path's beginning.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // rotation matrices

mod check;
mod csv_file;
mod error;
mod file;
mod iso9283;
mod json_file;
mod legs;
mod path;
mod profile;
mod quaternion;
mod reading;
mod spline;

pub use check::{Finding, PathCheck, check};
pub use error::{PathError, Place};
pub use file::{Load, MotionLimits, PathFile, Points, Sample, Waypoint};
pub use iso9283::{Iso9283, TestKind};
pub use legs::Stop;
pub use path::TipPath;
pub use profile::Profile;
pub use reading::{BUILT_IN, SIX_JOINTS};
