//! Keeps what FMUs print apart from the standard output of the master's program `cosim`. Many FMUs
//! print banners there: once outputs are [separate], that goes to standard error, with the name of
//! the FMU while it is loaded and instantiated.
//!
//! ```
//! fmi_import::output::write("0.01,1.5\n")?;
//! # std::io::Result::Ok(())
//! ```

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

pub use own::{named, separate};

/// Writes to the standard output of this program.
pub fn write(text: impl Display) -> io::Result<()> {
    match own::stdout() {
        Some(mut out) => write!(out, "{text}"),
        None => {
            let mut out = io::stdout().lock();
            write!(out, "{text}")?;
            out.flush()
        }
    }
}

/// Ends a program with this exit code.
///
/// If Python's library is in the process, no destructors are run: the library of pythonfmu (0.7.0)
/// frees its interpreter's state twice when they are, and some processes would abort after all work
/// is done.
pub fn end(code: u8) -> ExitCode {
    #[cfg(all(unix, feature = "native"))]
    // SAFETY: the name is a C string; nothing is to be run any more.
    unsafe {
        if !libc::dlsym(libc::RTLD_DEFAULT, c"Py_Initialize".as_ptr()).is_null() {
            // A failure means that the reader of the output is gone.
            let _ = io::stdout().flush();
            libc::_exit(code.into());
        }
    }
    ExitCode::from(code)
}

#[cfg(all(unix, feature = "native"))]
mod own {
    use std::fs::File;
    use std::io::{self, Read, Seek, SeekFrom};
    use std::os::fd::{AsRawFd, FromRawFd};
    use std::sync::{Mutex, OnceLock};

    /// The standard output that the program was started with.
    static OWN: OnceLock<File> = OnceLock::new();
    /// Held while the output of a call is captured.
    static CAPTURING: Mutex<()> = Mutex::new(());

    pub fn stdout() -> Option<&'static File> {
        OWN.get()
    }

    /// Writes what the C library has buffered.
    fn flush() {
        // SAFETY: NULL means all streams.
        unsafe { libc::fflush(std::ptr::null_mut()) };
    }

    fn copy(from: i32, to: i32) -> io::Result<()> {
        // SAFETY: plain numbers.
        match unsafe { libc::dup2(from, to) } {
            -1 => Err(io::Error::last_os_error()),
            _ => Ok(()),
        }
    }

    /// Redirects to standard error all that is printed to standard output other than by
    /// [`write`](super::write). To be called at the start of a program.
    ///
    /// # Errors
    /// The system cannot redirect it.
    pub fn separate() -> io::Result<()> {
        if OWN.get().is_some() {
            return Ok(());
        }
        // SAFETY: plain numbers.
        let own = unsafe { libc::dup(libc::STDOUT_FILENO) };
        if own == -1 {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: a new descriptor, which nobody else closes.
        let own = unsafe { File::from_raw_fd(own) };
        output_file::set_stdout(own.try_clone()?);
        let _ = OWN.set(own);
        copy(libc::STDERR_FILENO, libc::STDOUT_FILENO)
    }

    /// Calls a function that may print. If outputs are separate, its lines are printed with the
    /// name `who`.
    pub fn named<T>(who: &str, call: impl FnOnce() -> T) -> T {
        if OWN.get().is_none() {
            return call();
        }
        let (Ok(_guard), Ok(mut file)) = (CAPTURING.lock(), tempfile::tempfile()) else {
            return call();
        };
        flush();
        if copy(file.as_raw_fd(), libc::STDOUT_FILENO).is_err() {
            return call();
        }
        let result = call();
        flush();
        // If this fails, there is no standard error either.
        let _ = copy(libc::STDERR_FILENO, libc::STDOUT_FILENO);
        let mut bytes = Vec::new();
        if file.seek(SeekFrom::Start(0)).is_ok() && file.read_to_end(&mut bytes).is_ok() {
            for line in String::from_utf8_lossy(&bytes).lines() {
                eprintln!("{who} prints: {line}");
            }
        }
        result
    }
}

#[cfg(not(all(unix, feature = "native")))]
mod own {
    use std::{fs::File, io};

    pub fn stdout() -> Option<&'static File> {
        None
    }

    /// Does nothing here, where FMUs cannot print.
    pub fn separate() -> io::Result<()> {
        Ok(())
    }

    /// Calls the function.
    pub fn named<T>(_: &str, call: impl FnOnce() -> T) -> T {
        call()
    }
}
