//! Catches panics of a model for the C interface, which reports them; nothing is printed.
//!
//! The default panic hook prints to stderr before unwinding, so another one is installed, once. A
//! shared library written in Rust carries its own copy of the standard library, hence its own hook:
//! nothing of the importer is disturbed, and whatever panics there is the model. Where the border
//! is linked into a program with panics of its own (tests), the hook keeps silent only while the
//! panicking thread is inside [`catch`], and passes on to the previous hook otherwise. Neither the
//! hook nor the thread-local variables have a destructor, so that the library can be unloaded
//! without a leak.

use std::{
    any::Any,
    cell::Cell,
    panic::{self, AssertUnwindSafe, PanicHookInfo},
    ptr,
    sync::OnceLock,
    sync::atomic::{AtomicBool, Ordering},
};

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

/// What [`silence`] has installed.
static INSTALLED: OnceLock<Installed> = OnceLock::new();

struct Installed {
    previous: Hook,
    /// Is told of each panic before anything unwinds.
    tell: Option<fn(&str)>,
}

/// Whether other panics than those of the model can happen: threads then mark when they are inside
/// [`catch`]. In a shared library looking up a thread-local variable would take longer than most
/// calls.
static IN_PROGRAM: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// How often this thread is inside [`catch`]; kept in a program only.
    static INSIDE: Cell<u32> = const { Cell::new(0) };
    /// Where the last panic of this thread was, a `Box` until [`catch`] takes it; null if there is
    /// none.
    static PLACE: Cell<*mut String> = const { Cell::new(ptr::null_mut()) };
}

/// Installs the silent hook, which calls `tell` with the text of each panic; later calls do nothing.
pub(crate) fn silence(in_program: bool, tell: Option<fn(&str)>) {
    INSTALLED.get_or_init(|| {
        IN_PROGRAM.store(in_program, Ordering::Relaxed);
        let previous = panic::take_hook();
        panic::set_hook(Box::new(hook));
        Installed { previous, tell }
    });
}

fn hook(info: &PanicHookInfo<'_>) {
    let installed = INSTALLED.get();
    if let Some(tell) = installed.and_then(|installed| installed.tell) {
        tell(&info.to_string());
    }
    if IN_PROGRAM.load(Ordering::Relaxed) && INSIDE.get() == 0 {
        if let Some(installed) = installed {
            (installed.previous)(info);
        }
        return;
    }
    drop(place());
    if let Some(place) = info.location() {
        PLACE.set(Box::into_raw(Box::new(place.to_string())));
    }
}

/// Takes the place of the last panic of this thread.
fn place() -> Option<String> {
    let place = PLACE.replace(ptr::null_mut());
    // SAFETY: not null, so it came from `Box::into_raw`, and has been taken from the cell.
    (!place.is_null()).then(|| *unsafe { Box::from_raw(place) })
}

/// What a panic left. It has a place until the next one of its thread.
pub(crate) struct Panic(Box<dyn Any + Send>);

impl Panic {
    /// Its message and place.
    #[cold]
    pub(crate) fn describe(self) -> String {
        let place = place().unwrap_or_else(|| "unknown place".to_owned());
        format!("panic: {} ({place})", message(&*self.0))
    }
}

/// Runs `f`, which may panic.
#[inline]
pub(crate) fn catch<R>(f: impl FnOnce() -> R) -> Result<R, Panic> {
    if IN_PROGRAM.load(Ordering::Relaxed) {
        INSIDE.set(INSIDE.get() + 1);
    }
    let result = panic::catch_unwind(AssertUnwindSafe(f));
    if IN_PROGRAM.load(Ordering::Relaxed) {
        INSIDE.set(INSIDE.get() - 1);
    }
    result.map_err(Panic)
}

fn message(payload: &(dyn Any + Send)) -> &str {
    match (
        payload.downcast_ref::<&str>(),
        payload.downcast_ref::<String>(),
    ) {
        (Some(text), _) => text,
        (_, Some(text)) => text,
        _ => "without a message",
    }
}
