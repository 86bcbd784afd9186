//! What is to be reported on; what failed of it is told in the page, and the rest is shown.

use std::fmt::Display;

use anyhow::Result;
use cosim::{Experiment, System};

use super::recorded::Recorded;

/// Inertia error with which the adaptation is shown besides nominal inertias.
pub const UNCERTAIN: f64 = 1.4;

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
    /// What was recorded of studies that take hours.
    pub recorded: Recorded,
    /// A path of the reader's own by its name, and the experiment that follows it.
    pub path: Option<(String, Experiment)>,
}

impl Request<'_> {
    /// The conditions of another system than the machine, whose start values it does not have.
    pub fn elsewhere(&self) -> Experiment {
        Experiment {
            settings: Vec::new(),
            ..self.base.clone()
        }
    }
}

/// The results that are there; the others go to `failures`.
pub fn kept<T>(results: Vec<Result<T>>, failures: &mut Vec<String>) -> Vec<T> {
    let mut noted = |error| failures.push(format!("{error:#}"));
    let results = results.into_iter();
    results
        .filter_map(|result| result.map_err(&mut noted).ok())
        .collect()
}

/// The result if it is there; else it goes to `failures`, with what failed.
pub fn kept_as<T>(what: impl Display, result: Result<T>, failures: &mut Vec<String>) -> Option<T> {
    let noted = |error| failures.push(format!("{what}: {error:#}"));
    result.map_err(noted).ok()
}
