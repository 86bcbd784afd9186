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

pub use own::{drain, is_separate, named, separate};

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

    /// The most bytes that are passed on of what a library prints while it is loaded or instantiated,
    /// and of what all print otherwise.
    const MAX_PRINTED: usize = 1 << 20;

    /// The standard output that the program was started with.
    static OWN: OnceLock<File> = OnceLock::new();
    /// What passes on what is printed while no output is captured, and where it is printed to.
    static PRINTED: OnceLock<(Arc<Relay>, PipeWriter)> = OnceLock::new();
    /// Held while the output of a call is captured.
    static CAPTURING: Mutex<()> = Mutex::new(());

    pub fn stdout() -> Option<&'static File> {
        OWN.get()
    }

    /// Whether outputs are separate: the process is a program of ours.
    pub fn is_separate() -> bool {
        OWN.get().is_some()
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
        let _ = OWN.set(unsafe { File::from_raw_fd(own) });
        let _ = PRINTED.set(Relay::start(String::new())?);
        Ok(())
    }

    /// Calls a function that may print. If outputs are separate, its lines are printed with the
    /// name `who`.
    pub fn named<T>(who: &str, call: impl FnOnce() -> T) -> T {
        let (Some((_, usual)), Ok(_guard)) = (PRINTED.get(), CAPTURING.lock()) else {
            return call();
        };
        drain();
        let Ok((relay, writer)) = Relay::start(format!("{who} prints: ")) else {
            return call();
        };
        drop(writer);
        let result = call();
        flush();
        // If this fails, the library has closed what it had no right to.
        let _ = copy(usual);
        relay.pass_all();
        relay.lock().end_line();
        result
    }

    /// Passes on what was printed up to now.
    pub fn drain() {
        if let Some((relay, _)) = PRINTED.get() {
            flush();
            relay.pass_all();
        }
    }

    /// Passes on to standard error what is printed to standard output. Its thread ends once nobody
    /// has the other end of the pipe any more: processes that an FMU has started may keep it.
    struct Relay {
        printed: Mutex<Printed>,
        reader: i32,
    }

    struct Printed {
        reader: PipeReader,
        /// What each line begins with.
        prefix: String,
        is_in_line: bool,
        left: usize,
    }

    impl Relay {
        /// From now on standard output is passed on with this prefix to each line.
        fn start(prefix: String) -> io::Result<(Arc<Self>, PipeWriter)> {
            let (reader, writer) = io::pipe()?;
            copy(&writer)?;
            let relay = Arc::new(Self {
                reader: reader.as_raw_fd(),
                printed: Mutex::new(Printed {
                    reader,
                    prefix,
                    is_in_line: false,
                    left: MAX_PRINTED,
                }),
            });
            let own = relay.clone();
            thread::Builder::new().spawn(move || while own.pass(-1) {})?;
            Ok((relay, writer))
        }

        fn lock(&self) -> MutexGuard<'_, Printed> {
            self.printed.lock().unwrap_or_else(PoisonError::into_inner)
        }

        /// Passes on what comes within `wait`, ms; -1 waits until something comes. False if nothing
        /// has come.
        fn pass(&self, wait: i32) -> bool {
            let mut poll = libc::pollfd {
                fd: self.reader,
                events: libc::POLLIN,
                revents: 0,
            };
            // SAFETY: one descriptor, which stays open.
            unsafe { libc::poll(&mut poll, 1, wait) };
            let mut printed = self.lock();
            poll.revents = 0;
            // SAFETY: as above. The other thread may have read it meanwhile.
            match unsafe { libc::poll(&mut poll, 1, 0) } {
                1 => printed.pass(),
                _ => wait != 0,
            }
        }

        fn pass_all(&self) {
            while self.pass(0) {}
        }
    }

    impl Printed {
        /// Passes on what there is; false at the end of the pipe.
        fn pass(&mut self) -> bool {
            let mut bytes = [0; 4096];
            let Ok(count @ 1..) = self.reader.read(&mut bytes) else {
                return false;
            };
            let mut text = String::new();
            for line in String::from_utf8_lossy(&bytes[..count.min(self.left)]).split_inclusive('\n') {
                if !self.is_in_line {
                    text += &self.prefix;
                }
                text += line;
                self.is_in_line = !line.ends_with('\n');
            }
            if self.left > 0 && count >= self.left {
                text += "\n(FMUs print more than 1 MiB; the rest is not shown)\n";
            }
            self.left = self.left.saturating_sub(count);
            self.is_in_line &= self.left > 0;
            // If this fails, there is no standard error.
            let _ = io::stderr().write_all(text.as_bytes());
            true
        }

        fn end_line(&mut self) {
            if std::mem::take(&mut self.is_in_line) {
                eprintln!();
            }
        }
    }
}

#[cfg(not(all(unix, feature = "native")))]
mod own {
    use std::{fs::File, io};

    pub fn stdout() -> Option<&'static File> {
        None
    }

    /// They are not.
    pub fn is_separate() -> bool {
        false
    }

    /// Does nothing.
    pub fn drain() {}

    /// Does nothing here, where FMUs cannot print.
    pub fn separate() -> io::Result<()> {
        Ok(())
    }

    /// Calls the function.
    pub fn named<T>(_: &str, call: impl FnOnce() -> T) -> T {
        call()
    }
}
