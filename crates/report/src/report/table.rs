//! The robustness table as the page takes it.

use serde::Serialize;
use studies::grid::Cell;
use studies::measures::tip::TipError;
use studies::studies::inertia;

/// A row of the robustness table.
#[derive(Serialize)]
pub struct Row {
    pub trajectory: &'static str,
    pub scale: f64,
    /// The paper's RMSE of its adaptive controller, m.
    pub paper: f64,
    /// In the order of [`inertia::MODES`].
    pub cells: Vec<TableCell>,
}

/// Tip error over the motion, m; nothing where the run failed.
#[derive(Serialize)]
pub struct TableCell {
    pub mode: String,
    pub rmse: Option<f64>,
    pub max: Option<f64>,
}

/// One run of a table.
pub type TipCell = Cell<TipError>;

impl TableCell {
    pub fn of(cell: &TipCell) -> Self {
        let motion = cell.result.as_ref().ok().map(|tip| tip.motion);
        Self {
            mode: cell.law.clone(),
            rmse: motion.map(|d| d.rms()),
            max: motion.map(|d| d.max),
        }
    }
}

/// What is said of a cell that failed, in the `case` of this name.
pub fn failure_in(cell: &TipCell, case: &str) -> Option<String> {
    let error = cell.error()?;
    Some(format!(
        "{}, {}, {case}: {error:#}",
        cell.trajectory, cell.law
    ))
}

/// What is said of a cell of the robustness table that failed.
pub fn failure(cell: &TipCell) -> Option<String> {
    failure_in(cell, &format!("inertia x {}", cell.case))
}

/// A row of cells, one for each controller.
pub fn row(cells: &[TipCell]) -> Row {
    let (trajectory, scale) = (cells[0].trajectory, inertia::scale_of(&cells[0]));
    Row {
        trajectory,
        scale,
        paper: inertia::paper(trajectory, scale).unwrap_or(f64::NAN),
        cells: cells.iter().map(TableCell::of).collect(),
    }
}
