//! Logging in FMI 2.0, for all its functions: fmi2SetDebugLogging and the importer's logger.

use super::ffi::{Boolean, CallbackFunctions, CallbackLogger, ComponentEnvironment, Status};
use crate::Model;
use crate::c_api::log::{self, ALL, REFUSED, WARNING, c_string};
use crate::core::fault::Fault;
use crate::core::message::{Kind, Level};
use std::ffi::{CStr, CString};

/// The importer's logger.
pub(crate) struct Logger {
    callback: Option<CallbackLogger>,
    environment: ComponentEnvironment,
    name: CString,
}

pub(crate) type Log = log::Log<Logger>;

// SAFETY: the environment is only passed on to the logger; FMI lets threads take turns.
unsafe impl Send for Logger {}
// SAFETY: as above; everything is immutable.
unsafe impl Sync for Logger {}

/// The log of a new instance. Without `logging_on`, warnings and errors remain.
pub(crate) fn new<M: Model>(callbacks: &CallbackFunctions, name: &str, logging_on: Boolean) -> Log {
    let logger = Logger {
        callback: callbacks.logger,
        environment: callbacks.component_environment,
        name: c_string(name),
    };
    let enabled = if logging_on != 0 {
        ALL
    } else {
        WARNING | REFUSED
    };
    Log::new(logger, M::INFO.log_categories, enabled)
}

impl log::Logger for Logger {
    const WARNINGS_INCLUDE_MODEL: bool = true;

    /// fmi2SetDebugLogging: enables or disables the named categories, or all without names;
    /// enabling some disables the others. Errors are always reported. Unused standard categories
    /// are accepted.
    fn switch(log: &Log, on: bool, categories: &[&str]) -> Result<u32, Fault> {
        let named = (categories.iter()).fold(0, |mask, name| mask | log.bits(name).unwrap_or(0));
        let enabled = match (on, categories) {
            (true, []) => ALL,
            (true, _) => named,
            (false, []) => 0,
            (false, _) => log.enabled() & !named,
        };
        Ok(enabled | REFUSED)
    }

    fn is_available(&self) -> bool {
        self.callback.is_some()
    }

    /// Each kind of message has its own status, whatever the call returns.
    fn status(kind: Kind, _returned: Status) -> Status {
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
        // format has no further arguments.
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

/// The text as a `printf` format without arguments, in which `#` would begin a variable reference
/// (FMI 2.0.4, section 2.1.5).
fn escaped(text: &str) -> String {
    text.replace('%', "%%").replace('#', "##")
}
