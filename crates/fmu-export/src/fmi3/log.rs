//! Messages to the importer's logger: what it wants to hear, and how FMI 3.0 wants it written (section 2.3.1): as it is, only if logging
//! is on, and with no worse status than the function returns.

use super::ffi::{InstanceEnvironment, LogMessage, Status};
use crate::border::body::Answer;
use crate::border::log::{ALL, CATEGORIES, EVENT, Place, WARNING, c_string};
use crate::core::fault::{Fault, refuse};
use crate::core::log::{Categories, Wanted};
use crate::core::message::{Kind, Message};

/// The importer's logger.
pub(crate) struct Logger {
    callback: Option<LogMessage>,
    environment: InstanceEnvironment,
}

pub(crate) type Log = crate::border::log::Log<Logger>;

// SAFETY: the environment is handed to the importer's logger and not looked at. FMI lets threads take turns with an instance.
unsafe impl Send for Logger {}
// SAFETY: as above; everything is immutable.
unsafe impl Sync for Logger {}

/// The log of a new instance.
pub(crate) fn new(
    callback: Option<LogMessage>,
    environment: InstanceEnvironment,
    logging_on: bool,
    categories: Categories,
) -> Log {
    let logger = Logger {
        callback,
        environment,
    };
    Log::new(logger, categories, if logging_on { ALL } else { 0 })
}

impl Log {
    /// fmi3SetDebugLogging: all or the named categories on or off.
    pub(crate) fn switch(&self, on: bool, names: &[&str], own: Categories) -> Result<(), Fault> {
        let mut named = if names.is_empty() { ALL } else { 0 };
        for name in names {
            let Some(bits) = self.bits(name) else {
                let known = CATEGORIES.iter().map(|(name, ..)| *name);
                let known: Vec<_> = known.chain(own.iter().map(|(name, _)| *name)).collect();
                return refuse!("category `{name}` must be one of {}", known.join(", "));
            };
            named |= bits;
        }
        self.enable(match on {
            true => self.enabled() | named,
            false => self.enabled() & !named,
        });
        Ok(())
    }

    /// What the importer wants to hear of the model.
    pub(crate) fn wanted_of_model(&self) -> Wanted {
        match self.logger.callback {
            Some(_) => Wanted {
                info: self.wanted(EVENT),
                warning: self.wanted(WARNING),
            },
            None => Wanted {
                info: 0,
                warning: 0,
            },
        }
    }

    /// Sends messages that are wanted, one by one, until the logger frees the instance. See the version of FMI 2.0 for what may happen in
    /// the logger.
    pub(crate) fn send(&self, messages: &[Message], answer: Answer) {
        let Some(callback) = self.logger.callback else {
            return;
        };
        for message in messages {
            let Place {
                own,
                standard,
                category,
            } = self.place(message);
            let bit = if own == 0 { standard } else { own };
            if self.enabled() & bit == 0 {
                continue;
            }
            let status = match message.kind {
                Kind::Discarded | Kind::Refused => Status::from(answer),
                Kind::Warning if answer != Answer::Ok => Status::Warning,
                _ => Status::Ok,
            };
            let (category, text) = (c_string(category), c_string(&message.text));
            if self.is_closed() {
                return;
            }
            // SAFETY: the importer's logger takes these C strings, which live until it returns.
            unsafe {
                callback(
                    self.logger.environment,
                    status,
                    category.as_ptr(),
                    text.as_ptr(),
                );
            }
        }
    }
}
