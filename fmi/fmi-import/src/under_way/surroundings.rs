//! What belongs to the process and is changed by some FMUs, to the harm of all others: working
//! folder, locale, standard streams, handlers and mask of signals. For `under_way`, which compares
//! it after the rare calls and every thousand steps, and puts it back.

use std::cell::RefCell;
use std::env;
use std::path::PathBuf;

thread_local! {
    static REMEMBERED: RefCell<Option<Surroundings>> = const { RefCell::new(None) };
}

struct Surroundings {
    folder: Option<PathBuf>,
    #[cfg(unix)]
    own: unix::Own,
}

/// What is there now is what FMUs that this thread calls must leave. For programs in which others
/// than FMUs change it too, before each sequence of calls.
pub fn remember() {
    let now = Surroundings {
        folder: env::current_dir().ok(),
        #[cfg(unix)]
        own: unix::Own::now(),
    };
    // It fails only when the thread ends.
    let _ = REMEMBERED.try_with(|to| to.replace(Some(now)));
}

/// Puts back what was remembered; returns what was changed.
pub fn put_back() -> Vec<&'static str> {
    let compare = |remembered: &RefCell<Option<Surroundings>>| {
        let remembered = remembered.borrow();
        remembered.as_ref().map_or_else(Vec::new, Surroundings::put_back)
    };
    REMEMBERED.try_with(compare).unwrap_or_default()
}

impl Surroundings {
    fn put_back(&self) -> Vec<&'static str> {
        let mut changed = Vec::new();
        if let Some(folder) = &self.folder
            && env::current_dir().ok().as_ref() != Some(folder)
            && env::set_current_dir(folder).is_ok()
        {
            changed.push("the working folder");
        }
        #[cfg(unix)]
        self.own.put_back(&mut changed);
        changed
    }
}

#[cfg(unix)]
mod unix {
    use std::ffi::{CStr, CString, c_int};
    use std::mem::MaybeUninit;
    use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
    use std::ptr;
    use std::sync::OnceLock;

    use libc::{sigaction, sigset_t};

    use crate::output;
    use crate::under_way::signals;

    /// Signals by which people and programs end a run.
    const SIGNALS: [c_int; 4] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP, libc::SIGPIPE];
    /// Copies of the standard streams.
    static STREAMS: OnceLock<[Option<OwnedFd>; 3]> = OnceLock::new();

    /// What only Unix has.
    pub struct Own {
        locale: CString,
        mask: sigset_t,
        /// Only where the program is ours: in Python the main thread may set others meanwhile.
        handlers: Option<[sigaction; SIGNALS.len()]>,
    }

    fn locale() -> CString {
        // SAFETY: NULL asks for the present one, a C string.
        unsafe { CStr::from_ptr(libc::setlocale(libc::LC_ALL, ptr::null())) }.to_owned()
    }

    fn mask() -> sigset_t {
        let mut mask = MaybeUninit::zeroed();
        // SAFETY: NULL asks for the present mask; all zeros is a mask.
        unsafe {
            libc::pthread_sigmask(libc::SIG_SETMASK, ptr::null(), mask.as_mut_ptr());
            mask.assume_init()
        }
    }

    fn differ(a: &sigset_t, b: &sigset_t) -> bool {
        // SAFETY: masks.
        let has = |mask, signal| unsafe { libc::sigismember(mask, signal) };
        (1..32).any(|signal| has(a, signal) != has(b, signal))
    }

    impl Own {
        pub fn now() -> Self {
            STREAMS.get_or_init(|| {
                [0, 1, 2].map(|stream| {
                    // SAFETY: a new descriptor, which nobody else closes.
                    let copy = unsafe { libc::fcntl(stream, libc::F_DUPFD_CLOEXEC, 64) };
                    (copy != -1).then(|| unsafe { OwnedFd::from_raw_fd(copy) })
                })
            });
            Self {
                locale: locale(),
                mask: mask(),
                handlers: output::is_separate().then(|| SIGNALS.map(signals::handler)),
            }
        }

        pub fn put_back(&self, changed: &mut Vec<&'static str>) {
            if locale() != self.locale {
                // SAFETY: a C string.
                unsafe { libc::setlocale(libc::LC_ALL, self.locale.as_ptr()) };
                changed.push("the locale");
            }
            if differ(&mask(), &self.mask) {
                // SAFETY: a mask that this thread had.
                unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, &self.mask, ptr::null_mut()) };
                changed.push("the mask of signals");
            }
            let handlers = self.handlers.iter().flatten();
            let differs = |(signal, own): &(c_int, &sigaction)| {
                signals::handler(*signal).sa_sigaction != own.sa_sigaction
            };
            let others = SIGNALS.into_iter().zip(handlers).filter(differs);
            let put = |(signal, own): (c_int, &sigaction)| {
                // SAFETY: a handler that was there before.
                unsafe { libc::sigaction(signal, own, ptr::null_mut()) };
            };
            if others.map(put).count() > 0 {
                changed.push("the handlers of signals that end a program");
            }
            signals::install_again();
            let streams = STREAMS.get().into_iter().flatten();
            for (stream, copy) in (0..).zip(streams) {
                // SAFETY: plain numbers.
                let is_closed = unsafe { libc::fcntl(stream, libc::F_GETFD) } == -1;
                if let Some(copy) = copy.as_ref().filter(|_| is_closed) {
                    // SAFETY: plain numbers.
                    unsafe { libc::dup2(copy.as_raw_fd(), stream) };
                    changed.push("the standard streams, which it closed");
                }
            }
            changed.dedup();
        }
    }
}
