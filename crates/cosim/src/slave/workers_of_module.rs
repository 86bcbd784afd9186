//! Modules run in the thread of their host.

use anyhow::Result;

use super::border::{Arguments, Border};
use crate::fmu::Fmu;

/// There is none.
pub enum Worker {}

impl Worker {
    pub fn start(_: usize, _: bool) -> Result<Self> {
        anyhow::bail!("this program runs in one thread")
    }

    pub fn make(&self, _: &Fmu, _: &Arguments) -> Result<Option<Box<dyn Border>>> {
        match *self {}
    }
}
