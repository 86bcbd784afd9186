//! The program's commands, which `main` runs, and the pictures that they draw.

pub mod commands;
mod files;
mod plots;
mod rig_commands;
