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
    use std::io::{self, PipeReader, PipeWriter, Read, Write};
    use std::os::fd::{AsRawFd, FromRawFd};
    use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
    use std::thread;

    use crate::under_way;

    /// The most bytes that are passed on of what a library prints while it is loaded or instantiated,
    /// and of what all print otherwise.
    const MAX_PRINTED: usize = 1 << 20;

    /// The standard output that the program was started with.
    static OWN: OnceLock<File> = OnceLock::new();
    /// What passes on what is printed while no output is captured, and where it is printed to.
    static PRINTED: OnceLock<(Arc<Mutex<Relay>>, PipeWriter)> = OnceLock::new();
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

    fn copy(from: &impl AsRawFd) -> io::Result<()> {
        // SAFETY: plain numbers.
        match unsafe { libc::dup2(from.as_raw_fd(), libc::STDOUT_FILENO) } {
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
        let own = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_DUPFD_CLOEXEC, 3) };
        if own == -1 {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: a new descriptor, which nobody else closes.
        let own = unsafe { File::from_raw_fd(own) };
        output_file::set_stdout(own.try_clone()?);
        let _ = OWN.set(own);
        let _ = PRINTED.set(start(String::new())?);
        under_way::own_program(drain);
        under_way::remember(); // The streams as they are now, not as while a call is captured.
        Ok(())
    }

    /// Calls a function that may print. If outputs are separate, its lines are printed with the
    /// name `who`.
    pub fn named<T>(who: &str, call: impl FnOnce() -> T) -> T {
        let (Some((_, usual)), Ok(_guard)) = (PRINTED.get(), CAPTURING.lock()) else {
            return call();
        };
        drain();
        let Ok((relay, writer)) = start(format!("{who} prints: ")) else {
            return call();
        };
        drop(writer);
        let result = call();
        flush();
        // If this fails, the library has closed what it had no right to.
        let _ = copy(usual);
        let mut relay = lock(&relay);
        relay.pass();
        if std::mem::take(&mut relay.is_in_line) {
            eprintln!();
        }
        result
    }

    /// Passes on what was printed up to now.
    pub(super) fn drain() {
        if let Some((relay, _)) = PRINTED.get() {
            flush();
            lock(relay).pass();
        }
    }

    /// Passes on to standard error what is printed. Its thread ends once nobody has the other end of
    /// the pipe any more: processes that an FMU has started may keep it.
    struct Relay {
        reader: PipeReader,
        /// What each line begins with.
        prefix: String,
        is_in_line: bool,
        left: usize,
    }

    /// From now on standard output is passed on with this prefix to each line.
    fn start(prefix: String) -> io::Result<(Arc<Mutex<Relay>>, PipeWriter)> {
        let (reader, writer) = io::pipe()?;
        copy(&writer)?;
        let descriptor = reader.as_raw_fd();
        let relay = Arc::new(Mutex::new(Relay {
            reader,
            prefix,
            is_in_line: false,
            left: MAX_PRINTED,
        }));
        let own = relay.clone();
        let run = move || {
            while is_ready(descriptor, -1) && lock(&own).pass() {}
        };
        thread::Builder::new().spawn(run)?;
        Ok((relay, writer))
    }

    fn lock(relay: &Mutex<Relay>) -> MutexGuard<'_, Relay> {
        relay.lock().unwrap_or_else(PoisonError::into_inner)
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
