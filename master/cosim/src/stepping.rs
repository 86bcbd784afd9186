//! The communication steps of a run, which `simulate` makes: of one length, variable or repeated.

mod controller;
mod fixed;
mod variable;

use anyhow::{Result, bail};

pub(crate) use controller::Progress;
pub use controller::{StepControl, StepLimits};
pub use fixed::FixedSteps;
pub use variable::{StepCount, VariableSteps};

use crate::master::Master;
use crate::structure::system::System;

/// The communication steps of a run to a stop time.
pub enum Steps {
    /// Of one length.
    Fixed(FixedSteps),
    /// Of variable length, or repeated.
    Variable(VariableSteps),
}

impl Steps {
    /// The steps of `master`, which runs `system`, to `stop`, s.
    pub fn new(system: &System, master: &Master, stop: f64, control: &StepControl) -> Result<Self> {
        if let StepControl::Fixed = control {
            return Ok(Self::Fixed(FixedSteps::new(master.stepping(), stop)?));
        }
        if let Some(fixed) = system.fixed_step() {
            bail!(
                "`{fixed}` cannot vary its step, so that the length of steps can neither be chosen nor repeated"
            );
        }
        Ok(Self::Variable(VariableSteps::new(
            system, master, stop, control,
        )?))
    }

    /// Makes a step; false if jitter leaves out its communication point.
    pub fn make(&mut self, master: &mut Master) -> Result<bool> {
        match self {
            Self::Fixed(steps) => steps.make(master),
            Self::Variable(steps) => steps.make(master).map(|()| true),
        }
    }

    /// Whether the stop time is reached.
    pub fn is_over(&self, master: &Master) -> bool {
        match self {
            Self::Fixed(steps) => steps.made >= steps.all(),
            Self::Variable(steps) => master.time() >= steps.stop,
        }
    }

    /// Number of steps that are made, and of all; of variable steps an estimate.
    pub fn so_far(&self, master: &Master) -> (u64, u64) {
        match self {
            Self::Fixed(steps) => (steps.made, steps.all()),
            Self::Variable(steps) => steps.so_far(master),
        }
    }

    /// Numbers and lengths of variable steps.
    pub fn count(&self) -> Option<StepCount> {
        match self {
            Self::Fixed(_) => None,
            Self::Variable(steps) => Some(steps.count),
        }
    }

    pub(crate) fn progress(&self) -> Progress {
        let (made, controller) = match self {
            Self::Fixed(steps) => (steps.made, Default::default()),
            Self::Variable(steps) => (steps.count.made, steps.controller.state),
        };
        Progress { made, controller }
    }

    /// Continues after the steps of another run, at the time of `master`.
    pub(crate) fn resume(&mut self, master: &Master, progress: Progress) -> Result<()> {
        match self {
            Self::Fixed(steps) => steps.resume(master.time(), progress.made),
            Self::Variable(steps) => {
                steps.controller.state = progress.controller;
                Ok(())
            }
        }
    }
}
