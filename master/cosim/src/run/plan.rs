//! How a run is made: where it ends, how long its steps are, and what it is saved to.

use std::path::PathBuf;

use anyhow::Result;

use crate::master::Master;
use crate::run::experiment::Experiment;
use crate::stepping::{Control, Steps};
use crate::structure::system::System;

/// How a run is made.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Stop time, s.
    pub stop: f64,
    /// How long the communication steps are.
    pub control: Control,
    /// The run is saved to these files, at the first communication point that is not before the
    /// time, s, beside each.
    pub snapshots: Vec<(f64, PathBuf)>,
    /// It goes on from this file.
    pub resume: Option<PathBuf>,
    /// The experiment that made the master in one thread, where the run may be shared out: if its
    /// first steps take long, they are made once more by as many threads as there are cores, which
    /// then go on if they are faster. What is observed is the same.
    pub alone: Option<Experiment>,
}

impl Plan {
    /// Steps of one length to `stop`, s.
    pub fn to(stop: f64) -> Self {
        Self {
            stop,
            ..Self::default()
        }
    }

    /// The steps of a run of `master`; true where a shortened last one is left out, because a
    /// component cannot vary its step.
    pub(crate) fn steps(&self, system: &System, master: &Master) -> Result<(Steps, bool)> {
        let mut steps = Steps::new(system, master, self.stop, &self.control)?;
        let has_left_rest = match &mut steps {
            Steps::Fixed(steps) => system.fixed_step().is_some() && steps.leave_rest(),
            Steps::Chosen(_) => false,
        };
        Ok((steps, has_left_rest))
    }
}
