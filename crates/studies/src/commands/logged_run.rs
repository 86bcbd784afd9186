//! One run as `run` and `compare` make it.

use anyhow::Result;
use cosim::cli::{CsvArgs, bar};
use cosim::run::Experiment;
use cosim::system::System;

use crate::measures::iso9283::{Measures, Meter};
use crate::measures::run::{FailedRun, Outcome, run as run_once, useful};

/// Run with a progress bar, the accuracy on a test path measured, and, where asked for, a CSV file.
pub(super) fn logged_run(
    system: &System,
    experiment: &Experiment,
    csv: &CsvArgs,
    quiet: bool,
) -> Result<(Outcome, Option<Measures>)> {
    let mut meter = Meter::of(system, experiment)?;
    let mut log = csv.log(system, experiment, || useful(system))?;
    let bar = bar(0, "steps", quiet);
    let progress = |k, steps| {
        bar.set_length(steps);
        bar.set_position(k);
    };
    let outcome = run_once(system, experiment, &progress, |master| {
        meter.iter_mut().try_for_each(|meter| meter.add(master))?;
        log.iter_mut().try_for_each(|log| log.add(master))
    });
    bar.finish_and_clear();
    let outcome = outcome.map_err(FailedRun::explained)?;
    log.map_or(Ok(()), |log| log.finish())?;
    Ok((outcome, meter.and_then(|meter| meter.measures())))
}
