//! The loggers that instances of every kind pass to FMUs. A message goes to the [`Log`] of its
//! instance, which keeps it or adds it to the messages of this thread ([`messages`]).
//!
//! The environment that an FMU passes to the logger is a number that is looked up, never a pointer
//! that is followed, since some FMUs pass another one than they were given.
//!
//! ```
//! let log = fmi_import::log::Log::new("my instance");
//! assert!(log.take().is_empty());
//! ```

use std::collections::BTreeMap;
use std::ffi::{c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};

use crate::calls::Callbacks;
use crate::functions::Functions;
use crate::messages;
use crate::standard::{Pointer, Text};
use crate::text::read_or_explain;

/// A message as the logger received it.
#[derive(Clone, Debug)]
pub struct Message {
    /// Name of the instance that the FMU says it comes from.
    pub instance: String,
    /// Status.
    pub status: c_int,
    /// Category.
    pub category: String,
    /// The text as received: in FMI 2.0 a printf format, whose arguments are not read.
    pub format: String,
    /// It is plain text, not a format (FMI 3.0).
    pub is_plain: bool,
    /// It came with an environment that no instance was given.
    pub is_stray: bool,
}

impl Message {
    /// Its text, in which the `%%` and `##` of a format are `%` and `#`.
    #[must_use]
    pub fn text(&self) -> String {
        match self.is_plain {
            true => self.format.clone(),
            false => self.format.replace("%%", "%").replace("##", "#"),
        }
    }
}

/// How many messages an instance keeps that keeps them as received; further ones are dropped.
const MAX_KEPT: usize = 10_000;

/// Receives the messages of a live instance, or those without a known instance.
struct Listener {
    /// Name of the instance, which FMI 3.0 does not pass to the logger.
    name: String,
    /// Its messages; None if they are added to those of the thread.
    own: Option<Vec<Message>>,
    /// The thread that calls it.
    thread: ThreadId,
    /// Its functions, which know the names of variables.
    functions: Option<Arc<Functions>>,
}

impl Listener {
    fn new(name: &str, own: Option<Vec<Message>>) -> Self {
        Self {
            name: name.to_string(),
            own,
            thread: thread::current().id(),
            functions: None,
        }
    }
}

/// A listener for each live instance, by the number that is its environment. Under [`STRAY`], once
/// an instance keeps its messages, the messages that came with an unknown environment.
static LISTENERS: Mutex<BTreeMap<usize, Listener>> = Mutex::new(BTreeMap::new());

/// The environment of no instance: NULL.
const STRAY: usize = 0;

fn listeners() -> MutexGuard<'static, BTreeMap<usize, Listener>> {
    LISTENERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Connects an instance to the logger, for as long as this lives.
#[derive(Debug)]
pub struct Log {
    environment: usize,
    is_of_thread: bool,
}

impl Log {
    /// For an instance that keeps its messages: as received, formats without their arguments.
    pub fn new(name: &str) -> Self {
        let stray = || Listener::new("", Some(Vec::new()));
        listeners().entry(STRAY).or_insert_with(stray);
        Self::with(name, Some(Vec::new()))
    }

    /// For an instance whose messages are added to those of the thread that calls it, with their
    /// arguments.
    pub fn for_thread(name: &str) -> Self {
        Self::with(name, None)
    }

    fn with(name: &str, own: Option<Vec<Message>>) -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(STRAY + 1);
        let environment = NEXT.fetch_add(1, Ordering::Relaxed);
        let is_of_thread = own.is_none();
        listeners().insert(environment, Listener::new(name, own));
        Self {
            environment,
            is_of_thread,
        }
    }

    /// Has references to variables in its messages replaced by their names.
    pub(crate) fn name_variables(&self, functions: &Arc<Functions>) {
        if let Some(listener) = listeners().get_mut(&self.environment) {
            listener.functions = Some(functions.clone());
        }
    }

    /// Callbacks with a logger for this instance, without memory functions.
    pub fn callbacks(&self) -> Callbacks {
        Callbacks {
            logger: match self.is_of_thread {
                #[cfg(feature = "printf")]
                true => fmi_import_logger as *const c_void,
                _ => logger as *const c_void,
            },
            allocate_memory: None,
            free_memory: None,
            step_finished: ptr::null(),
            environment: ptr::without_provenance_mut(self.environment),
        }
    }

    /// Messages since the last call of this function, and those that came with an unknown
    /// environment.
    pub fn take(&self) -> Vec<Message> {
        let mut messages = self.take_own();
        messages.extend(take(STRAY));
        messages
    }

    /// Messages since the last call of this function.
    pub fn take_own(&self) -> Vec<Message> {
        take(self.environment)
    }
}

fn take(environment: usize) -> Vec<Message> {
    let mut listeners = listeners();
    let own = listeners.get_mut(&environment);
    let own = own.and_then(|listener| listener.own.as_mut());
    own.map_or_else(Vec::new, std::mem::take)
}

impl Drop for Log {
    fn drop(&mut self) {
        listeners().remove(&self.environment);
    }
}

/// Adds a text of the instance with this environment to the messages of the thread that calls it.
pub fn receive(environment: usize, status: c_int, text: &str) {
    let listeners = listeners();
    let listener = listeners.get(&environment);
    let (name, thread) = match listener {
        Some(listener) => (listener.name.clone(), listener.thread),
        None => (messages::NOBODY.to_string(), thread::current().id()),
    };
    let functions = listener.and_then(|listener| listener.functions.clone());
    drop(listeners);
    let text = match functions {
        Some(functions) if !functions.is_fmi3() => with_names(text, &functions),
        _ => text.to_string(),
    };
    messages::add_for(thread, &name, status, text.trim_end());
}

/// A text of FMI 2.0 in which `#r123#` is the name of the Real with this reference, and `##` is `#`.
fn with_names(text: &str, functions: &Functions) -> String {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once('#') {
        out += before;
        let marked = after.split_once('#').and_then(|(mark, after)| match mark {
            "" => Some(("#", after)),
            _ => functions.name_of_mark(mark).map(|name| (name, after)),
        });
        let (put, after) = marked.unwrap_or(("#", after));
        out += put;
        rest = after;
    }
    out + rest
}

/// Hands a message to its listener; `name` is None in FMI 3.0, which does not pass it.
///
/// # Safety
/// What the FMU says are C strings.
unsafe fn record(
    environment: Pointer,
    name: Option<Text>,
    status: c_int,
    [category, format]: [Text; 2],
) {
    // SAFETY: as the caller promises.
    let [category, format] = unsafe { [category, format].map(|text| read_or_explain(text)) };
    // SAFETY: the same.
    let name = name.map(|name| unsafe { read_or_explain(name) });
    let mut listeners = listeners();
    let environment = environment.addr();
    let is_known = environment != STRAY && listeners.contains_key(&environment);
    let listener = listeners.get_mut(&if is_known { environment } else { STRAY });
    let (own, known) = listener.map_or((None, ""), |l| (l.own.as_mut(), &l.name));
    let message = Message {
        is_plain: name.is_none(),
        instance: name.unwrap_or_else(|| known.to_string()),
        status,
        category,
        format,
        is_stray: !is_known,
    };
    match own {
        Some(own) if own.len() < MAX_KEPT => own.push(message),
        Some(_) => {}
        None if message.format.is_empty() => {}
        None => {
            drop(listeners);
            receive(environment, status, &message.text());
        }
    }
}

/// The logger of FMI 3.0.
pub(crate) unsafe extern "C" fn logger_3(
    environment: Pointer,
    status: c_int,
    category: Text,
    message: Text,
) {
    // SAFETY: what the FMU says are C strings.
    unsafe { record(environment, None, status, [category, message]) }
}

/// The logger of FMI 2.0, which does not read the arguments of the format. FMI declares it
/// variadic; a variadic call with pointers and integers equals a plain one on Linux (x86-64,
/// aarch64) and Windows, but not on Apple silicon.
unsafe extern "C" fn logger(
    environment: Pointer,
    name: Text,
    status: c_int,
    category: Text,
    format: Text,
) {
    // SAFETY: what the FMU says are C strings.
    unsafe { record(environment, Some(name), status, [category, format]) }
}

#[cfg(feature = "printf")]
unsafe extern "C" {
    /// The logger of FMI 2.0 that formats messages, in logger.c: stable Rust cannot define a
    /// variadic function.
    fn fmi_import_logger(
        environment: Pointer,
        instance: Text,
        status: c_int,
        category: Text,
        message: Text,
        ...
    );
}

/// `logger.c` calls this with the formatted text.
#[cfg(feature = "printf")]
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi_import_receive(environment: Pointer, status: c_int, text: Text) {
    // SAFETY: a C string of the logger's own.
    let text = unsafe { std::ffi::CStr::from_ptr(text) };
    receive(environment.addr(), status, &text.to_string_lossy());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The logger is called with the environment of an instance, with one that nobody has, with
    /// NULL, and with that of an instance that is gone.
    #[test]
    fn an_environment_of_nobody_is_not_followed() {
        let [log, gone] = ["own", "gone"].map(Log::new);
        let own = log.callbacks().environment;
        let old = gone.callbacks().environment;
        drop(gone);
        let (category, text) = (c"logEvents".as_ptr(), c"hello".as_ptr());
        let wrong: Pointer = ptr::without_provenance_mut(0xdead_beef);
        for environment in [own, wrong, ptr::null_mut(), old] {
            // SAFETY: C strings.
            unsafe {
                logger(environment, c"X".as_ptr(), 0, category, text);
                logger_3(environment, 0, category, text);
            }
        }
        let messages = log.take();
        let of = |m: &Message| (m.instance.clone(), m.is_stray);
        let told: Vec<_> = messages.iter().map(of).collect();
        let expected = [("X", false), ("own", false)].into_iter();
        let expected = expected.chain([("X", true), ("", true)].repeat(3));
        let expected: Vec<_> = expected.map(|(n, stray)| (n.to_string(), stray)).collect();
        assert_eq!(told, expected);
        assert!(log.take().is_empty());
    }
}
