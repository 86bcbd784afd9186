//! How a C function answered, and where in the run it was called: what the text of an error is made
//! of.

use std::ffi::c_int;

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

/// How a C function answered: both versions of FMI number their statuses alike.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Status, or [`Answer::MISSING`].
    pub status: c_int,
    /// C name of the function.
    pub call: &'static str,
}

impl Answer {
    /// In place of a status: the library does not export the function.
    pub const MISSING: c_int = -1;

    /// In place of a status: a value is outside of the range of its type, so that it was not set.
    pub const UNFIT: c_int = -2;

    /// What the function answered.
    pub fn new(status: c_int, call: &'static str) -> Self {
        Self { status, call }
    }

    /// Of a function that this version of FMI has no need to call.
    pub fn done() -> Self {
        Self::new(0, "")
    }

    /// Of a function that the library does not export.
    pub fn missing(call: &'static str) -> Self {
        Self::new(Self::MISSING, call)
    }

    /// Of a function that was not called, because a value does not fit its type.
    pub fn unfit(call: &'static str) -> Self {
        Self::new(Self::UNFIT, call)
    }

    /// OK or Warning.
    pub fn is_done(self) -> bool {
        matches!(self.status, 0 | 1)
    }
}

/// An FMU asks to end the simulation: the end of a run, not a failure.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// C name of the function that said so.
    pub call: &'static str,
    /// Its time, s.
    pub time: f64,
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} asks to end the simulation at t = {} s",
            self.call, self.time
        )
    }
}

impl std::error::Error for Ended {}
