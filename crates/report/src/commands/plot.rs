//! Subcommand `plot`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use cosim::cli::print;

#[derive(Args)]
pub struct PlotArgs {
    /// CSV file of `run --csv`
    csv: PathBuf,
    /// Signals, comma-separated, with * for any text [default: all in the file]
    #[arg(long, value_delimiter = ',', value_name = "PATTERNS")]
    signals: Vec<String>,
    /// Folder for the picture [default: that of the file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Draw a file.
pub fn plot(args: &PlotArgs) -> Result<()> {
    let folder = args.out.as_deref().or(args.csv.parent());
    let folder = folder.unwrap_or(Path::new("."));
    for file in crate::plot::draw(&args.csv, &args.signals, folder)? {
        print(format_args!("{}\n", file.display()))?;
    }
    Ok(())
}
