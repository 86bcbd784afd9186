//! What an FMU says to its importer's logger. The environment that it passes is trusted only if it
//! is that of a live log: some FMUs call the logger with another one.

use std::collections::BTreeMap;
use std::ffi::{c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::calls::Callbacks;

use super::symbols::{Pointer, Text};
use super::text::shown;

/// A message as the logger got it.
#[derive(Clone, Debug)]
pub struct Message {
    /// Instance that it is said to come from.
    pub instance: String,
    /// Status.
    pub status: c_int,
    /// Category.
    pub category: String,
    /// As it came: in FMI 2.0 a printf format whose arguments are not looked at.
    pub format: String,
    /// A text, in which nothing is doubled (FMI 3.0).
    pub is_plain: bool,
    /// It came with another environment than the one that was given to an instance.
    pub is_stray: bool,
}

impl Message {
    /// What it prints: `%` and `#` stand doubled in the format.
    #[must_use]
    pub fn text(&self) -> String {
        match self.is_plain {
            true => self.format.clone(),
            false => self.format.replace("%%", "%").replace("##", "#"),
        }
    }
}

/// What came with one environment.
#[derive(Default)]
struct Journal {
    /// Name of the instance, which a logger of FMI 3.0 is not told.
    name: String,
    messages: Vec<Message>,
}

/// What all live logs have heard, by the number that is their environment; under [`STRAY`] what
/// came with another one.
static HEARD: Mutex<BTreeMap<usize, Journal>> = Mutex::new(BTreeMap::new());

/// The environment of nobody: NULL.
const STRAY: usize = 0;

fn heard() -> MutexGuard<'static, BTreeMap<usize, Journal>> {
    HEARD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The messages of an instance.
#[derive(Debug)]
pub struct Log {
    environment: usize,
}

impl Log {
    /// Of the instance with this name.
    pub fn new(name: &str) -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(STRAY + 1);
        let environment = NEXT.fetch_add(1, Ordering::Relaxed);
        let own = Journal {
            name: name.to_string(),
            messages: Vec::new(),
        };
        heard().insert(environment, own);
        Self { environment }
    }

    /// Callbacks whose logger writes here, without memory functions.
    pub fn callbacks(&self) -> Callbacks {
        Callbacks {
            logger: logger as *const c_void,
            allocate_memory: None,
            free_memory: None,
            step_finished: ptr::null(),
            environment: ptr::without_provenance_mut(self.environment),
        }
    }

    /// Messages since the last call of this function; with them those that came with the
    /// environment of nobody.
    pub fn take(&self) -> Vec<Message> {
        let mut messages = self.take_own();
        messages.extend(take(STRAY));
        messages
    }

    /// The same without those that came with the environment of nobody.
    pub fn take_own(&self) -> Vec<Message> {
        take(self.environment)
    }
}

fn take(environment: usize) -> Vec<Message> {
    let mut heard = heard();
    let heard = heard.get_mut(&environment);
    heard.map_or_else(Vec::new, |heard| std::mem::take(&mut heard.messages))
}

impl Drop for Log {
    fn drop(&mut self) {
        heard().remove(&self.environment);
    }
}

fn note(environment: Pointer, message: Message) {
    let mut heard = heard();
    let known = Some(environment.addr()).filter(|e| heard.contains_key(e) && *e != STRAY);
    let heard = heard.entry(known.unwrap_or(STRAY)).or_default();
    let instance = match message.is_plain {
        true => heard.name.clone(),
        false => message.instance,
    };
    heard.messages.push(Message {
        instance,
        is_stray: known.is_none(),
        ..message
    });
}

/// The logger of FMI 3.0, which does not say which instance speaks; a message is a text, which has
/// nothing doubled.
pub(super) unsafe extern "C" fn logger_3(
    environment: Pointer,
    status: c_int,
    category: Text,
    message: Text,
) {
    // SAFETY: what the FMU says are C strings.
    let [category, format] = unsafe { [category, message].map(|text| shown(text)) };
    let message = Message {
        instance: String::new(),
        status,
        category,
        format,
        is_plain: true,
        is_stray: false,
    };
    note(environment, message);
}

/// FMI declares it variadic; this one does not look at the arguments of the format, and a variadic
/// call with pointers and integers equals a plain one on Linux (x86-64, aarch64) and Windows; not
/// on Apple silicon.
unsafe extern "C" fn logger(
    environment: Pointer,
    name: Text,
    status: c_int,
    category: Text,
    format: Text,
) {
    // SAFETY: what the FMU says are C strings.
    let [instance, category, format] = unsafe { [name, category, format].map(|text| shown(text)) };
    let message = Message {
        instance,
        status,
        category,
        format,
        is_plain: false,
        is_stray: false,
    };
    note(environment, message);
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
