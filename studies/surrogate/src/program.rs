//! The program `hdrm-fmu-surrogate`: its commands and the pictures that they draw.

pub mod commands;
mod files;
mod plots;
mod rig_commands;
mod rig_plots;
