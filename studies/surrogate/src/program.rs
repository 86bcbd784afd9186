//! The program's commands and the pictures that they draw.

pub mod commands;
mod files;
mod plots;
mod rig_commands;
