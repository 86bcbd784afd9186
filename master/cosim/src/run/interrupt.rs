//! Ends runs on Ctrl-C and other signals that ask a program to end. The first only sets a flag that
//! runs look at between steps, so that rows are kept and folders removed; a second ends the program.

use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

/// The signal that came; 0 if none did.
static SIGNAL: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// The error of a run that a signal ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interrupted {
    /// Number of the signal.
    pub signal: usize,
    /// Time that the run has reached, s; None between runs.
    pub time: Option<f64>,
}

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.signal {
            1 => "SIGHUP",
            2 => "Ctrl-C (SIGINT)",
            15 => "SIGTERM",
            _ => "a signal",
        };
        match self.time {
            Some(time) => write!(f, "{name} stopped the run at t = {time} s"),
            None => write!(f, "{name} stopped the program"),
        }
    }
}

impl std::error::Error for Interrupted {}

impl Interrupted {
    /// Exit code of a program that ends with this error.
    pub fn exit_code(&self) -> u8 {
        u8::try_from(128 + self.signal).unwrap_or(1)
    }
}

/// The signal that asked this program to end.
pub fn signal() -> Option<usize> {
    Some(SIGNAL.load(Ordering::Relaxed)).filter(|signal| *signal != 0)
}

/// For what comes after runs, such as a file of results, which would be incomplete.
///
/// # Errors
/// A signal has asked this program to end.
pub fn check() -> Result<(), Interrupted> {
    let time = None;
    signal().map_or(Ok(()), |signal| Err(Interrupted { signal, time }))
}

/// Has signals end runs; to be called at the start of a program. A file that becomes larger than
/// the system allows is an error from now on, and no longer the end of the process.
pub fn install() -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::flag::{register, register_conditional_shutdown, register_usize};
    let has_come = Arc::default();
    #[cfg(unix)]
    register(signal_hook::consts::signal::SIGXFSZ, Arc::default())?;
    #[cfg(unix)]
    const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
    #[cfg(not(unix))]
    const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];
    for signal in SIGNALS {
        register_conditional_shutdown(signal, 128 + signal, Arc::clone(&has_come))?;
        register(signal, Arc::clone(&has_come))?;
        register_usize(signal, Arc::clone(&SIGNAL), signal as usize)?;
    }
    Ok(())
}
