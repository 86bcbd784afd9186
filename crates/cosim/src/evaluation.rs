//! Subcommands of the evaluation: robustness tables.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use cosim::noise::Noise;
use cosim::robustness::{self, STUDIES, Study};
use cosim::run::Experiment;
use cosim::system::System;
use cosim::table;
use serde_json::{Value, json};

use crate::{GridArgs, SystemArgs, bar, create};

#[derive(Args)]
pub struct TableArgs {
    #[command(flatten)]
    system: SystemArgs,
    #[command(flatten)]
    grid: GridArgs,
    /// What is varied, repeatable
    #[arg(long = "study", value_enum, default_values_t = [StudyArg::Inertia])]
    studies: Vec<StudyArg>,
    /// First of the three seeds of the noise study
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Also write the cells of the inertia study to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also write all cells to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum StudyArg {
    /// The paper's table: mass and inertia of all bodies
    Inertia,
    /// Motor and transmission parameters, each and together
    Motor,
    /// Payload alone
    Payload,
    /// Sensor noise
    Noise,
    /// Unknown wrench on the tip
    TipLoad,
    /// All of these
    All,
}

impl TableArgs {
    fn wants(&self, study: StudyArg) -> bool {
        self.studies.contains(&study) || self.studies.contains(&StudyArg::All)
    }

    fn studies(&self) -> Vec<Study> {
        let arg = |study| match study {
            Study::Motor => StudyArg::Motor,
            Study::Payload => StudyArg::Payload,
            Study::Noise => StudyArg::Noise,
            Study::TipLoad => StudyArg::TipLoad,
        };
        STUDIES
            .into_iter()
            .filter(|s| self.wants(arg(*s)))
            .collect()
    }
}

/// Robustness tables; fails when a cell failed, after the others have been printed.
pub fn tables(args: &TableArgs) -> Result<()> {
    let system = args.system.load()?;
    let base = base(&system, &args.grid)?;
    let mut failed = 0;
    let mut found = conditions(&base);
    if args.wants(StudyArg::Inertia) {
        let count = table::TRAJECTORIES.len() * table::SCALES.len() * table::MODES.len();
        let bar = bar(count as u64, "runs");
        let cells = table::run(&system, base.grid, base.stop, &base.settings, || bar.inc(1));
        bar.finish_and_clear();
        println!("{}", table::text(&cells));
        if let Some(path) = &args.csv {
            let mut file = BufWriter::new(create(path)?);
            table::write_csv(&cells, &mut file)
                .and_then(|()| Ok(file.flush()?))
                .with_context(|| path.display().to_string())?;
        }
        failed += cells.iter().filter(|c| c.result.is_err()).count();
        found["inertia"] = cells.iter().map(inertia_json).collect();
    }
    for study in args.studies() {
        let cases = study.cases(&system, args.seed)?;
        let bar = bar(robustness::count(&cases) as u64, "runs");
        let cells = robustness::run(&system, &base, study, &cases, || bar.inc(1));
        bar.finish_and_clear();
        println!("{}", robustness::text(&cells));
        failed += cells.iter().filter(|c| c.result.is_err()).count();
        found[study.name()] = cells.iter().map(cell_json).collect();
    }
    write_json(args.json.as_deref(), &found)?;
    anyhow::ensure!(failed == 0, "{failed} cells failed");
    Ok(())
}

/// The experiment that the cells vary.
fn base(system: &System, grid: &GridArgs) -> Result<Experiment> {
    Ok(Experiment {
        grid: grid.grid(system)?,
        stop: grid.stop_time,
        settings: grid.settings.clone(),
        noise: Noise::default(),
    })
}

/// What the numbers were made under.
fn conditions(base: &Experiment) -> Value {
    let setting =
        |s: &cosim::master::Setting| format!("{}.{}={}", s.component, s.variable, s.value);
    json!({
        "cosim_version": env!("CARGO_PKG_VERSION"),
        "step_s": base.grid.step,
        "schedule": format!("{:?}", base.grid.schedule),
        "settings": base.settings.iter().map(setting).collect::<Vec<_>>(),
    })
}

fn inertia_json(c: &table::Cell) -> Value {
    let mut cell = json!({
        "trajectory": c.trajectory, "mode": c.mode, "inertia_scale": c.scale, "paper_adaptive_rmse_m": c.paper,
    });
    put_result(&mut cell, &c.result);
    cell
}

fn cell_json(c: &robustness::Cell) -> Value {
    let mut cell = json!({
        "trajectory": c.trajectory, "mode": c.mode, "case": c.case, "target_adaptive_rmse_m": c.study.target(),
    });
    put_result(&mut cell, &c.result);
    cell
}

fn put_result(cell: &mut Value, result: &Result<cosim::tip::TipError>) {
    match result {
        Ok(tip) => {
            cell["rmse_m"] = tip.motion.rms().into();
            cell["max_m"] = tip.motion.max.into();
        }
        Err(error) => cell["error"] = format!("{error:#}").into(),
    }
}

fn write_json(path: Option<&Path>, value: &Value) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let mut file: BufWriter<File> = BufWriter::new(create(path)?);
    serde_json::to_writer_pretty(&mut file, value)?;
    writeln!(file)?;
    file.flush().with_context(|| path.display().to_string())
}
