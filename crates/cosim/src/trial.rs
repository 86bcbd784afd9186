//! How many threads go on with a run of which nobody has said it: its first steps, made by one
//! thread, are made once more by several where they take long. Those who are faster go on; the
//! results are the same.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::crew::cores;
use crate::experiment::Experiment;
use crate::fmu::Fmu;
use crate::master::Master;
use crate::run::{Plan, steps_of};
use crate::slave::messages;
use crate::stepping::Steps;
use crate::supervision::Supervision;
use crate::system::System;

/// Steps of it.
const STEPS: usize = 8;
/// Where the shortest takes less, several threads are not tried, s: a thread that sleeps takes some
/// 10 µs to begin.
const LONG_STEP: f64 = 100e-6;
/// Nor are they for a run that will end sooner, s: they load the FMUs once more.
const LONG_RUN: f64 = 0.5;
/// They go on where half of their steps take at most this part of the shortest of one thread: where
/// others compute, too, threads wait for each other, and one is faster.
const GAIN: f64 = 0.8;

/// The first steps of a run.
pub(crate) struct Trial<'a> {
    alone: &'a Experiment,
    made: usize,
    /// Others may have waited for a busy machine.
    shortest: Duration,
}

impl<'a> Trial<'a> {
    /// Of a run that the experiment began in one thread.
    pub fn new(alone: &'a Experiment) -> Self {
        Self {
            alone,
            made: 0,
            shortest: Duration::MAX,
        }
    }

    /// A step has taken so long; whether it was the last one of the trial.
    pub fn is_over(&mut self, time: Duration) -> bool {
        self.made += 1;
        self.shortest = self.shortest.min(time);
        self.made == STEPS
    }

    /// The run in several threads after the trial, where they are faster; so many steps are `left`.
    pub fn wide(
        &self,
        system: &System,
        plan: &Plan,
        left: u64,
        supervision: &mut Supervision,
    ) -> Option<(Master, Steps)> {
        let (step, threads) = (self.shortest.as_secs_f64(), cores().min(system.fmus.len()));
        let is_once = |fmu: &Arc<Fmu>| fmu.description.capabilities.only_once;
        let is_long = step > LONG_STEP && step * left as f64 > LONG_RUN;
        if threads == 1 || !is_long || system.fmus.iter().any(is_once) {
            return None;
        }
        let said = messages::take();
        match self.repeated(system, plan, threads) {
            Ok(Some(wide)) => {
                supervision.note(format!(
                    "the steps take long: {threads} threads make them (--threads 1: one)"
                ));
                return Some(wide);
            }
            Ok(None) => {}
            Err(error) => supervision.note(format!(
                "one thread makes all steps, long as they are: {error:#}"
            )),
        }
        messages::take();
        messages::extend(said);
        None
    }

    /// The same steps by several threads; none where they are not faster.
    fn repeated(
        &self,
        system: &System,
        plan: &Plan,
        threads: usize,
    ) -> Result<Option<(Master, Steps)>> {
        let experiment = Experiment {
            threads,
            ..self.alone.clone()
        };
        let mut master = experiment.start(system)?;
        let (mut steps, _) = steps_of(system, &master, plan)?;
        let mut times = [Duration::ZERO; STEPS];
        for time in &mut times {
            let before = Instant::now();
            steps.make(&mut master)?;
            *time = before.elapsed();
        }
        times.sort();
        let is_faster = times[STEPS / 2] < self.shortest.mul_f64(GAIN);
        Ok(is_faster.then_some((master, steps)))
    }
}
