//! Messages to the importer's logger: what it wants to hear, and how FMI 2.0 wants it written.

use super::ffi::{CallbackFunctions, CallbackLogger, ComponentEnvironment, Status};
use crate::core::message::{Kind, Message};
use std::ffi::CString;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// Every category that is declared: its name, its bits, its description. Others of the standard are accepted and never used.
pub(crate) const CATEGORIES: [(&str, u8, &str); 5] = [
    ("logAll", ALL, "All messages"),
    (
        "logEvents",
        EVENT,
        "Life of the instance: initialization, reset, restored states",
    ),
    (
        "logStatusWarning",
        WARNING,
        "Something is not quite right, the call succeeded",
    ),
    (
        "logStatusDiscard",
        DISCARDED,
        "A value out of its bounds, or a step that could not be done; the instance is as before",
    ),
    (
        "logStatusError",
        REFUSED,
        "A wrong call (the instance is as before), or a panic of the model; never switched off",
    ),
];

const EVENT: u8 = 1;
const WARNING: u8 = 2;
const DISCARDED: u8 = 4;
const REFUSED: u8 = 8;
const ALL: u8 = 15;

/// The importer's logger and what it wants to hear.
pub(crate) struct Log {
    callback: Option<CallbackLogger>,
    environment: ComponentEnvironment,
    name: CString,
    enabled: AtomicU8,
    /// The instance is gone, and with it perhaps the importer's environment.
    is_closed: AtomicBool,
}

// SAFETY: the environment is handed to the importer's logger and not looked at. FMI lets threads take turns with an instance.
unsafe impl Send for Log {}
// SAFETY: as above; everything else is immutable or atomic.
unsafe impl Sync for Log {}

impl Log {
    /// Without `logging_on`, warnings and errors remain.
    pub(crate) fn new(callbacks: &CallbackFunctions, name: &str, logging_on: bool) -> Self {
        let enabled = if logging_on { ALL } else { WARNING | REFUSED };
        Self {
            callback: callbacks.logger,
            environment: callbacks.component_environment,
            name: c_string(name),
            enabled: AtomicU8::new(enabled),
            is_closed: AtomicBool::new(false),
        }
    }

    /// fmi2SetDebugLogging: all or only the named categories on; all or only the named ones off. Errors are always reported.
    pub(crate) fn set(&self, on: bool, categories: &[&str]) {
        let bits = |name: &&str| CATEGORIES.iter().find(|(known, ..)| known == name);
        let named = (categories.iter().filter_map(bits)).fold(0, |mask, (_, bits, _)| mask | bits);
        let enabled = match (on, categories) {
            (true, []) => ALL,
            (true, _) => named,
            (false, []) => 0,
            (false, _) => self.enabled.load(Ordering::Relaxed) & !named,
        };
        self.enabled.store(enabled | REFUSED, Ordering::Relaxed);
    }

    /// Nothing is sent any more.
    pub(crate) fn close(&self) {
        self.is_closed.store(true, Ordering::Relaxed);
    }

    /// Sends messages that are wanted, one by one, until the logger frees the instance.
    ///
    /// No reference to the instance lives meanwhile. A C++ exception thrown by the logger unwinds through here, and nothing is left
    /// half done; leaving it by longjmp is not allowed.
    pub(crate) fn send(&self, messages: &[Message]) {
        let Some(callback) = self.callback else {
            return;
        };
        for Message { kind, text } in messages {
            let (bit, status, category) = match kind {
                Kind::Event => (EVENT, Status::Ok, c"logEvents"),
                Kind::Warning => (WARNING, Status::Warning, c"logStatusWarning"),
                Kind::Discarded => (DISCARDED, Status::Discard, c"logStatusDiscard"),
                Kind::Refused => (REFUSED, Status::Error, c"logStatusError"),
            };
            if self.enabled.load(Ordering::Relaxed) & bit == 0 {
                continue;
            }
            if self.is_closed.load(Ordering::Relaxed) {
                return;
            }
            let text = c_string(&escaped(text));
            // SAFETY: the importer's logger takes these C strings, which live until it returns; the format asks for no more.
            unsafe {
                callback(
                    self.environment,
                    self.name.as_ptr(),
                    status,
                    category.as_ptr(),
                    text.as_ptr(),
                );
            }
        }
    }
}

/// Text as a format of `printf` without arguments, in which `#` would begin the name of a variable (FMI 2.0.4, section 2.1.5).
fn escaped(text: &str) -> String {
    text.replace('%', "%%").replace('#', "##")
}

/// A C string; a NUL inside the text becomes U+FFFD.
pub(crate) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).expect("no NUL is left")
}
