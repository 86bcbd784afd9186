//! Worker threads in a WebAssembly module: there are none, because a module runs in the thread of
//! its host. Without the feature `native` this file replaces `workers.rs`.

use anyhow::{Result, bail};

use super::step_calls::{StepCalls, StepsDone};

#[derive(Clone, PartialEq)]
pub enum Worker {}

impl Worker {
    pub fn start(_: usize, _: usize, _: bool) -> Result<Self> {
        bail!("this program runs in one thread")
    }

    pub fn last(&self) -> usize {
        match *self {}
    }

    pub fn plan_steps(&self, _: Vec<(usize, StepCalls)>) {
        match *self {}
    }

    pub fn begin_steps(&self, _: [f64; 2], _: Vec<f64>) {
        match *self {}
    }

    pub fn end_steps(&self) -> Result<StepsDone> {
        match *self {}
    }
}
