//! Messages to the importer.

use crate::failure::{Failure, refuse};
use crate::ffi::{CallbackFunctions, CallbackLogger, ComponentEnvironment, Status};
use libc::c_char;
use std::ffi::CString;

/// Category of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Category {
    Events = 1,
    Warning = 2,
    Discard = 4,
    Error = 8,
    Fatal = 16,
}

/// Every category: what fmi2SetDebugLogging may name, its bits, its description for the model description.
pub(crate) const CATEGORIES: [(&str, u8, &str); 6] = [
    ("logAll", ALL, "All messages"),
    (
        "logEvents",
        Category::Events as u8,
        "Life of the instance: initialization, reset, restored states",
    ),
    (
        "logStatusWarning",
        Category::Warning as u8,
        "Something is not quite right, the call succeeded",
    ),
    (
        "logStatusDiscard",
        Category::Discard as u8,
        "A step could not be done; the instance is as before",
    ),
    (
        "logStatusError",
        Category::Error as u8,
        "A wrong call; the instance is as before",
    ),
    (
        "logStatusFatal",
        Category::Fatal as u8,
        "The instance is lost",
    ),
];

const ALL: u8 = 31;

/// The importer's logger and what it wants to hear.
pub(crate) struct Log {
    callback: Option<CallbackLogger>,
    environment: ComponentEnvironment,
    name: CString,
    enabled: u8,
}

impl Log {
    /// `logging_on` adds the events; warnings and failures are reported until fmi2SetDebugLogging switches them off.
    pub(crate) fn new(callbacks: &CallbackFunctions, name: &str, logging_on: bool) -> Self {
        Self {
            callback: callbacks.logger,
            environment: callbacks.component_environment,
            name: c_string(name),
            enabled: if logging_on {
                ALL
            } else {
                ALL & !(Category::Events as u8)
            },
        }
    }

    /// fmi2SetDebugLogging: off, all, or only the named categories.
    pub(crate) fn set(&mut self, on: bool, categories: &[&str]) -> Result<(), Failure> {
        let mut enabled = 0;
        for category in categories {
            match CATEGORIES.iter().find(|(name, ..)| name == category) {
                Some((_, bits, _)) => enabled |= bits,
                None => {
                    let known = CATEGORIES.map(|(name, ..)| name).join(", ");
                    return refuse!("unknown log category `{category}`; allowed are {known}");
                }
            }
        }
        self.enabled = match (on, categories) {
            (false, _) => 0,
            (true, []) => ALL,
            (true, _) => enabled,
        };
        Ok(())
    }

    /// Sends a message, as the argument of the format `%s`.
    #[cold]
    pub(crate) fn send(&self, category: Category, message: &str) {
        let Some(callback) = self.callback else {
            return;
        };
        if self.enabled & category as u8 == 0 {
            return;
        }
        let (status, label) = match category {
            Category::Events => (Status::Ok, c"logEvents"),
            Category::Warning => (Status::Warning, c"logStatusWarning"),
            Category::Discard => (Status::Discard, c"logStatusDiscard"),
            Category::Error => (Status::Error, c"logStatusError"),
            Category::Fatal => (Status::Fatal, c"logStatusFatal"),
        };
        let text = c_string(message);
        let format: *const c_char = c"%s".as_ptr();
        // SAFETY: the importer's logger takes these C strings, which live until it returns, and one string for `%s`.
        unsafe {
            callback(
                self.environment,
                self.name.as_ptr(),
                status,
                label.as_ptr(),
                format,
                text.as_ptr(),
            );
        }
    }
}

/// A C string; a NUL inside the text becomes U+FFFD.
pub(crate) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).expect("no NUL is left")
}
