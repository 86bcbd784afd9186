//! `surrogate`: data of the rig, training, quality of the actuator's surrogate network.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod program;

use anyhow::Result;
use clap::Parser;
use program::commands::Command;

fn main() -> Result<()> {
    Command::parse().run()
}
