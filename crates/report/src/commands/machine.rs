//! Subcommands `machine draw` and `machine scene`.

use std::path::Path;

use crate::machines::drawing::Sheet;
use crate::machines::load_chart::LoadChart;
use crate::report::scene::Scene;
use anyhow::{Result, ensure};
use cosim::cli::print;
use studies::commands::pictures::{DrawArgs, SceneArgs};
use studies::machine_file::read;
use studies::print::output::write;

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

/// Write what a page needs to draw it in motion.
pub fn scene(args: &SceneArgs) -> Result<()> {
    let machine = read(&args.machine)?;
    let scene = Scene::new(&machine)?;
    write(Some(&args.out), |file| {
        Ok(serde_json::to_writer(file, &scene.live(&machine))?)
    })?;
    print(format_args!("{} written\n", args.out.display()))
}
