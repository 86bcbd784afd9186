//! Chooses the number of threads of `cosim run` without `--threads`: times the first eight steps on
//! one thread; if they are long, times them again on several threads, and keeps the faster.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::fmu::Fmu;
use crate::master::Master;
use crate::run::experiment::Experiment;
use crate::run::plan::Plan;
use crate::run::supervision::Supervision;
use crate::schedule::thread_plan::cores;
use crate::stepping::Steps;
use crate::structure::system::System;
use fmi_import::messages;

/// Steps that are timed.
pub(crate) const STEPS: usize = 8;
/// Several threads are tried only if the shortest step takes longer than this, s: to wait for each
/// other once a step takes them some 2 µs, and some 10 µs where one sleeps.
const LONG_STEP: f64 = 30e-6;
/// Several threads are tried only if the rest of the run takes longer than this, s: they load the
/// FMUs once more.
const LONG_RUN: f64 = 0.5;
/// Several threads are kept if their median step takes at most this part of the shortest step on
/// one thread. On a busy machine they wait for each other, and one thread is faster.
const GAIN: f64 = 0.8;

/// The run on several threads, after the steps that are timed, if it is faster than on the one
/// thread with which `experiment` was started; `shortest` is that thread's shortest step, `left`
/// the number of steps to come.
pub(crate) fn multi_threaded(
    system: &System,
    plan: &Plan,
    experiment: &Experiment,
    shortest: Duration,
    left: u64,
    supervision: &mut Supervision,
) -> Option<(Master, Steps)> {
    let own = system.fmus.iter().filter(|fmu| fmu.isolation.is_none());
    let (step, threads) = (shortest.as_secs_f64(), cores().min(own.count()));
    let is_only_one = |fmu: &Arc<Fmu>| fmu.description.capabilities.only_once;
    let is_long = step > LONG_STEP && step * left as f64 > LONG_RUN;
    if threads <= 1 || !is_long || system.fmus.iter().any(is_only_one) {
        return None;
    }
    let first_messages = messages::take();
    let run_again = || -> Result<_> {
        let mut experiment = experiment.clone();
        experiment.threads = threads;
        let mut master = experiment.start_until(system, plan.told_stop())?;
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
    let chosen = run_again();
    if let Ok(Some(_)) = chosen {
        supervision.findings.note(format!(
            "the steps take long, so {threads} threads make them (--threads 1 for one)"
        ));
    } else {
        messages::take();
        messages::extend(first_messages);
    }
    chosen.unwrap_or_else(|error| {
        supervision.findings.note(format!(
            "one thread makes all steps, although they take long: {error:#}"
        ));
        None
    })
}
