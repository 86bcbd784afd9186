//! Paths as their users see them. One program, so that it is linked once.

mod motion;
mod refused;
