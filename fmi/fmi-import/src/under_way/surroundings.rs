//! What belongs to the process and is changed by some FMUs, to the harm of all others: working
//! folder, locale, standard streams, handlers and mask of signals. For `under_way`, which compares
//! it after the rare calls and every thousand steps, and puts it back.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_int};
use std::mem::zeroed;
use std::ptr;
use std::sync::OnceLock;

use libc::{PATH_MAX, sigaction, sigset_t};

use super::ending::is_own_program;
use super::signals;

/// Signals by which people and programs end a run.
const SIGNALS: [c_int; 4] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP, libc::SIGPIPE];
/// Copies of the standard streams, -1 where there is none.
static STREAMS: OnceLock<[c_int; 3]> = OnceLock::new();

thread_local! {
    static REMEMBERED: RefCell<Option<Surroundings>> = const { RefCell::new(None) };
}

struct Surroundings {
    folder: Option<CString>,
    locale: CString,
    mask: sigset_t,
    /// Only where the program is ours: in Python the main thread may set others meanwhile.
    handlers: Option<[sigaction; SIGNALS.len()]>,
}

/// What is there now is what FMUs that this thread calls must leave. For programs in which others
/// than FMUs change it too, before each sequence of calls.
pub fn remember() {
    // SAFETY: plain numbers.
    let copy = |stream| unsafe { libc::fcntl(stream, libc::F_DUPFD_CLOEXEC, 64) };
    STREAMS.get_or_init(|| [0, 1, 2].map(copy));
    // It fails only when the thread ends.
    let _ = REMEMBERED.try_with(|to| to.replace(Some(Surroundings::now())));
}

/// The same before an instance is freed, unless the program is ours: that may be long after the last
/// call, when others have changed it.
pub fn remember_late() {
    if !is_own_program() {
        remember();
    }
}

/// Puts back what was remembered; returns what was changed.
pub fn put_back() -> Vec<&'static str> {
    let compare =
        |to: &RefCell<Option<Surroundings>>| to.borrow().as_ref().map(Surroundings::put_back);
    let changed = REMEMBERED.try_with(compare).ok().flatten();
    changed.unwrap_or_default()
}

/// Sets the mask of signals, unless it is NULL; returns the one before.
fn mask(new: *const sigset_t) -> sigset_t {
    // SAFETY: NULL or a mask; all zeros is one.
    unsafe {
        let mut before = zeroed();
        libc::pthread_sigmask(libc::SIG_SETMASK, new, &mut before);
        before
    }
}

/// The working folder, in this place; None if it cannot be said. Nothing is allocated, since steps
/// look at it.
fn folder(place: &mut [u8; PATH_MAX as usize]) -> Option<&CStr> {
    // SAFETY: the place has this length.
    let found = unsafe { libc::getcwd(place.as_mut_ptr().cast(), place.len()) };
    match found.is_null() {
        true => None,
        false => CStr::from_bytes_until_nul(place).ok(),
    }
}

/// The name of the locale, until it is changed.
fn locale<'a>() -> &'a CStr {
    // SAFETY: NULL asks for the present one, a C string.
    unsafe { CStr::from_ptr(libc::setlocale(libc::LC_ALL, ptr::null())) }
}

fn handlers() -> Option<[sigaction; SIGNALS.len()]> {
    is_own_program().then(|| SIGNALS.map(signals::handler))
}

impl Surroundings {
    fn now() -> Self {
        Self {
            folder: folder(&mut [0; PATH_MAX as usize]).map(CStr::to_owned),
            locale: locale().to_owned(),
            mask: mask(ptr::null()),
            handlers: handlers(),
        }
    }

    fn put_back(&self) -> Vec<&'static str> {
        let mut changed = Vec::new();
        let place = &mut [0; PATH_MAX as usize];
        if let Some(own) = self.folder.as_deref()
            && folder(place) != Some(own)
            // SAFETY: a C string.
            && unsafe { libc::chdir(own.as_ptr()) } == 0
        {
            changed.push("the working folder");
        }
        if locale() != self.locale.as_c_str() {
            // SAFETY: a C string.
            unsafe { libc::setlocale(libc::LC_ALL, self.locale.as_ptr()) };
            changed.push("the locale");
        }
        // SAFETY: masks.
        let has = |set: &sigset_t, signal| unsafe { libc::sigismember(set, signal) };
        let now = mask(ptr::null());
        if (1..32).any(|signal| has(&now, signal) != has(&self.mask, signal)) {
            mask(&self.mask);
            changed.push("the mask of signals");
        }
        for ((signal, own), now) in SIGNALS
            .iter()
            .zip(self.handlers.iter().flatten())
            .zip(handlers().iter().flatten())
        {
            if own.sa_sigaction != now.sa_sigaction {
                // SAFETY: a handler that was there before.
                unsafe { libc::sigaction(*signal, own, ptr::null_mut()) };
                changed.push("the handlers of signals that end a program");
            }
        }
        signals::install();
        for (stream, copy) in (0..).zip(STREAMS.get().into_iter().flatten()) {
            // SAFETY: plain numbers.
            if unsafe {
                libc::fcntl(stream, libc::F_GETFD) == -1 && libc::dup2(*copy, stream) != -1
            } {
                changed.push("the standard streams, which it closed");
            }
        }
        changed.dedup();
        changed
    }
}
