//! The robustness studies besides the paper's: what is varied, a table, and where the worst case is.

use anyhow::Result;
use serde::Serialize;

use super::request::Request;
use super::table::TableCell;
use studies::robustness::{self, Case, Cell, STUDIES, Study};
use studies::table::MODES;

/// First of the three seeds of the noise study.
const SEED: u64 = 1;

/// One study.
#[derive(Serialize)]
pub struct ErrorStudy {
    study: Study,
    /// What is varied, as a sentence.
    varied: String,
    /// RMSE that the adaptive controller should stay below, m, where one is set.
    target: Option<f64>,
    rows: Vec<Row>,
    /// Of the adaptive controller.
    worst: Option<Worst>,
}

/// A case on one trajectory.
#[derive(Serialize)]
struct Row {
    trajectory: &'static str,
    case: String,
    /// In the order of [`MODES`].
    cells: Vec<TableCell>,
}

/// Where the adaptive controller's RMSE is largest.
#[derive(Serialize)]
struct Worst {
    trajectory: &'static str,
    case: String,
    rmse: f64,
    max: f64,
}

/// All studies with their cases.
pub struct Plan(Vec<(Study, Vec<Case>)>);

impl Plan {
    pub fn of(request: &Request<'_>) -> Result<Self> {
        let one = |study: Study| Ok((study, study.cases(request.system, request.base, SEED)?));
        Ok(Self(STUDIES.into_iter().map(one).collect::<Result<_>>()?))
    }

    /// Number of runs it takes.
    pub fn count(&self) -> usize {
        self.0
            .iter()
            .map(|(_, cases)| robustness::count(cases))
            .sum()
    }

    /// Make the runs; a failed one leaves an empty cell and its reason in `failures`.
    pub fn run(
        &self,
        request: &Request<'_>,
        done: impl Fn() + Sync,
        failures: &mut Vec<String>,
    ) -> Result<Vec<ErrorStudy>> {
        let one = |(study, cases): &(Study, Vec<Case>)| {
            let cells = robustness::run(request.system, request.base, *study, cases, &done)?;
            failures.extend(cells.iter().filter_map(failure));
            Ok(ErrorStudy::of(*study, &cells))
        };
        self.0.iter().map(one).collect()
    }
}

fn failure(cell: &Cell) -> Option<String> {
    let error = cell.result.as_ref().err()?;
    let Cell {
        trajectory,
        mode,
        case,
        ..
    } = cell;
    Some(format!("{trajectory}, {mode}, {case}: {error:#}"))
}

impl ErrorStudy {
    fn of(study: Study, cells: &[Cell]) -> Self {
        let row = |cells: &[Cell]| Row {
            trajectory: cells[0].trajectory,
            case: cells[0].case.clone(),
            cells: cells
                .iter()
                .map(|c| TableCell::of(c.mode, &c.result))
                .collect(),
        };
        let worst = robustness::worst(cells).map(|(cell, tip)| Worst {
            trajectory: cell.trajectory,
            case: cell.case.clone(),
            rmse: tip.motion.rms(),
            max: tip.motion.max,
        });
        Self {
            study,
            varied: study.varied(),
            target: study.target(),
            rows: cells.chunks(MODES.len()).map(row).collect(),
            worst,
        }
    }
}
