//! Keeps what FMUs print apart from the standard output of the master's program `cosim`. Many FMUs
//! print banners there: once outputs are [separate], that goes to standard error, with the name of
//! the FMU while it is loaded and instantiated, and up to a limit.
//!
//! ```
//! fmi_import::output::write("0.01,1.5\n")?;
//! # std::io::Result::Ok(())
//! ```

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

use own::drain;
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
    drain();
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
    use std::io::{self, PipeReader, Read, Write};
    use std::mem::{replace, take};
    use std::os::fd::{AsRawFd, FromRawFd};
    use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError, mpsc};
    use std::thread;

    use crate::under_way;

    /// The most bytes that are passed on of what a library prints while it is loaded or instantiated,
    /// and of what all print otherwise.
    const MAX_PRINTED: usize = 1 << 20;

    /// The standard output that the program was started with.
    static OWN: OnceLock<File> = OnceLock::new();
    static RELAY: OnceLock<Mutex<Relay>> = OnceLock::new();
    /// Held while the output of a call is captured.
    static CAPTURING: Mutex<()> = Mutex::new(());

    /// Passes on to standard error what is printed.
    struct Relay {
        reader: PipeReader,
        /// What each line begins with.
        prefix: String,
        is_in_line: bool,
        /// How many more bytes are passed on.
        left: usize,
    }

    pub fn stdout() -> Option<&'static File> {
        OWN.get()
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
        let (reader, writer) = io::pipe()?;
        // SAFETY: plain numbers.
        let own = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_DUPFD_CLOEXEC, 3) };
        // SAFETY: plain numbers.
        if own == -1 || unsafe { libc::dup2(writer.as_raw_fd(), libc::STDOUT_FILENO) } == -1 {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: a new descriptor, which nobody else closes.
        let own = unsafe { File::from_raw_fd(own) };
        output_file::set_stdout(own.try_clone()?);
        let _ = OWN.set(own);
        let pipe = reader.as_raw_fd();
        let _ = RELAY.set(Mutex::new(Relay {
            reader,
            prefix: String::new(),
            is_in_line: false,
            left: MAX_PRINTED,
        }));
        // The thread must have begun before a library is loaded: the C library begins no thread while
        // it loads one, which may print more than the pipe can hold.
        let (begun, has_begun) = mpsc::channel();
        thread::Builder::new().spawn(move || {
            let _ = begun.send(());
            while is_ready(pipe, -1) && relay().is_some_and(|mut relay| relay.pass()) {}
        })?;
        let _ = has_begun.recv();
        under_way::own_program(drain);
        under_way::remember();
        Ok(())
    }

    fn relay() -> Option<MutexGuard<'static, Relay>> {
        let relay = RELAY.get()?.lock();
        Some(relay.unwrap_or_else(PoisonError::into_inner))
    }

    /// Whether a pipe can be read within `wait`, ms; -1 waits until it can.
    fn is_ready(fd: i32, wait: i32) -> bool {
        let (events, revents) = (libc::POLLIN, 0);
        let mut pipe = libc::pollfd {
            fd,
            events,
            revents,
        };
        // SAFETY: one descriptor, which stays open.
        unsafe { libc::poll(&mut pipe, 1, wait) != 0 }
    }

    /// Passes on what was printed up to now, also what the C library has buffered.
    pub(super) fn drain() {
        begin("", None);
    }

    /// The same; from then on each line has the prefix, and up to `left` more bytes are passed on.
    /// Returns how many were left before.
    fn begin(prefix: &str, left: Option<usize>) -> usize {
        // SAFETY: NULL means all streams.
        unsafe { libc::fflush(std::ptr::null_mut()) };
        let Some(mut relay) = relay() else { return 0 };
        relay.pass();
        if take(&mut relay.is_in_line) {
            eprintln!();
        }
        relay.prefix = prefix.to_string();
        let next = left.unwrap_or(relay.left);
        replace(&mut relay.left, next)
    }

    /// Calls a function that may print. If outputs are separate, its lines are printed with the
    /// name `who`.
    pub fn named<T>(who: &str, call: impl FnOnce() -> T) -> T {
        let (Some(_), Ok(_guard)) = (RELAY.get(), CAPTURING.lock()) else {
            return call();
        };
        let left = begin(&format!("{who} prints: "), Some(MAX_PRINTED));
        let result = call();
        begin("", Some(left));
        result
    }

    impl Relay {
        /// Passes on what there is; false at the end of the pipe.
        fn pass(&mut self) -> bool {
            let mut bytes = [0; 4096];
            // Another thread may have read it meanwhile.
            while is_ready(self.reader.as_raw_fd(), 0) {
                let Ok(count @ 1..) = self.reader.read(&mut bytes) else {
                    return false;
                };
                let mut text = String::new();
                let shown = String::from_utf8_lossy(&bytes[..count.min(self.left)]);
                for line in shown.split_inclusive('\n') {
                    text += if self.is_in_line { "" } else { &self.prefix };
                    text += line;
                    self.is_in_line = !line.ends_with('\n');
                }
                if (1..=count).contains(&self.left) {
                    text += "\n(more than 1 MiB is printed; the rest is not shown)\n";
                    self.is_in_line = false;
                }
                self.left = self.left.saturating_sub(count);
                // If this fails, there is no standard error.
                let _ = io::stderr().write_all(text.as_bytes());
            }
            true
        }
    }
}

#[cfg(not(all(unix, feature = "native")))]
mod own {
    use std::{fs::File, io};

    pub fn stdout() -> Option<&'static File> {
        None
    }

    /// Does nothing.
    pub(super) fn drain() {}

    /// Does nothing here, where FMUs cannot print.
    pub fn separate() -> io::Result<()> {
        Ok(())
    }

    /// Calls the function.
    pub fn named<T>(_: &str, call: impl FnOnce() -> T) -> T {
        call()
    }
}
