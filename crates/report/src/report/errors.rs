//! The robustness studies besides the paper's: what is varied, a table, and where the worst case
//! is.

use anyhow::Result;
use serde_json::{Value, json};

use super::request::Request;
use super::table::{TableCell, TipCell, failure_in as failure};
use studies::grid::Case;
use studies::studies::inertia::MODES;
use studies::studies::robustness::{self, STUDIES, Study};

/// First of the three seeds of the noise study.
const SEED: u64 = 1;

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
    ) -> Result<Vec<Value>> {
        let one = |(study, cases): &(Study, Vec<Case>)| {
            let cells = robustness::run(request.system, request.base, cases, &done)?;
            failures.extend(cells.iter().filter_map(|cell| failure(cell, &cell.case)));
            Ok(shown(*study, &cells))
        };
        self.0.iter().map(one).collect()
    }
}

/// What is varied, as a sentence; the target of the adaptive controller's RMSE, m, where one is set;
/// a row for each case on each trajectory; where its RMSE is largest.
fn shown(study: Study, cells: &[TipCell]) -> Value {
    let row = |cells: &[TipCell]| {
        json!({
            "trajectory": cells[0].trajectory,
            "case": cells[0].case,
            "cells": cells.iter().map(TableCell::of).collect::<Vec<_>>(),
        })
    };
    let worst = robustness::worst(cells).map(|(cell, tip)| {
        json!({
            "trajectory": cell.trajectory,
            "case": cell.case,
            "rmse": tip.motion.rms(),
            "max": tip.motion.max,
        })
    });
    json!({
        "study": study,
        "varied": study.varied(),
        "target": study.target(),
        "rows": cells.chunks(MODES.len()).map(row).collect::<Vec<_>>(),
        "worst": worst,
    })
}
