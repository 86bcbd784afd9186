//! The report's section on the robustness studies besides the paper's table: what each varies, its
//! runs, and its worst case. `Report::new` makes it.

use anyhow::Result;
use serde_json::{Value, json};

use super::request::Request;
use experiments::analyses::robustness::{self, STUDIES, Study};
use experiments::measures::run::TipError;
use experiments::print::tip_errors::robustness_json;
use experiments::runs::grid::{Case, Cell};

/// First of the three seeds of the noise study.
const SEED: u64 = 1;

/// The studies with the cases to run.
pub fn plan(request: &Request<'_>) -> Result<Vec<(Study, Vec<Case>)>> {
    let cases = |study: Study| Ok((study, study.cases(request.system, request.base, SEED)?));
    STUDIES.into_iter().map(cases).collect()
}

/// Makes the runs of one study; the reason of a failed one is in its cell and in `failures`.
pub fn results(
    request: &Request<'_>,
    (study, cases): &(Study, Vec<Case>),
    done: impl Fn() + Sync,
    failures: &mut Vec<String>,
) -> Result<Value> {
    let cells = robustness::run(request.system, request.base, cases, done)?;
    failures.extend(cells.iter().filter_map(|cell| failure(cell, &cell.case)));
    let worst = robustness::worst(&cells).map(|(cell, tip)| {
        json!({
            "trajectory": cell.trajectory,
            "case": cell.case,
            "rmse": tip.motion.rms(),
            "max": tip.motion.max,
        })
    });
    Ok(json!({
        "study": study,
        "varied": study.varied(),
        "target": study.target(),
        "cells": robustness_json(*study, &cells),
        "worst": worst,
    }))
}

/// The report's line on a cell that failed.
pub fn failure(cell: &Cell<TipError>, case: &str) -> Option<String> {
    let error = cell.error()?;
    Some(format!(
        "{}, {}, {case}: {error:#}",
        cell.trajectory, cell.law
    ))
}
