//! The importer's logger of FMI 2.0: what it hears at first, how categories are switched, how a
//! message is written.

use super::ffi::{CallbackFunctions, CallbackLogger, ComponentEnvironment, Status};
use crate::c_api::answer::Answer;
use crate::c_api::log::{self, ALL, REFUSED, WARNING, c_string};
use crate::core::log::Categories;
use crate::core::message::{Kind, Level};
use std::ffi::{CStr, CString};

/// The importer's logger.
pub(crate) struct Logger {
    callback: Option<CallbackLogger>,
    environment: ComponentEnvironment,
    name: CString,
}

pub(crate) type Log = log::Log<Logger>;

// SAFETY: the environment is handed to the importer's logger and not looked at. FMI lets threads
// take turns with an instance.
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

/// fmi2SetDebugLogging: all or only the named categories on; all or only the named ones off. Errors
/// are always reported. Categories of the standard that no message has are accepted.
pub(crate) fn switch_categories(log: &Log, on: bool, categories: &[&str]) -> u32 {
    let named = (categories.iter()).fold(0, |mask, name| mask | log.bits(name).unwrap_or(0));
    let enabled = match (on, categories) {
        (true, []) => ALL,
        (true, _) => named,
        (false, []) => 0,
        (false, _) => log.enabled() & !named,
    };
    enabled | REFUSED
}

impl log::Logger for Logger {
    type Status = Status;
    const WARNINGS_INCLUDE_MODEL: bool = true;

    fn is_available(&self) -> bool {
        self.callback.is_some()
    }

    /// Each kind has its own, whatever the call is answered with.
    fn status(kind: Kind, _answer: Answer) -> Status {
        match kind {
            Kind::Event | Kind::Model(Level::Info, _) => Status::Ok,
            Kind::Warning | Kind::Model(Level::Warning, _) => Status::Warning,
            Kind::Discarded => Status::Discard,
            Kind::Refused => Status::Error,
        }
    }

    fn log(&self, status: Status, category: &CStr, text: &str) {
        let Some(callback) = self.callback else {
            return;
        };
        let text = c_string(&escaped(text));
        // SAFETY: the importer's logger takes these C strings, which live until it returns; the
        // format asks for no more.
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

/// Text as a format of `printf` without arguments, in which `#` would begin the name of a variable
/// (FMI 2.0.4, section 2.1.5).
fn escaped(text: &str) -> String {
    text.replace('%', "%%").replace('#', "##")
}
