//! Processes that call FMUs for a program: how it starts them, waits for them and learns how they
//! ended, and what such a process watches of itself. For isolated instances, `fmu-check` and
//! `torture`.

mod watch;

use std::io;
use std::process::{Child, Command, ExitStatus};
use std::thread;
use std::time::{Duration, Instant};

use crate::under_way::EXIT_CODE;

pub use watch::{begin_call, watch};
#[cfg(all(feature = "master", target_os = "linux"))]
pub(crate) use watch::{end_call, exit_now, replace_streams};

/// A process that has not ended by itself so long after its time limit is killed.
const GRACE: Duration = Duration::from_secs(2);

/// A process that calls FMUs. If it is dropped before it has ended, it is killed.
#[derive(Debug)]
pub struct Process(Child);

impl Process {
    /// Starts it. On Linux it has a process group of its own: Ctrl-C reaches this program alone, and
    /// what it starts itself is killed with it.
    ///
    /// # Errors
    /// The system cannot start it.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        std::os::unix::process::CommandExt::process_group(command, 0);
        command.spawn().map(Self)
    }

    /// How it ended; None while it runs.
    ///
    /// # Errors
    /// The system does not tell.
    pub fn status(&mut self) -> io::Result<Option<ExitStatus>> {
        self.0.try_wait()
    }

    /// Waits until it has ended; None if it had to be killed, since it ran on after its time limit.
    ///
    /// # Errors
    /// The system does not tell.
    pub fn wait(&mut self, limit: Duration) -> io::Result<Option<ExitStatus>> {
        let begun = Instant::now();
        while begun.elapsed() < limit + GRACE {
            if let Some(status) = self.status()? {
                return Ok(Some(status));
            }
            // Quick ones end within the first.
            thread::sleep(Duration::from_millis(2).min(begun.elapsed() / 8));
        }
        self.kill()?;
        Ok(None)
    }

    /// Kills it, and waits until it has ended.
    ///
    /// # Errors
    /// The system does not allow it.
    pub fn kill(&mut self) -> io::Result<()> {
        #[cfg(target_os = "linux")]
        if self.0.try_wait()?.is_none() {
            // SAFETY: plain numbers; the process was not waited for, so its number is its own.
            unsafe { libc::kill(-(self.0.id().cast_signed()), libc::SIGKILL) };
        }
        self.0.kill()?;
        self.0.wait().map(drop)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if !matches!(self.status(), Ok(Some(_))) {
            let _ = self.kill(); // else it ends with this program
        }
    }
}

/// Whether a process that ended so has said which call was under way.
#[must_use]
pub fn is_told(status: ExitStatus) -> bool {
    status.code() == Some(EXIT_CODE.into())
}
