//! Reads path files for the manipulator's tip and plans the motion along them. The controller
//! follows the result as its reference; studies and Python package read and check paths, too.
//!
//! A [`PathFile`] has waypoints or samples, read from JSON or CSV, or is a built-in test path. With
//! the start pose of the tip it becomes a [`TipPath`]: position, orientation, their rates and the
//! load as functions of time, twice continuously differentiable and at rest at both ends. [`check`]
//! tests before the start whether a machine can follow it.
//!
//! World frame: x forward, y up, z = x × y; m, s, kg; quaternions w, x, y, z. Time counts from the
//! start of the path.
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
pub use path::{Laps, TipPath};
pub use profile::Profile;
pub use reading::{BUILT_IN, SIX_JOINTS, TRIANGLE};
