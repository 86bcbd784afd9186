//! The commands `machine draw`, `machine scene` and `plot`, and `sizing` and `path check` with
//! their figures; `main` calls them.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use cosim::Verdict;
use cosim::cli::print;
use experiments::commands::path::{self, CheckArgs};
use experiments::commands::pictures::{DrawArgs, PlotArgs, SceneArgs};
use experiments::commands::sizing::{self, SizingArgs};
use experiments::print::output::write;
use experiments::setup::machine_choice::read;
use machine_sheet::{LoadChart, Sheet};

use crate::evaluation::scene::Scene;
use crate::{margins_figure, plot, sizing_figure};

/// Draws a machine on a sheet, and writes its load chart as CSV.
pub fn machine(args: &DrawArgs) -> Result<()> {
    let kind = args.output.extension().unwrap_or_default();
    ensure!(
        kind == "svg" || kind == "png",
        "--output {} must end in .svg or .png",
        args.output.display()
    );
    let machine = read(&args.machine)?;
    let chart = LoadChart::new(&machine, args.dynamic_factor)?;
    write(args.csv.as_deref(), |file| chart.write_csv(file))?;
    Sheet::new(stem(&args.machine), machine, chart)?.write(&args.output)?;
    print(format_args!("{} written\n", args.output.display()))
}

/// Writes what the live page needs to draw and run a machine, or a live page with it.
pub fn scene(args: &SceneArgs) -> Result<()> {
    let machine = read(&args.machine)?;
    let scene = Scene::new(&machine)?;
    let mut text = serde_json::to_string(&scene.to_live(stem(&args.machine), &machine)?)?;
    if let Some(page) = &args.page {
        output_file::note_read(page)?;
        let name = || page.display().to_string();
        text = page_files::with_data(
            &fs::read_to_string(page).with_context(name)?,
            "scene",
            &text,
        )
        .with_context(|| format!("{} is no page of the live machine", name()))?;
    }
    write(Some(&args.out), |file| file.write_all(text.as_bytes()))?;
    print(format_args!("{} written\n", args.out.display()))
}

/// What a machine file is called, without folder and ending.
fn stem(machine: &str) -> &str {
    let stem = Path::new(machine)
        .file_stem()
        .and_then(|stem| stem.to_str());
    stem.unwrap_or(machine)
}

/// Draws the signals of a CSV file over time.
pub fn signals(args: &PlotArgs) -> Result<()> {
    let folder = args.out.as_deref().or(args.csv.parent());
    let folder = folder.unwrap_or(Path::new("."));
    for file in plot::draw(&args.csv, &args.signals, folder)? {
        print(format_args!("{}\n", file.display()))?;
    }
    Ok(())
}

/// Compares motors and actuators with what a motion takes, and draws torque over speed of each.
pub fn sizing(args: &SizingArgs) -> Result<Verdict> {
    let (verdict, sizings) = sizing::sizing(args)?;
    if let Some(folder) = &args.figures {
        for (case, sizing) in &sizings {
            print_figures(sizing_figure::draw(sizing, case, folder)?)?;
        }
    }
    Ok(verdict)
}

/// Checks whether the machine can follow a path, and draws its margins along it.
pub fn path(args: &CheckArgs) -> Result<()> {
    let margins = path::check(args)?;
    if let Some(folder) = &args.figures {
        print_figures(margins_figure::draw(&margins, folder)?)?;
    }
    path::verdict(&margins)
}

fn print_figures(files: [PathBuf; 2]) -> Result<()> {
    for file in files {
        print(format_args!("figure written to {}\n", file.display()))?;
    }
    Ok(())
}
