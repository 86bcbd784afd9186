//! Logging in all functions of FMI 3.0: fmi3SetDebugLogging, and calls of the importer's logger
//! (2.3.1) with plain text, if logging is on, and with no worse status than the function returns.

use super::ffi::{Boolean, InstanceEnvironment, LogMessage, Status};
use crate::Model;
use crate::c_api::log::{self, ALL, CATEGORIES, c_string};
use crate::core::fault::{Fault, refuse};
use crate::core::message::Kind;
use std::ffi::CStr;

/// The importer's logger.
pub(crate) struct Logger {
    callback: Option<LogMessage>,
    environment: InstanceEnvironment,
}

pub(crate) type Log = log::Log<Logger>;

// SAFETY: the environment is only passed on to the logger; FMI lets threads take turns.
unsafe impl Send for Logger {}
// SAFETY: as above; everything is immutable.
unsafe impl Sync for Logger {}

/// The log of a new instance.
pub(crate) fn new<M: Model>(
    logging_on: Boolean,
    environment: InstanceEnvironment,
    callback: Option<LogMessage>,
) -> Log {
    let logger = Logger {
        callback,
        environment,
    };
    let enabled = if logging_on != 0 { ALL } else { 0 };
    Log::new(logger, M::INFO.log_categories, enabled)
}

impl log::Logger for Logger {
    const WARNINGS_INCLUDE_MODEL: bool = false;

    /// fmi3SetDebugLogging: enables or disables the named categories, or all without names.
    fn switch(log: &Log, on: bool, names: &[&str]) -> Result<u32, Fault> {
        let mut named = if names.is_empty() { ALL } else { 0 };
        for name in names {
            let Some(bits) = log.bits(name) else {
                let known = CATEGORIES.iter().map(|(name, ..)| *name);
                let own = log.categories().iter().map(|(name, _)| *name);
                let known: Vec<_> = known.chain(own).collect();
                return refuse!("category `{name}` must be one of {}", known.join(", "));
            };
            named |= bits;
        }
        Ok(match on {
            true => log.enabled() | named,
            false => log.enabled() & !named,
        })
    }

    fn is_available(&self) -> bool {
        self.callback.is_some()
    }

    fn status(kind: Kind, returned: Status) -> Status {
        match kind {
            Kind::Discarded | Kind::Refused => returned,
            Kind::Warning if returned != Status::Ok => Status::Warning,
            _ => Status::Ok,
        }
    }

    fn log(&self, status: Status, category: &CStr, text: &str) {
        let Some(callback) = self.callback else {
            return;
        };
        let text = c_string(text);
        // SAFETY: the importer's logger takes these C strings, which live until it returns.
        unsafe {
            callback(self.environment, status, category.as_ptr(), text.as_ptr());
        }
    }
}
