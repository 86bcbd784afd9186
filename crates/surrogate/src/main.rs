//! `surrogate`: virtual testbed, training, quality of the actuator's surrogate network.
#![forbid(unsafe_code)]

mod commands;

use anyhow::Result;
use clap::Parser;

fn main() -> Result<()> {
    commands::Command::parse().run()
}
