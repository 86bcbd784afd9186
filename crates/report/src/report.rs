//! The evaluation as one HTML file that opens without a network: conditions, robustness table,
//! plots and a 3-D animation; and the same figures as PNG and SVG.
//!
//! Everything shown comes out of the FMUs. The one exception is the animation's drawing: the FMU
//! gives joint angles, and the poses of the 13 bodies are made of them with the kinematics of crate
//! `hdrm` and the machine file that the FMU runs with (module `scene`). Every frame is checked
//! against the tip position that the FMU gives, so a drawing of another machine is refused.
//!
//! The page is plain HTML with plotly.js and three.js (both in `assets/`) inside.

mod conditions;
mod efficiency_map;
mod electric;
mod errors;
mod evaluation;
mod failures;
pub mod figures;
mod own_path;
mod page;
mod request;
mod runs;
mod samples;
mod scene;
mod stability;
mod surrogate;
mod table;
mod worlds;

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::Serialize;

use conditions::Conditions;
use efficiency_map::EfficiencyMap;
use errors::{ErrorStudy, Plan};
use evaluation::{Energy, Testbed};
use failures::kept;
pub use request::Request;
use request::UNCERTAIN;
use runs::{Case, Run};
use scene::Scene;
use stability::Stability;
use studies::grid::TRAJECTORIES;
use studies::machine_file::MachineFile;
use studies::studies::efficiency;
use studies::studies::inertia::{self, MODES};
use table::Row;

/// All that the page shows.
#[derive(Serialize)]
pub struct Report {
    conditions: Conditions,
    pub(crate) table: Vec<Row>,
    worlds: Vec<worlds::WorldComparison>,
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
    surrogate: Option<surrogate::RigComparison>,
}

impl Report {
    /// Make all runs, in parallel; `progress` is told how many of how many are done. A run that
    /// fails is named in the report.
    ///
    /// # Errors
    /// No run succeeds, or the machine file cannot be used.
    pub fn new(request: &Request<'_>, progress: impl Fn(u64, u64) + Sync) -> Result<Self> {
        let machine = MachineFile::of(request.system, &request.base.settings)?;
        let scene = Scene::new(&machine)?;
        let plan = Plan::of(request)?;
        let runs = (cases().len() + inertia::CELLS) as u64 + plan.count();
        let total = runs + evaluation::RUNS + studies::studies::stability::RUNS;
        let done = AtomicU64::new(0);
        let count = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        let results: Vec<Result<Run>> = cases()
            .into_par_iter()
            .map(|case| {
                let run = Run::of(request, case, &scene);
                count();
                run
            })
            .collect();
        let mut failures = Vec::new();
        let runs = kept(results, &mut failures);
        if runs.is_empty() {
            bail!("no run succeeded: {}", failures.join("; "));
        }
        let cells = inertia::run(request.system, request.base, count)?;
        failures.extend(cells.iter().filter_map(table::failure));
        let worlds = worlds::shown(request, &mut failures);
        let errors = plan.run(request, count, &mut failures)?;
        let energy = evaluation::energies(request, count, &mut failures);
        let electric = electric::shown(request, &mut failures);
        let path = own_path::shown(request, &machine, &mut failures);
        let stability = stability::stability(request, count, &mut failures)?;
        let testbed = evaluation::testbed(request, &mut failures);
        let surrogate = surrogate::on_rig(request, &mut failures);
        let map = efficiency::map(request.system, request.base).map(EfficiencyMap::from);
        Ok(Self {
            conditions: Conditions::of(request, &machine),
            table: cells.chunks(MODES.len()).map(table::row).collect(),
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

/// The runs that are kept: both trajectories with all controllers, and the adaptive one with wrong
/// inertias.
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

impl Report {
    /// Write the page.
    pub fn write(&self, path: &Path) -> Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        std::fs::write(path, page::html(self)?)
            .with_context(|| format!("`{}` cannot be written", path.display()))
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
