//! The robustness table as the page takes it.

use anyhow::Result;
use serde::Serialize;
use studies::table;
use studies::tip::TipError;

/// A row of the robustness table.
#[derive(Serialize)]
pub struct Row {
    pub trajectory: &'static str,
    pub scale: f64,
    /// The paper's RMSE of its adaptive controller, m.
    pub paper: f64,
    /// In the order of [`MODES`].
    pub cells: Vec<TableCell>,
}

/// Tip error over the motion, m; nothing where the run failed.
#[derive(Serialize)]
pub struct TableCell {
    pub mode: &'static str,
    pub rmse: Option<f64>,
    pub max: Option<f64>,
}

impl TableCell {
    pub fn of(mode: &'static str, result: &Result<TipError>) -> Self {
        let motion = result.as_ref().ok().map(|tip| tip.motion);
        Self {
            mode,
            rmse: motion.map(|d| d.rms()),
            max: motion.map(|d| d.max),
        }
    }
}

/// What is said of a cell that failed.
pub fn failure(cell: &table::Cell) -> Option<String> {
    let error = cell.result.as_ref().err()?;
    let table::Cell {
        trajectory,
        mode,
        scale,
        ..
    } = cell;
    Some(format!(
        "{trajectory}, {mode}, inertia x {scale}: {error:#}"
    ))
}

/// A row of cells, one for each controller.
pub fn row(cells: &[table::Cell]) -> Row {
    Row {
        trajectory: cells[0].trajectory,
        scale: cells[0].scale,
        paper: cells[0].paper,
        cells: cells
            .iter()
            .map(|c| TableCell::of(c.mode, &c.result))
            .collect(),
    }
}
