//! Errors of a C function that a co-simulation master called (which function, the status that it
//! returned), and when in the run that was; instances return them, and the master explains them.
//!
//! ```
//! use fmi_import::answer::At;
//! assert_eq!(At::Time(0.5).to_string(), "at t = 0.5 s");
//! ```

use std::ffi::c_int;

use anyhow::Result;
use thiserror::Error;

use crate::batch::Batch;
use crate::digits::short;
use crate::status::{OK, WARNING};

/// Where in the run a call was made, for its error text.
#[derive(Clone, Copy, Debug)]
pub enum At {
    /// Before the first step.
    Initialization,
    /// At a communication point, s.
    Time(f64),
}

impl std::fmt::Display for At {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Initialization => f.write_str("in initialization"),
            Self::Time(t) => write!(f, "at t = {} s", short(*t)),
        }
    }
}

/// A C function returned a status other than OK and Warning. Both versions of FMI number their
/// statuses alike.
#[derive(Clone, Copy, Debug, Error)]
#[error("{call} answered {status}")]
pub struct Answer {
    /// Status, or one of the codes in its place that [`status`](crate::status) lists.
    pub status: c_int,
    /// C name of the function.
    pub call: &'static str,
}

impl Answer {
    /// Ok if the status is OK or Warning, else an `Answer` of the function `call`.
    #[inline]
    pub fn check(status: c_int, call: &'static str) -> Result<()> {
        Self::check_named(status, || call)
    }

    /// As [`Self::check`], for a function whose name is looked up only if it failed.
    #[inline]
    pub fn check_named(status: c_int, call: impl FnOnce() -> &'static str) -> Result<()> {
        match status {
            OK | WARNING => Ok(()),
            _ => Self::refuse(status, call()),
        }
    }

    /// An `Answer` as an error.
    #[cold]
    pub fn refuse(status: c_int, call: &'static str) -> Result<()> {
        Err(Self { status, call }.into())
    }

    /// The status, if the error is an `Answer`.
    pub fn status(error: &anyhow::Error) -> Option<c_int> {
        error.downcast_ref().map(|answer: &Self| answer.status)
    }
}

/// An [`Answer`] to an earlier call than the one that returns it: a set of this batch.
#[derive(Clone, Debug, Error)]
#[error("{answer}")]
pub struct LateAnswer {
    /// The answer.
    pub answer: Answer,
    /// What was set.
    pub batch: Batch,
}

/// An FMU asked to end the simulation, which ends the run without being a failure.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{call} asks to end the simulation at t = {} s", short(*.time))]
pub struct Ended {
    /// C name of the function by which it asked.
    pub call: &'static str,
    /// Time that the instance has reached, s.
    pub time: f64,
}

impl Ended {
    /// Whether the FMU asked for it after it had made a step to `end`, s. In Co-Simulation of FMI 2.0
    /// it discards the step, and nothing can be set after that.
    pub fn is_after_step(&self, end: f64) -> bool {
        self.call != "fmi2DoStep" && self.time >= end - 1e-9 * end.abs().max(1.0)
    }
}

/// An instance stopped before the end of its step. The master may repeat the step of the whole
/// system up to that time.
#[derive(Clone, Debug, Error, PartialEq)]
pub struct Stopped {
    /// Name of the instance.
    pub name: String,
    /// Its last successful time, s, if it reports one.
    pub time: Option<f64>,
}

impl std::fmt::Display for Stopped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = &self.name;
        match self.time {
            Some(time) => write!(
                f,
                "the run ends at t = {} s, the last successful time of {name}",
                short(time)
            ),
            None => write!(f, "the run ends, because {name} does not make this step"),
        }
    }
}
