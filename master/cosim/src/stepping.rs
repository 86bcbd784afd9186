//! How a run comes from its start to its end: by steps of one length, or of lengths that are chosen
//! on the way.

mod chosen;
mod control;
mod fixed;

use anyhow::{Result, bail};

pub use chosen::{ChosenSteps, StepCount};
pub(crate) use control::Progress;
pub use control::{Control, Limits};
pub use fixed::FixedSteps;

use crate::master::Master;
use crate::structure::system::System;

/// The communication steps of a run to a stop time.
pub enum Steps {
    /// Of one length.
    Fixed(FixedSteps),
    /// Of lengths that are chosen, or repeated.
    Chosen(ChosenSteps),
}

impl Steps {
    /// The steps of `master`, which runs `system`, to `stop`, s.
    ///
    /// # Errors
    /// A stop time before the start or not finite; lengths that cannot be chosen for this system.
    pub fn new(system: &System, master: &Master, stop: f64, control: &Control) -> Result<Self> {
        if let Control::Fixed = control {
            return Ok(Self::Fixed(FixedSteps::new(master.stepping(), stop)?));
        }
        if let Some(fixed) = system.fixed_step() {
            bail!(
                "`{fixed}` cannot vary its step, so that the length of steps can neither be chosen nor repeated"
            );
        }
        Ok(Self::Chosen(ChosenSteps::new(
            system, master, stop, control,
        )?))
    }

    /// Make a step; false where its end is a point that is lost.
    pub fn make(&mut self, master: &mut Master) -> Result<bool> {
        match self {
            Self::Fixed(steps) => steps.make(master),
            Self::Chosen(steps) => steps.make(master).map(|()| true),
        }
    }

    /// Whether the stop time is reached.
    pub fn is_over(&self, master: &Master) -> bool {
        match self {
            Self::Fixed(steps) => steps.made() >= steps.count(),
            Self::Chosen(steps) => master.time() >= steps.stop(),
        }
    }

    /// Numbers of steps that are made, and of all, where lengths are chosen as far as is known now.
    pub fn so_far(&self, master: &Master) -> (u64, u64) {
        match self {
            Self::Fixed(steps) => (steps.made(), steps.count()),
            Self::Chosen(steps) => steps.so_far(master),
        }
    }

    /// How many steps were made and repeated, where lengths are chosen.
    pub fn chosen(&self) -> Option<StepCount> {
        match self {
            Self::Fixed(_) => None,
            Self::Chosen(steps) => Some(steps.made()),
        }
    }

    pub(crate) fn progress(&self) -> Progress {
        match self {
            Self::Fixed(steps) => Progress {
                made: steps.made(),
                ..Progress::default()
            },
            Self::Chosen(steps) => steps.progress(),
        }
    }

    /// Go on from where another run has come, to the time of `master`.
    pub(crate) fn go_on(&mut self, master: &Master, progress: Progress) -> Result<()> {
        match self {
            Self::Fixed(steps) => steps.go_on(master.time(), progress.made),
            Self::Chosen(steps) => {
                steps.go_on(progress);
                Ok(())
            }
        }
    }
}
