//! What is made of machine files: other sizes, lasting torques.

pub mod lasting;
pub mod scaling;
