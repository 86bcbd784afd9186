//! Messages to the importer's logger: what it wants to hear, and how FMI 2.0 wants it written.

use super::ffi::{CallbackFunctions, CallbackLogger, ComponentEnvironment, Status};
use crate::core::log::{Categories, Level, STANDARD, Wanted, number};
use crate::core::message::{Kind, Message};
use std::ffi::CString;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Every category that each FMU declares: its name, its bits, its description. Those of the model come after them. Others of the
/// standard are accepted and never used.
pub(crate) const CATEGORIES: [(&str, u32, &str); 5] = [
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

const EVENT: u32 = 1;
const WARNING: u32 = 2;
const DISCARDED: u32 = 4;
const REFUSED: u32 = 8;
const ALL: u32 = u32::MAX;
/// Number of the bit of the model's first category.
const FIRST: usize = 4;

/// The importer's logger and what it wants to hear.
pub(crate) struct Log {
    callback: Option<CallbackLogger>,
    environment: ComponentEnvironment,
    name: CString,
    /// The model's own.
    categories: Categories,
    enabled: AtomicU32,
    /// The instance is gone, and with it perhaps the importer's environment.
    is_closed: AtomicBool,
}

// SAFETY: the environment is handed to the importer's logger and not looked at. FMI lets threads take turns with an instance.
unsafe impl Send for Log {}
// SAFETY: as above; everything else is immutable or atomic.
unsafe impl Sync for Log {}

impl Log {
    /// Without `logging_on`, warnings and errors remain.
    pub(crate) fn new(
        callbacks: &CallbackFunctions,
        name: &str,
        logging_on: bool,
        categories: Categories,
    ) -> Self {
        let enabled = if logging_on { ALL } else { WARNING | REFUSED };
        Self {
            callback: callbacks.logger,
            environment: callbacks.component_environment,
            name: c_string(name),
            categories,
            enabled: AtomicU32::new(enabled),
            is_closed: AtomicBool::new(false),
        }
    }

    /// fmi2SetDebugLogging: all or only the named categories on; all or only the named ones off. Errors are always reported.
    pub(crate) fn set(&self, on: bool, categories: &[&str]) {
        let named = (categories.iter()).fold(0, |mask, name| mask | self.bits(name));
        let enabled = match (on, categories) {
            (true, []) => ALL,
            (true, _) => named,
            (false, []) => 0,
            (false, _) => self.enabled.load(Ordering::Relaxed) & !named,
        };
        self.enabled.store(enabled | REFUSED, Ordering::Relaxed);
    }

    /// The bits of a category; none if it is neither declared by each FMU nor one of the model's.
    fn bits(&self, name: &str) -> u32 {
        let declared = CATEGORIES.iter().find(|(known, ..)| *known == name);
        match (declared, number(self.categories, name)) {
            (Some((_, bits, _)), _) => *bits,
            (None, STANDARD) => 0,
            (None, k) => 1 << (FIRST + k),
        }
    }

    /// What the importer wants to hear of the model.
    pub(crate) fn wanted(&self) -> Wanted {
        let enabled = self.enabled.load(Ordering::Relaxed);
        let with_standard = |bit: u32| enabled >> FIRST | u32::from(enabled & bit != 0) << STANDARD;
        match (self.callback, enabled & WARNING != 0) {
            (None, _) => Wanted {
                info: 0,
                warning: 0,
            },
            (_, true) => Wanted {
                info: with_standard(EVENT),
                warning: u32::MAX,
            },
            (_, false) => Wanted {
                info: with_standard(EVENT),
                warning: with_standard(WARNING),
            },
        }
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
            let (bits, status, category) = match kind {
                Kind::Event => (EVENT, Status::Ok, "logEvents"),
                Kind::Warning => (WARNING, Status::Warning, "logStatusWarning"),
                Kind::Discarded => (DISCARDED, Status::Discard, "logStatusDiscard"),
                Kind::Refused => (REFUSED, Status::Error, "logStatusError"),
                Kind::Model(level, name) => self.of_model(*level, name),
            };
            if self.enabled.load(Ordering::Relaxed) & bits == 0 {
                continue;
            }
            let category = c_string(category);
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

impl Log {
    /// The bits of which one must be on for a message of the model, its status and its category. Warnings of all categories are
    /// warnings, too.
    fn of_model(&self, level: Level, name: &'static str) -> (u32, Status, &'static str) {
        let own = match number(self.categories, name) {
            STANDARD => None,
            k => Some(1 << (FIRST + k)),
        };
        match (level, own) {
            (Level::Info, Some(bit)) => (bit, Status::Ok, name),
            (Level::Info, None) => (EVENT, Status::Ok, "logEvents"),
            (Level::Warning, Some(bit)) => (bit | WARNING, Status::Warning, name),
            (Level::Warning, None) => (WARNING, Status::Warning, "logStatusWarning"),
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
