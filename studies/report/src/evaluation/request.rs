//! What the report covers ([`Request`], which the command `report` fills in), and how the report's
//! sections deal with failed runs: the failure is listed, and the rest is reported.

use anyhow::Result;
use cosim::{Experiment, System};

use super::recorded::RecordedStudies;

/// Factor on the inertias with which the adaptation is shown besides nominal inertias.
pub const UNCERTAIN: f64 = 1.4;

/// The systems and conditions of a report; a section whose system is absent is left out.
pub struct Request<'a> {
    /// The machine.
    pub system: &'a System,
    /// The conditions that all runs share.
    pub base: &'a Experiment,
    /// The one-axis experiment.
    pub testbed: Option<&'a System>,
    /// The machine of the real world.
    pub real: Option<&'a System>,
    /// The machine that bends.
    pub bending: Option<&'a System>,
    /// The machine fed by a battery.
    pub electric: Option<&'a System>,
    /// Recorded results of studies that take hours.
    pub recorded: RecordedStudies,
    /// Name of a path of the user's own, and the experiment that follows it.
    pub path: Option<(String, Experiment)>,
}

impl Request<'_> {
    /// The conditions for a system other than the machine, which lacks the machine's start values.
    pub fn elsewhere(&self) -> Experiment {
        Experiment {
            settings: Vec::new(),
            ..self.base.clone()
        }
    }
}

/// The successful results; the errors of the others go to `failures`.
pub fn successes<T>(
    results: impl IntoIterator<Item = Result<T>>,
    failures: &mut Vec<String>,
) -> Vec<T> {
    let results = results.into_iter();
    results.filter_map(|r| success(r, failures)).collect()
}

/// The result, or nothing if it is an error, which goes to `failures`.
pub fn success<T>(result: Result<T>, failures: &mut Vec<String>) -> Option<T> {
    result
        .map_err(|error| failures.push(format!("{error:#}")))
        .ok()
}
