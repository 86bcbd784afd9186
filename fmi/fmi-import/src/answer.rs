//! How a C function answered, and where in the run it was called: what the text of an error is made
//! of.

use std::ffi::c_int;

use anyhow::Result;
use thiserror::Error;

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
            Self::Time(t) => write!(f, "at t = {t} s"),
        }
    }
}

/// A C function that did not do what it was asked for: both versions of FMI number their statuses
/// alike.
#[derive(Clone, Copy, Debug, Error)]
#[error("{call} answered {status}")]
pub struct Answer {
    /// Status, or [`status::ABSENT`] or [`status::UNFIT`].
    pub status: c_int,
    /// C name of the function.
    pub call: &'static str,
}

impl Answer {
    /// Good where the status is OK or Warning.
    #[inline]
    pub fn check(status: c_int, call: &'static str) -> Result<()> {
        match status {
            0 | 1 => Ok(()),
            _ => Self::refuse(status, call),
        }
    }

    /// As an error.
    #[cold]
    pub fn refuse(status: c_int, call: &'static str) -> Result<()> {
        Err(Self { status, call }.into())
    }

    /// Status in an error that is an answer.
    pub fn status(error: &anyhow::Error) -> Option<c_int> {
        error.downcast_ref().map(|answer: &Self| answer.status)
    }
}

/// An FMU asks to end the simulation: the end of a run, not a failure.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{call} asks to end the simulation at t = {time} s")]
pub struct Ended {
    /// C name of the function that said so.
    pub call: &'static str,
    /// Its time, s.
    pub time: f64,
}

/// A component did not come to the end of its step: with all others it may be repeated to where it
/// stopped.
#[derive(Clone, Debug, Error, PartialEq)]
pub struct Stopped {
    /// Name of the component.
    pub name: String,
    /// Its last successful time, s, where it tells.
    pub time: Option<f64>,
}

impl std::fmt::Display for Stopped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = &self.name;
        match self.time {
            Some(time) => write!(
                f,
                "the run ends at t = {time} s, the last successful time of {name}"
            ),
            None => write!(f, "the run ends, because {name} does not make this step"),
        }
    }
}

/// Calls a function of a library; an error where it is missing or does not do it.
macro_rules! call {
    ($api:expr, $function:ident($($argument:expr),* $(,)?)) => {
        Answer::check(($api.$function)($($argument),*), stringify!($function))
    };
}
pub(crate) use call;
