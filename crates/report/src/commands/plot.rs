//! Subcommand `plot`.

use std::path::Path;

use anyhow::Result;
use cosim::cli::print;
use studies::commands::pictures::PlotArgs;

/// Draw a file.
pub fn plot(args: &PlotArgs) -> Result<()> {
    let folder = args.out.as_deref().or(args.csv.parent());
    let folder = folder.unwrap_or(Path::new("."));
    for file in crate::plot::draw(&args.csv, &args.signals, folder)? {
        print(format_args!("{}\n", file.display()))?;
    }
    Ok(())
}
