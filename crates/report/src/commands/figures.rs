//! Figures of `sizing` and `path check`.

use std::path::PathBuf;

use crate::{margins_figure, sizing_figure};
use anyhow::Result;
use cosim::Verdict;
use cosim::cli::print;
use studies::commands::path::{self, CheckArgs};
use studies::commands::sizing::{self, SizingArgs};

/// Motors and actuators beside what they do, and torque over speed of each.
pub fn sizing(args: &SizingArgs) -> Result<Verdict> {
    let (verdict, found) = sizing::sizing(args)?;
    if let Some(folder) = &args.figures {
        for (case, sizing) in &found {
            written(sizing_figure::draw(sizing, case, folder)?)?;
        }
    }
    Ok(verdict)
}

/// Whether the machine can do a path, and its margins on the way.
pub fn path(args: &CheckArgs) -> Result<()> {
    let margins = path::check(args)?;
    if let Some(folder) = &args.figures {
        written(margins_figure::draw(&margins, folder)?)?;
    }
    path::verdict(&margins)
}

fn written(files: [PathBuf; 2]) -> Result<()> {
    for file in files {
        print(format_args!("figure written to {}\n", file.display()))?;
    }
    Ok(())
}
