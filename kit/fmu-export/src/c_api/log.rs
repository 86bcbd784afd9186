//! The log of an instance of `fmi2` or `fmi3`: the log categories, which of them the importer has
//! enabled, and sending messages to the importer's logger.

use super::status::Status;
use crate::core::fault::Fault;
use crate::core::log::{Categories, LogFilter, STANDARD, number};
use crate::core::message::{Kind, Level, Message};
use std::ffi::{CStr, CString};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The log categories of each FMU: name, bits, description. The model's own categories follow.
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

pub(crate) const EVENT: u32 = 1;
pub(crate) const WARNING: u32 = 2;
pub(crate) const DISCARDED: u32 = 4;
pub(crate) const REFUSED: u32 = 8;
pub(crate) const ALL: u32 = u32::MAX;
/// Position of the bit of the model's first category.
const FIRST: usize = 4;

/// The importer's logger and the categories that it has enabled.
pub(crate) struct Log<L> {
    logger: L,
    /// The model's own categories.
    categories: Categories,
    enabled: AtomicU32,
    /// The instance was freed, and the importer's environment may be gone.
    is_closed: AtomicBool,
}

/// The importer's logger callback in a version of FMI.
pub(crate) trait Logger: Send + Sync + Sized {
    /// The category of warnings includes warnings in the model's own categories.
    const WARNINGS_INCLUDE_MODEL: bool;

    /// Returns the bits of the enabled categories after these were switched on or off.
    fn switch(log: &Log<Self>, on: bool, categories: &[&str]) -> Result<u32, Fault>;

    /// Whether the importer has given one.
    fn is_available(&self) -> bool;

    /// The status of a message from a call that returns `returned`.
    fn status(kind: Kind, returned: Status) -> Status;

    /// Calls the logger, which may call functions of the instance, and free it. A C++ exception may
    /// leave the logger and unwinds through here; longjmp may not.
    fn log(&self, status: Status, category: &CStr, text: &str);
}

impl<L: Logger> Log<L> {
    /// A log with these bits enabled.
    pub(crate) fn new(logger: L, categories: Categories, enabled: u32) -> Self {
        Self {
            logger,
            categories,
            enabled: AtomicU32::new(enabled),
            is_closed: AtomicBool::new(false),
        }
    }

    pub(crate) fn enabled(&self) -> u32 {
        self.enabled.load(Ordering::Relaxed)
    }

    pub(crate) fn enable(&self, bits: u32) {
        self.enabled.store(bits, Ordering::Relaxed);
    }

    /// The bits of a declared category; None for an unknown one.
    pub(crate) fn bits(&self, name: &str) -> Option<u32> {
        let declared = CATEGORIES.iter().find(|(known, ..)| *known == name);
        match (declared, number(self.categories, name)) {
            (Some((_, bits, _)), _) => Some(*bits),
            (None, STANDARD) => None,
            (None, k) => Some(1 << (FIRST + k)),
        }
    }

    /// The model's own categories.
    pub(crate) fn categories(&self) -> Categories {
        self.categories
    }

    /// Which of the model's messages the importer has enabled.
    pub(crate) fn model_filter(&self) -> LogFilter {
        if !self.logger.is_available() {
            let (info, warning) = (0, 0);
            return LogFilter { info, warning };
        }
        let has_all_warnings = L::WARNINGS_INCLUDE_MODEL && self.enabled() & WARNING != 0;
        LogFilter {
            info: self.model_bits(EVENT),
            warning: match has_all_warnings {
                true => u32::MAX,
                false => self.model_bits(WARNING),
            },
        }
    }

    /// The enabled categories of the model's messages of one level; messages without a category of
    /// the model have the bit `standard`.
    fn model_bits(&self, standard: u32) -> u32 {
        let enabled = self.enabled();
        enabled >> FIRST | u32::from(enabled & standard != 0) << STANDARD
    }

    /// Sends nothing from now on.
    pub(crate) fn close(&self) {
        self.is_closed.store(true, Ordering::Relaxed);
    }

    /// Sends the messages whose category is enabled, until the logger frees the instance. The
    /// caller holds no reference to the instance meanwhile, because the logger may not return.
    pub(crate) fn send(&self, messages: &[Message], returned: Status) {
        if !self.logger.is_available() {
            return;
        }
        for message in messages {
            let (bits, category) = self.category(message.kind);
            if self.enabled() & bits == 0 {
                continue;
            }
            let category = c_string(category);
            if self.is_closed.load(Ordering::Relaxed) {
                return;
            }
            let status = L::status(message.kind, returned);
            self.logger.log(status, &category, &message.text);
        }
    }

    /// The bits of a message, one of which must be enabled, and the name of its category.
    fn category(&self, kind: Kind) -> (u32, &'static str) {
        let (standard, category) = match kind {
            Kind::Event | Kind::Model(Level::Info, _) => (EVENT, "logEvents"),
            Kind::Warning | Kind::Model(Level::Warning, _) => (WARNING, "logStatusWarning"),
            Kind::Discarded => (DISCARDED, "logStatusDiscard"),
            Kind::Refused => (REFUSED, "logStatusError"),
        };
        let own = match kind {
            Kind::Model(_, name) => (number(self.categories, name), name),
            _ => (STANDARD, ""),
        };
        match own {
            (STANDARD, _) => (standard, category),
            (k, name) if L::WARNINGS_INCLUDE_MODEL && standard == WARNING => {
                (1 << (FIRST + k) | WARNING, name)
            }
            (k, name) => (1 << (FIRST + k), name),
        }
    }
}

/// The text as a C string; a NUL inside it becomes U+FFFD.
pub(crate) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).expect("no NUL is left")
}
