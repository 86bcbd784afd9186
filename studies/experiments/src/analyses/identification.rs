//! Identifies a machine's inertias and joint friction from one run that excites them, as is done to
//! commission a controller that needs a good model; for the subcommand `tournament`.
//!
//! [`excitation`] is the motion, [`model`] the forces as a linear function of the parameters,
//! [`estimate`] the least squares, [`run`] the run of a machine with its sensors. All of them know
//! only the nominal machine, as the controller does.

pub mod estimate;
pub mod excitation;
pub mod model;
pub mod run;
