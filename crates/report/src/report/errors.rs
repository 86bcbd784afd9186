//! The robustness studies besides the paper's: what is varied, a table, and where the worst case
//! is.

use anyhow::Result;
use serde::Serialize;

use super::request::Request;
use super::table::{TableCell, TipCell, failure_in as failure};
use studies::grid::Case;
use studies::studies::inertia::MODES;
use studies::studies::robustness::{self, STUDIES, Study};

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
    pub fn count(&self) -> u64 {
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
            let cells = robustness::run(request.system, request.base, cases, &done)?;
            failures.extend(cells.iter().filter_map(|cell| failure(cell, &cell.case)));
            Ok(ErrorStudy::of(*study, &cells))
        };
        self.0.iter().map(one).collect()
    }
}

impl ErrorStudy {
    fn of(study: Study, cells: &[TipCell]) -> Self {
        let row = |cells: &[TipCell]| Row {
            trajectory: cells[0].trajectory,
            case: cells[0].case.clone(),
            cells: cells.iter().map(TableCell::of).collect(),
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
