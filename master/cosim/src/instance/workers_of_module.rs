//! Worker threads in a WebAssembly module: there are none, because a module runs in the thread of
//! its host. Without the feature `native` this file replaces `workers.rs`.

use anyhow::{Result, bail};

pub enum Worker {}

impl Worker {
    pub fn start(_: usize, _: usize, _: bool) -> Result<Self> {
        bail!("this program runs in one thread")
    }
}
