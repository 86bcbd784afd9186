//! The machine's inertias and joint friction from one run that excites them: what somebody does
//! once who commissions a controller that needs a good model.
//!
//! [`excitation`] is the motion, [`model`] the forces as a linear function of the parameters,
//! [`estimate`] the least squares, [`run`] the run of a machine with its sensors and what is kept of
//! it. All of them know the nominal machine alone, as the controller does.

pub mod estimate;
pub mod excitation;
pub mod model;
pub mod run;
