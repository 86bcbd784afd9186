//! Subcommands `machine draw` and `machine scene`.

use std::path::{Path, PathBuf};

use crate::machines::drawing::Sheet;
use crate::machines::load_chart::LoadChart;
use crate::report::scene::Scene;
use anyhow::{Result, ensure};
use clap::Args;
use cosim::cli::print;
use studies::machine_file::read;
use studies::print::files::write;

#[derive(Args)]
pub struct DrawArgs {
    /// Machine file, or name of a shipped machine
    #[arg(value_name = "FILE|NAME")]
    machine: String,
    /// Picture to write: .svg or .png
    #[arg(long, value_name = "FILE", default_value = "machine.svg")]
    output: PathBuf,
    /// Factor on all weights, for what is not at rest
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    dynamic_factor: f64,
    /// Also write the load chart to this CSV file: place, joint angles, payload, limit
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// Draw it.
pub fn draw(args: &DrawArgs) -> Result<()> {
    let kind = args.output.extension().unwrap_or_default();
    ensure!(
        kind == "svg" || kind == "png",
        "--output {} must end in .svg or .png",
        args.output.display()
    );
    let machine = read(&args.machine)?;
    let chart = LoadChart::new(&machine, args.dynamic_factor)?;
    write(args.csv.as_deref(), |file| chart.write_csv(file))?;
    let name = Path::new(&args.machine).file_stem().unwrap_or_default();
    Sheet::new(&name.to_string_lossy(), machine, chart)?.write(&args.output)?;
    print(format_args!("{} written\n", args.output.display()))
}

#[derive(Args)]
pub struct SceneArgs {
    /// Machine file, or name of a shipped machine
    #[arg(value_name = "FILE|NAME", default_value = "reference")]
    machine: String,
    /// JSON file to write
    #[arg(long, value_name = "FILE", default_value = "scene.json")]
    out: PathBuf,
}

/// Write what a page needs to draw it in motion.
pub fn scene(args: &SceneArgs) -> Result<()> {
    let machine = read(&args.machine)?;
    let scene = Scene::new(&machine)?;
    write(Some(&args.out), |file| {
        Ok(serde_json::to_writer(file, &scene.live(&machine))?)
    })?;
    print(format_args!("{} written\n", args.out.display()))
}
