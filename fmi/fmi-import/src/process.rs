//! Waits for a process that runs an FMU, which may hang.
//!
//! ```
//! use std::{process::Command, time::Duration};
//! let child = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into())).arg("-V").spawn()?;
//! assert!(fmi_import::process::wait(child, Duration::from_secs(60))?.is_some());
//! # anyhow::Ok(())
//! ```

use std::process::{Child, ExitStatus};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Result;

/// Waits until a process ends; returns its status, or None if it was killed because it took longer
/// than the limit.
///
/// # Errors
/// The system cannot wait for it or kill it.
pub fn wait(mut child: Child, limit: Duration) -> Result<Option<ExitStatus>> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if begun.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(2));
    }
}
