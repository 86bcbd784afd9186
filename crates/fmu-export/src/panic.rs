//! Panics stop at the C border and print nothing.
//!
//! The default panic hook prints to stderr before unwinding. So a hook is installed, once, that keeps silent while the
//! panicking thread is inside [`catch`] and passes on to the previous hook otherwise. A shared library written in Rust carries
//! its own copy of the standard library, hence its own hook: nothing of the importer is disturbed. Neither the hook nor the
//! thread-local variable owns memory or a destructor, so that the library can be unloaded without a leak.

use std::{
    any::Any,
    cell::Cell,
    panic::{self, AssertUnwindSafe, PanicHookInfo},
    ptr,
    sync::OnceLock,
};

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

static PREVIOUS: OnceLock<Hook> = OnceLock::new();

thread_local! {
    /// Where the hook writes the location of a panic; null outside [`catch`].
    static LOCATION: Cell<*mut Option<String>> = const { Cell::new(ptr::null_mut()) };
}

/// Installs the silent hook; later calls do nothing.
pub(crate) fn silence() {
    PREVIOUS.get_or_init(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(hook));
        previous
    });
}

fn hook(info: &PanicHookInfo<'_>) {
    let location = LOCATION.get();
    if !location.is_null() {
        // SAFETY: not null, so it points at the variable of the `catch` this thread is in.
        unsafe { *location = info.location().map(ToString::to_string) };
    } else if let Some(previous) = PREVIOUS.get() {
        previous(info);
    }
}

/// Runs `f`; a panic becomes its message and place.
pub(crate) fn catch<R>(f: impl FnOnce() -> R) -> Result<R, String> {
    let mut location = None;
    let outer = LOCATION.replace(&raw mut location);
    let result = panic::catch_unwind(AssertUnwindSafe(f));
    LOCATION.set(outer);
    result.map_err(|payload| {
        let place = location.unwrap_or_else(|| "unknown place".to_owned());
        format!("panic: {} ({place})", message(&*payload))
    })
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
