//! `surrogate`: data of the rig, training, quality of the actuator's surrogate network.
#![forbid(unsafe_code)]

use anyhow::Result;
use clap::Parser;
use surrogate::program::commands::Command;

fn main() -> Result<()> {
    Command::parse().run()
}
