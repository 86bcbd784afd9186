//! Arguments of the subcommands that draw: `report`, `plot`, `machine draw` and `machine scene`.
//! `hdrm-fmu` reads them too, but the program `hdrm-fmu-report` executes these subcommands.

use std::path::PathBuf;

use clap::Args;
use cosim::cli::output;

use crate::setup::run_setup::MachineArgs;

#[derive(Args)]
pub struct ReportArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// HTML file to write
    #[arg(long, default_value = "report.html", value_name = "FILE")]
    pub out: PathBuf,
    /// Also write the figures as PNG and SVG into this directory
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// One-axis experiment: a packed .ssp [default: Testbed.ssp beside the system, if it exists]
    #[arg(long, value_name = "FILE")]
    pub testbed: Option<PathBuf>,
    /// Also run the world in which the structure bends: needs a Python with MuJoCo and some minutes
    #[arg(long)]
    pub bending: bool,
    /// JSON file of `tournament`, to show its comparison
    #[arg(long, value_name = "FILE")]
    pub tournament: Option<PathBuf>,
    /// JSON file of `margins`, to show the margins of the laws
    #[arg(long, value_name = "FILE")]
    pub margins: Option<PathBuf>,
}

#[derive(Args)]
pub struct PlotArgs {
    /// CSV file of `run --csv`
    pub csv: PathBuf,
    /// Signals, comma-separated, with * for any text [default: all in the file]
    #[arg(long, value_delimiter = ',', value_name = "PATTERNS")]
    pub signals: Vec<String>,
    /// Folder for the picture [default: that of the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Args)]
pub struct DrawArgs {
    /// Machine file, or name of a shipped machine
    #[arg(value_name = "FILE|NAME")]
    pub machine: String,
    /// Picture to write: .svg or .png
    #[arg(long, value_name = "FILE", default_value = "machine.svg", value_parser = output())]
    pub output: PathBuf,
    /// Factor on all weights, to allow for dynamic loads
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub dynamic_factor: f64,
    /// Also write the load chart to this CSV file: place, joint angles, payload, limit
    #[arg(long, value_name = "FILE", value_parser = output())]
    pub csv: Option<PathBuf>,
}

#[derive(Args)]
pub struct SceneArgs {
    /// Machine file, or name of a shipped machine
    #[arg(value_name = "FILE|NAME", default_value = "reference")]
    pub machine: String,
    /// JSON file to write
    #[arg(long, value_name = "FILE", default_value = "scene.json", value_parser = output())]
    pub out: PathBuf,
    /// Live page (`machine.html`) to copy with this machine in it: --out is that page then
    #[arg(long, value_name = "FILE")]
    pub page: Option<PathBuf>,
}
