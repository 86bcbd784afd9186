//! Standard output: ours stays ours. Many FMUs print banners there; what they print goes to
//! standard error, and is named as theirs while they are loaded and made.

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

/// Write to our standard output.
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

/// From now on what else is printed to standard output in this program goes to standard error. For
/// programs, at their start.
///
/// # Errors
/// What the system says.
pub fn separate() -> io::Result<()> {
    own::separate()
}

/// The end of a program.
///
/// The library of pythonfmu (0.7.0) frees its interpreter's state twice when a process ends in the
/// usual way: its finalizer runs after the destructors of its static objects, which corrupts the
/// heap, and some processes abort after all work is done. So nothing of the kind is run where
/// Python's library is in the process.
pub fn end(code: u8) -> ExitCode {
    #[cfg(all(unix, feature = "native"))]
    // SAFETY: the name is a C string; nothing is to be run any more.
    unsafe {
        if !libc::dlsym(libc::RTLD_DEFAULT, c"Py_Initialize".as_ptr()).is_null() {
            // Nobody may read the output any more.
            let _ = io::stdout().flush();
            libc::_exit(code.into());
        }
    }
    ExitCode::from(code)
}

/// Call what may print; where outputs are separate, its lines are named as those of `who`.
pub fn named<T>(who: &str, call: impl FnOnce() -> T) -> T {
    own::named(who, call)
}

#[cfg(all(unix, feature = "native"))]
mod own {
    use std::fs::File;
    use std::io::{self, Read, Seek, SeekFrom};
    use std::os::fd::{AsRawFd, FromRawFd};
    use std::sync::{Mutex, OnceLock};

    /// The standard output that the program was started with.
    static OWN: OnceLock<File> = OnceLock::new();
    /// One at a time is listened to.
    static LISTENING: Mutex<()> = Mutex::new(());

    pub fn stdout() -> Option<&'static File> {
        OWN.get()
    }

    /// What the C library still holds is written.
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
        let _ = OWN.set(unsafe { File::from_raw_fd(own) });
        copy(libc::STDERR_FILENO, libc::STDOUT_FILENO)
    }

    pub fn named<T>(who: &str, call: impl FnOnce() -> T) -> T {
        if OWN.get().is_none() {
            return call();
        }
        let (Ok(_guard), Ok(mut file)) = (LISTENING.lock(), tempfile::tempfile()) else {
            return call();
        };
        flush();
        if copy(file.as_raw_fd(), libc::STDOUT_FILENO).is_err() {
            return call();
        }
        let result = call();
        flush();
        // Where this fails there is no standard error either.
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

    pub fn separate() -> io::Result<()> {
        Ok(())
    }

    pub fn named<T>(_: &str, call: impl FnOnce() -> T) -> T {
        call()
    }
}
