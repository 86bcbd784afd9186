//! The report: one HTML file that opens without a network, with conditions, robustness table, plots
//! and a 3-D animation, and the same figures as PNG and SVG. The command `report` calls
//! [`Report::new`], which makes the runs, and [`Report::write`], which writes the page.
//!
//! Each run of a system is a run of FMUs. The animation is drawn by this crate: FMUs give the joint
//! angles, and the page computes the poses of the 13 bodies from them, as the live page does. The
//! tip at these angles is checked against the position that the FMU gives, so a drawing of another
//! machine is refused (module `scene`).
//!
//! Each run is made once: the runs of the paper's table also give the signals, energies and rod
//! forces that are plotted. The page is plain HTML with plotly.js and three.js (both in `assets/`)
//! inside.

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
use cosim::run::interrupt;
use experiments::analyses::{efficiency, inertia, robustness};
use experiments::measures::run::TipError;
use experiments::print::tip_errors::inertia_json;
use experiments::runs::grid::{self, Cell};
use experiments::setup::machine_choice::MachineFile;
pub use recorded::RecordedStudies;
pub use request::Request;
use request::{success, successes};
use runs::{Run, TableRuns};
use samples::Samples;
use scene::Scene;
use stability::Stability;
use testbed::Testbed;

/// All that the page shows.
#[derive(Serialize)]
pub struct Report {
    conditions: Value,
    /// The paper's table, as the page reads it.
    table: Value,
    /// The same, as the figures read it.
    #[serde(skip)]
    cells: Vec<Cell<TipError>>,
    worlds: Vec<Value>,
    recorded: RecordedStudies,
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
    /// Makes all runs, in parallel; calls `progress` with the number of finished runs and of all.
    /// A run that fails is named in the report. An error if no run of the table succeeds, or the
    /// machine file cannot be used.
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
        let table = TableRuns::from_cells(cells);
        let failure = |cell: &Cell<_>| errors::failure(cell, &format!("inertia x {}", cell.case));
        let mut failures: Vec<_> = table.cells.iter().filter_map(failure).collect();
        if failures.len() == table.cells.len() {
            bail!("no run succeeded: {}", failures.join("; "));
        }
        let worlds = worlds::results(request, &mut failures);
        let errors = plan
            .iter()
            .map(|study| errors::results(request, study, count, &mut failures));
        let errors = errors.collect::<Result<_>>()?;
        let energy = successes(table.energies, &mut failures);
        let electric = electric::results(request, &mut failures);
        let path = own_path::results(request, &machine, &mut failures);
        let stability = stability::results(request, count, &mut failures)?;
        let testbed = testbed::results(request, table.machine_runs, &mut failures);
        let surrogate = surrogate::results(request, &mut failures);
        let map = efficiency::map(system, base).map(surfaces);
        Ok(Self {
            conditions: conditions(request, &machine),
            table: inertia_json(&table.cells),
            cells: table.cells,
            worlds,
            recorded: request.recorded.clone(),
            errors,
            runs: table.runs,
            energy,
            electric,
            path,
            stability,
            testbed,
            surrogate,
            scene,
            efficiency_map: success(map, &mut failures),
            failures,
        })
    }

    pub fn write(&self, path: &Path) -> Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        interrupt::check()?;
        Ok(output_file::write(path, page::html(self)?)?)
    }

    /// One line for each run and each failure.
    pub fn summary(&self) -> String {
        let runs = self.runs.iter().map(|run| run.line() + "\n");
        let failures = self.failures.iter().map(|why| format!("failed: {why}\n"));
        runs.chain(failures).collect()
    }
}

/// The actuator's efficiency over load, N, and rod speed, m/s, both ascending: one row per load,
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
