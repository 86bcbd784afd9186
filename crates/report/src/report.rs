//! The evaluation as one HTML file that opens without a network: conditions, robustness table, plots and a 3-D animation; and the same
//! figures as PNG and SVG.
//!
//! Everything shown comes out of the FMUs. The one exception is the animation's drawing: the FMU gives joint angles, and the poses of the
//! 13 bodies are made of them with the kinematics of crate `hdrm` and the machine file that the FMU runs with (module `scene`). Every frame is
//! checked against the tip position that the FMU gives, so a drawing of another machine is refused.
//!
//! The page is plain HTML with plotly.js (out of the crate `plotly`) and three.js (in `assets/`) inside.

mod conditions;
mod electric;
mod errors;
mod evaluation;
mod figures;
mod map;
mod own_path;
mod page;
mod runs;
mod samples;
mod scene;
mod stability;
mod surrogate;
mod worlds;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result, bail};
use cosim::run::Experiment;
use cosim::system::System;
use rayon::prelude::*;
use serde::Serialize;

use conditions::Conditions;
use errors::{ErrorStudy, Plan};
use evaluation::{Energy, Testbed, kept};
use map::EfficiencyMap;
use runs::{Case, Run};
use scene::Scene;
use stability::Stability;
use studies::grid::{Cell, TRAJECTORIES};
use studies::machine_file::MachineFile;
use studies::measures::tip::TipError;
use studies::studies::efficiency;
use studies::studies::inertia::{self, MODES};

/// Inertia error with which the adaptation is shown besides nominal inertias.
const UNCERTAIN: f64 = 1.4;

/// What is to be reported on.
pub struct Request<'a> {
    /// The machine.
    pub system: &'a System,
    /// What all runs have in common.
    pub base: &'a Experiment,
    /// The one-axis experiment, where there is one.
    pub testbed: Option<&'a System>,
    /// The machine of the real world, where there is one.
    pub real: Option<&'a System>,
    /// The machine that bends, where it is to be run.
    pub bending: Option<&'a System>,
    /// The machine fed by a battery, where there is one.
    pub electric: Option<&'a System>,
    /// A path of the reader's own by its name, and the experiment that follows it.
    pub path: Option<(String, Experiment)>,
}

/// All that the page shows.
#[derive(Serialize)]
pub struct Report {
    conditions: Conditions,
    table: Vec<Row>,
    worlds: Vec<worlds::Shown>,
    errors: Vec<ErrorStudy>,
    runs: Vec<Run>,
    /// Runs that failed, with the reason.
    failures: Vec<String>,
    energy: Vec<Energy>,
    electric: Vec<electric::Electric>,
    path: Option<own_path::OwnPath>,
    stability: Stability,
    testbed: Option<Testbed>,
    scene: Scene,
    efficiency_map: Option<EfficiencyMap>,
    surrogate: Option<surrogate::OnRig>,
}

/// A row of the robustness table.
#[derive(Serialize)]
struct Row {
    trajectory: &'static str,
    scale: f64,
    /// The paper's RMSE of its adaptive controller, m.
    paper: f64,
    /// In the order of [`MODES`].
    cells: Vec<TableCell>,
}

/// Tip error over the motion, m; nothing where the run failed.
#[derive(Serialize)]
struct TableCell {
    mode: String,
    rmse: Option<f64>,
    max: Option<f64>,
}

/// One run of a table.
type TipCell = Cell<TipError>;

impl TableCell {
    fn of(cell: &TipCell) -> Self {
        let motion = cell.result.as_ref().ok().map(|tip| tip.motion);
        Self {
            mode: cell.law.clone(),
            rmse: motion.map(|d| d.rms()),
            max: motion.map(|d| d.max),
        }
    }
}

impl Request<'_> {
    /// Make all runs, in parallel; `progress` is told how many of how many are done. A run that fails is named in the report.
    ///
    /// # Errors
    /// No run succeeds, or the machine file cannot be used.
    pub fn make(&self, progress: impl Fn(u64, u64) + Sync) -> Result<Report> {
        let machine = MachineFile::of(self.system, &self.base.settings)?;
        let scene = Scene::new(&machine)?;
        let plan = Plan::of(self)?;
        let runs = (cases().len() + inertia::CELLS) as u64 + plan.count();
        let total = runs + evaluation::RUNS + studies::studies::stability::RUNS;
        let done = AtomicU64::new(0);
        let count = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        let results: Vec<Result<Run>> = cases()
            .into_par_iter()
            .map(|case| {
                let run = Run::of(self, case, &scene);
                count();
                run
            })
            .collect();
        let mut failures = Vec::new();
        let runs = kept(results, &mut failures);
        if runs.is_empty() {
            bail!("no run succeeded: {}", failures.join("; "));
        }
        let cells = inertia::run(self.system, self.base, count)?;
        let named = |cell: &TipCell| failure(cell, &format!("inertia x {}", cell.case));
        failures.extend(cells.iter().filter_map(named));
        let worlds = worlds::shown(self, &mut failures);
        let errors = plan.run(self, count, &mut failures)?;
        let energy = evaluation::energies(self, count, &mut failures);
        let electric = electric::shown(self, &mut failures);
        let path = own_path::shown(self, &machine, &mut failures);
        let stability = stability::stability(self, count, &mut failures)?;
        let testbed = evaluation::testbed(self, &mut failures);
        let surrogate = surrogate::on_rig(self, &mut failures);
        let map = efficiency::map(self.system, self.base).map(EfficiencyMap::from);
        Ok(Report {
            conditions: Conditions::of(self, &machine),
            table: cells.chunks(MODES.len()).map(row).collect(),
            worlds,
            errors,
            runs,
            energy,
            electric,
            path,
            stability,
            testbed,
            surrogate,
            scene,
            efficiency_map: kept(vec![map], &mut failures).pop(),
            failures,
        })
    }
}

/// The runs that are kept: both trajectories with all controllers, and the adaptive one with wrong inertias.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for trajectory in TRAJECTORIES {
        cases.extend(MODES.map(|mode| Case {
            trajectory,
            mode,
            scale: 1.0,
        }));
        cases.push(Case {
            trajectory,
            mode: MODES[0],
            scale: UNCERTAIN,
        });
    }
    cases
}

/// A cell that failed, in the `case` of this name.
fn failure(cell: &TipCell, case: &str) -> Option<String> {
    let error = cell.error()?;
    Some(format!(
        "{}, {}, {case}: {error:#}",
        cell.trajectory, cell.law
    ))
}

fn row(cells: &[TipCell]) -> Row {
    let (trajectory, scale) = (cells[0].trajectory, inertia::scale_of(&cells[0]));
    Row {
        trajectory,
        scale,
        paper: inertia::paper(trajectory, scale).unwrap_or(f64::NAN),
        cells: cells.iter().map(TableCell::of).collect(),
    }
}

impl Report {
    /// Write the page.
    pub fn write(&self, path: &Path) -> Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        std::fs::write(path, page::html(self)?)
            .with_context(|| format!("`{}` cannot be written", path.display()))
    }

    /// Write the figures as PNG and SVG into `folder`; their names.
    pub fn write_figures(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        figures::write(self, folder)
    }

    /// A line for each run and each failure.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        for run in &self.runs {
            writeln!(text, "{}", run.line()).expect("a String takes every text");
        }
        for failure in &self.failures {
            writeln!(text, "failed: {failure}").expect("a String takes every text");
        }
        text
    }
}
