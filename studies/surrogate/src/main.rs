//! The program `hdrm-fmu-surrogate`: makes data on the rig, trains the actuator's surrogate
//! network, and judges it. `hdrm-fmu train` and `hdrm-fmu surrogate` start it.
#![forbid(unsafe_code)]
#![allow(rustdoc::broken_intra_doc_links)] // help texts have units in brackets
#![allow(non_snake_case)] // the paper's symbols

mod program;

use anyhow::Result;
use clap::Parser;
use program::commands::Command;

fn main() -> Result<()> {
    Command::parse().run()
}
