//! How many threads go on with a run of which nobody has said it: its first steps are made by one
//! thread, and once more by several where they take long. Those who are faster go on.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::fmu::Fmu;
use crate::master::Master;
use crate::run::experiment::Experiment;
use crate::run::plan::Plan;
use crate::run::supervision::Supervision;
use crate::schedule::crew::cores;
use crate::stepping::Steps;
use crate::structure::system::System;
use fmi_import::messages;

/// Steps of the trial.
pub(crate) const STEPS: usize = 8;
/// Where the shortest takes less, several threads are not tried, s: one that sleeps takes some 10 µs
/// to begin.
const LONG_STEP: f64 = 100e-6;
/// Nor are they for a run that will end sooner, s: they load the FMUs once more.
const LONG_RUN: f64 = 0.5;
/// They go on where half of their steps take at most this part of the shortest of one thread: where
/// others compute, too, threads wait for each other, and one is faster.
const GAIN: f64 = 0.8;

/// The run in several threads after the trial, where they are faster than the one that `alone` has
/// begun with, whose `shortest` step took so long; so many steps are `left`.
pub(crate) fn wide(
    (system, plan, alone): (&System, &Plan, &Experiment),
    shortest: Duration,
    left: u64,
    supervision: &mut Supervision,
) -> Option<(Master, Steps)> {
    let (step, threads) = (shortest.as_secs_f64(), cores().min(system.fmus.len()));
    let is_once = |fmu: &Arc<Fmu>| fmu.description.capabilities.only_once;
    let is_long = step > LONG_STEP && step * left as f64 > LONG_RUN;
    if threads == 1 || !is_long || system.fmus.iter().any(is_once) {
        return None;
    }
    let said = messages::take();
    let experiment = Experiment {
        threads,
        ..alone.clone()
    };
    let repeated = || -> Result<_> {
        let mut master = experiment.start(system)?;
        let (mut steps, _) = plan.steps(system, &master)?;
        let mut times = [Duration::ZERO; STEPS];
        for time in &mut times {
            let before = Instant::now();
            steps.make(&mut master)?;
            *time = before.elapsed();
        }
        times.sort();
        let is_faster = times[STEPS / 2] < shortest.mul_f64(GAIN);
        Ok(is_faster.then_some((master, steps)))
    };
    let wide = repeated();
    match &wide {
        Ok(Some(_)) => supervision.note(format!(
            "the steps take long: {threads} threads make them (--threads 1: one)"
        )),
        Ok(None) | Err(_) => {
            messages::take();
            messages::extend(said);
        }
    }
    wide.unwrap_or_else(|error| {
        supervision.note(format!(
            "one thread makes all steps, long as they are: {error:#}"
        ));
        None
    })
}
