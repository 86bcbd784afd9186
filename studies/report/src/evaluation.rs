//! The evaluation as one HTML file that opens without a network: conditions, robustness table,
//! plots and a 3-D animation; and the same figures as PNG and SVG.
//!
//! Everything shown comes out of the FMUs. The one exception is the animation's drawing: the FMU
//! gives joint angles, and the poses of the 13 bodies are made of them with the kinematics of crate
//! `hdrm` and the machine file that the FMU runs with (module `scene`). Every frame is checked
//! against the tip position that the FMU gives, so a drawing of another machine is refused.
//!
//! Every run is made once: the cells of the paper's table are also those whose signals, energies
//! and rod forces are shown.
//!
//! The page is plain HTML with plotly.js and three.js (both in `assets/`) inside.

mod conditions;
mod electric;
mod errors;
pub mod figures;
mod own_path;
mod page;
mod recorded;
mod request;
mod runs;
mod samples;
pub mod scene;
mod stability;
mod surrogate;
mod testbed;
mod worlds;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use serde_json::{Value, json};

use conditions::conditions;
use experiments::analyses::{efficiency, inertia, robustness};
use experiments::measures::run::TipError;
use experiments::print::tip_errors::inertia_json;
use experiments::runs::grid::{self, Cell};
use experiments::setup::machine_choice::MachineFile;
pub use recorded::Recorded;
pub use request::Request;
use request::kept;
use runs::{Run, Shown};
use samples::Samples;
use scene::Scene;
use stability::Stability;
use testbed::Testbed;

/// All that the page shows.
#[derive(Serialize)]
pub struct Report {
    conditions: Value,
    table: Value,
    /// The table, for figures.
    #[serde(skip)]
    cells: Vec<Cell<TipError>>,
    worlds: Vec<Value>,
    recorded: Recorded,
    errors: Vec<Value>,
    runs: Vec<Run>,
    /// Runs that failed, with the reason.
    failures: Vec<String>,
    energy: Vec<Value>,
    electric: Vec<Value>,
    path: Option<Value>,
    stability: Stability,
    testbed: Option<Testbed>,
    scene: Scene,
    efficiency_map: Option<Value>,
    surrogate: Option<Value>,
}

impl Report {
    /// Make all runs, in parallel; `progress` is told how many of how many are done. A run that
    /// fails is named in the report.
    ///
    /// # Errors
    /// No run of the table succeeds, or the machine file cannot be used.
    pub fn new(request: &Request<'_>, progress: impl Fn(u64, u64) + Sync) -> Result<Self> {
        let (system, base) = (request.system, request.base);
        let machine = MachineFile::from_manipulator(system, &base.settings)?;
        let scene = Scene::new(&machine.machine)?;
        let plan = errors::plan(request)?;
        let of_errors: u64 = plan.iter().map(|(_, cases)| robustness::count(cases)).sum();
        let total = inertia::CELLS as u64 + of_errors + experiments::analyses::stability::RUNS;
        let done = AtomicU64::new(0);
        let count = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        let measure = |plan: &grid::Plan| runs::measure(request, &scene, plan);
        let cells = inertia::measured(system, base, measure, count)?;
        let Shown {
            cells,
            runs,
            energies,
            machines,
        } = Shown::of(cells);
        let failure = |cell: &Cell<_>| errors::failure(cell, &format!("inertia x {}", cell.case));
        let mut failures: Vec<_> = cells.iter().filter_map(failure).collect();
        if failures.len() == cells.len() {
            bail!("no run succeeded: {}", failures.join("; "));
        }
        let worlds = worlds::shown(request, &mut failures);
        let errors = plan
            .iter()
            .map(|study| errors::shown(request, study, count, &mut failures));
        let errors = errors.collect::<Result<_>>()?;
        let energy = kept(energies, &mut failures);
        let electric = electric::shown(request, &mut failures);
        let path = own_path::shown(request, &machine, &mut failures);
        let stability = stability::stability(request, count, &mut failures)?;
        let testbed = testbed::replayed(request, machines, &mut failures);
        let surrogate = surrogate::on_rig(request, &mut failures);
        let map = efficiency::map(system, base).map(surfaces);
        Ok(Self {
            conditions: conditions(request, &machine),
            table: inertia_json(&cells),
            cells,
            worlds,
            recorded: request.recorded.clone(),
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
        let runs = self.runs.iter().map(|run| run.line() + "\n");
        let failures = self.failures.iter().map(|why| format!("failed: {why}\n"));
        runs.chain(failures).collect()
    }
}

/// The actuator's efficiency over load, N, and rod speed, m/s, both ascending: row by row of load,
/// NaN where it is not defined.
fn surfaces(map: efficiency::Map) -> Value {
    let surface = |k: usize| {
        let points = map.points.iter();
        Samples::new(points.map(|point| point.map_or(f64::NAN, |values| values[k])))
    };
    json!({
        "actuator": map.actuator,
        "loads": map.loads,
        "speeds": map.speeds,
        "physics": surface(0),
        "network": surface(1),
        "hybrid": surface(2),
    })
}
