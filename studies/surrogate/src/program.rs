//! Commands and the pictures that they draw.

pub mod commands;
mod files;
mod plots;
mod rig_commands;
mod rig_plots;
