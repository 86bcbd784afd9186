//! The plan of a run, besides its experiment, as `cosim run` and the studies give it to `simulate`:
//! where the run ends, how long its steps are, and which files it is saved to or resumed from.

use std::path::PathBuf;

use anyhow::Result;

use crate::master::Master;
use crate::run::experiment::Experiment;
use crate::run::run_key::RunKey;
use crate::stepping::{StepControl, Steps};
use crate::structure::system::System;

/// The plan of a run.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Stop time, s.
    pub stop: f64,
    /// How the lengths of communication steps are chosen.
    pub control: StepControl,
    /// Snapshots: the run is saved to each file at the first communication point at or after the
    /// time, s.
    pub snapshots: Vec<(f64, PathBuf)>,
    /// File of the snapshot from which the run is resumed.
    pub resume: Option<PathBuf>,
    /// Key of the run, which snapshots and a resumed run need: see [`Plan::key`].
    pub key: Option<RunKey>,
    /// The experiment that made the master on one thread, if the number of threads may be chosen:
    /// where the first steps take long, they are repeated on as many threads as there are cores,
    /// and the faster continue. The observer sees the same values.
    pub threads_for: Option<Experiment>,
}

impl Plan {
    /// Steps of one length to `stop`, s.
    pub fn to(stop: f64) -> Self {
        Self {
            stop,
            ..Self::default()
        }
    }

    /// The stop time that FMUs are told, s; None for a run that is saved or resumed, which may go on
    /// to a later one.
    pub fn told_stop(&self) -> Option<f64> {
        let is_whole = self.snapshots.is_empty() && self.resume.is_none();
        is_whole.then_some(self.stop)
    }

    /// The key of a run of `experiment` on `system` by this plan. Its snapshots may be taken at any
    /// time.
    pub fn key(&self, system: &System, experiment: &Experiment) -> RunKey {
        let mut key = RunKey::new(system, experiment);
        key.add("the choice of steps", format!("{:?}", self.control));
        key
    }

    /// The steps of a run of `master`. True if a last, shortened step is left out, because a
    /// component cannot vary its step.
    pub(crate) fn steps(&self, system: &System, master: &Master) -> Result<(Steps, bool)> {
        let mut steps = Steps::new(system, master, self.stop, &self.control)?;
        let lacks_rest = match &mut steps {
            Steps::Fixed(steps) => system.fixed_step().is_some() && steps.omit_rest(),
            Steps::Variable(_) => false,
        };
        Ok((steps, lacks_rest))
    }
}
