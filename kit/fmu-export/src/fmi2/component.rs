//! What FMI 2.0 adds to an instance.

use super::ffi::*;
use super::log::{self, Log, Logger};
use crate::Model;
use crate::border::answer::Answer;
use crate::border::body::{self, Version};
use crate::border::call::{self, C, I, L, M, ME, N, S, T};
use crate::core::fault::Fault;
use crate::core::place::Names;
use crate::core::step::End;

/// FMI 2.0.
pub(crate) struct Fmi2 {
    /// How the last fmi2DoStep ended.
    pub(crate) last_step: Status,
    /// Whether the model wanted the simulation to end there.
    pub(crate) terminated: bool,
}

/// An instance of FMI 2.0.
pub(crate) type Body<M> = body::Body<M, Fmi2>;

impl Version for Fmi2 {
    type Status = Status;
    type Logger = Logger;
    const NAME: [u8; 4] = *b"2.0\0";
    const NAMES: Names = Names::PLAIN;
    const STATES: &'static [(u16, &'static str)] = &[
        (I, "Instantiated"),
        (N, "Initialization Mode"),
        (S, "Step Complete"),
        (M, "Event Mode"),
        (C, "Continuous-Time Mode"),
        (T, "Terminated"),
        (L, "lost by a panic"),
    ];
    const RECOVERY: &'static str = "fmi2Reset or fmi2SetFMUstate";

    #[inline]
    fn state<M: Model>(body: &Body<M>) -> u16 {
        call::state(&body.instance)
    }

    fn switched(log: &Log, on: bool, categories: &[&str]) -> Result<u32, Fault> {
        Ok(log::switched(log, on, categories))
    }
}

impl From<Answer> for Status {
    #[inline]
    fn from(answer: Answer) -> Self {
        match answer {
            Answer::Ok => Status::Ok,
            Answer::Discard => Status::Discard,
            Answer::Error => Status::Error,
        }
    }
}

/// A step that the model did not take to its end.
#[cold]
fn stopped(t: f64, h: f64, end: End) -> Fault {
    let wish = if end.terminate {
        "ends the simulation"
    } else {
        "stops"
    };
    let end = end.time;
    Fault::discarded(format_args!(
        "t = {t} s, h = {h} s: the model {wish} at {end} s"
    ))
}

impl<M: Model> Body<M> {
    /// fmi2DoStep.
    #[inline]
    pub(crate) fn do_step(&mut self, t: f64, h: f64) -> Result<(), Fault> {
        match self.instance.do_step(t, h) {
            Ok(end) if end.is_whole && !end.terminate => {
                self.own.last_step = Status::Ok;
                Ok(())
            }
            Ok(end) => {
                self.own.last_step = Status::Discard;
                self.own.terminated = end.terminate;
                Err(stopped(t, h, end))
            }
            Err(fault) => {
                if matches!(fault, Fault::Discarded(_)) {
                    self.own.last_step = Status::Discard;
                }
                Err(fault)
            }
        }
    }

    /// fmi2ExitInitializationMode.
    pub(crate) fn exit_initialization(&mut self) -> Result<(), Fault> {
        self.instance.exit_initialization()?;
        if self.interface == ME {
            self.instance.enter_events();
        }
        Ok(())
    }

    /// fmi2Reset.
    pub(crate) fn reset(&mut self) -> Result<(), Fault> {
        self.instance.reset();
        self.forget_step();
        Ok(())
    }

    /// fmi2SetFMUstate.
    pub(crate) fn restore(&mut self, handle: usize) -> Result<(), Fault> {
        self.instance.restore(handle)?;
        self.forget_step();
        Ok(())
    }

    fn forget_step(&mut self) {
        self.own.last_step = Status::Ok;
        self.own.terminated = false;
    }
}
