//! Messages to the importer's logger: what it wants to hear, and how FMI 2.0 wants it written.

use super::ffi::{CallbackFunctions, CallbackLogger, ComponentEnvironment, Status};
use crate::border::log::{ALL, Place, REFUSED, WARNING, c_string};
use crate::core::log::{Categories, Level, Wanted};
use crate::core::message::{Kind, Message};
use std::ffi::CString;

/// The importer's logger.
pub(crate) struct Logger {
    callback: Option<CallbackLogger>,
    environment: ComponentEnvironment,
    name: CString,
}

pub(crate) type Log = crate::border::log::Log<Logger>;

// SAFETY: the environment is handed to the importer's logger and not looked at. FMI lets threads take turns with an instance.
unsafe impl Send for Logger {}
// SAFETY: as above; everything is immutable.
unsafe impl Sync for Logger {}

/// The log of a new instance. Without `logging_on`, warnings and errors remain.
pub(crate) fn new(
    callbacks: &CallbackFunctions,
    name: &str,
    logging_on: bool,
    categories: Categories,
) -> Log {
    let logger = Logger {
        callback: callbacks.logger,
        environment: callbacks.component_environment,
        name: c_string(name),
    };
    let enabled = if logging_on { ALL } else { WARNING | REFUSED };
    Log::new(logger, categories, enabled)
}

impl Log {
    /// fmi2SetDebugLogging: all or only the named categories on; all or only the named ones off. Errors are always reported. Categories
    /// of the standard that no message has are accepted.
    pub(crate) fn set(&self, on: bool, categories: &[&str]) {
        let named = (categories.iter()).fold(0, |mask, name| mask | self.bits(name).unwrap_or(0));
        let enabled = match (on, categories) {
            (true, []) => ALL,
            (true, _) => named,
            (false, []) => 0,
            (false, _) => self.enabled() & !named,
        };
        self.enable(enabled | REFUSED);
    }

    /// What the importer wants to hear of the model. Warnings of all categories are warnings, too.
    pub(crate) fn wanted_of_model(&self) -> Wanted {
        let warning = match self.enabled() & WARNING {
            0 => self.wanted(WARNING),
            _ => u32::MAX,
        };
        match self.logger.callback {
            Some(_) => Wanted {
                info: self.wanted(crate::border::log::EVENT),
                warning,
            },
            None => Wanted {
                info: 0,
                warning: 0,
            },
        }
    }

    /// Sends messages that are wanted, one by one, until the logger frees the instance.
    ///
    /// No reference to the instance lives meanwhile. A C++ exception thrown by the logger unwinds through here, and nothing is left
    /// half done; leaving it by longjmp is not allowed.
    pub(crate) fn send(&self, messages: &[Message]) {
        let Some(callback) = self.logger.callback else {
            return;
        };
        for message in messages {
            let Place {
                own,
                standard,
                category,
            } = self.place(message);
            let (bits, status) = match message.kind {
                Kind::Event => (standard, Status::Ok),
                Kind::Model(Level::Info, _) if own != 0 => (own, Status::Ok),
                Kind::Model(Level::Info, _) => (standard, Status::Ok),
                Kind::Warning | Kind::Model(Level::Warning, _) => (own | standard, Status::Warning),
                Kind::Discarded => (standard, Status::Discard),
                Kind::Refused => (standard, Status::Error),
            };
            if self.enabled() & bits == 0 {
                continue;
            }
            let category = c_string(category);
            if self.is_closed() {
                return;
            }
            let text = c_string(&escaped(&message.text));
            // SAFETY: the importer's logger takes these C strings, which live until it returns; the format asks for no more.
            unsafe {
                callback(
                    self.logger.environment,
                    self.logger.name.as_ptr(),
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
