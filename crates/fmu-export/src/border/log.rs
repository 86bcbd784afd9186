//! What the importer wants to hear, and its logger.

use crate::core::log::{Categories, Level, STANDARD, number};
use crate::core::message::{Kind, Message};
use std::ffi::CString;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Every category that each FMU declares: its name, its bits, its description. Those of the model come after them.
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
/// Number of the bit of the model's first category.
const FIRST: usize = 4;

/// The importer's logger and what it wants to hear.
pub(crate) struct Log<L> {
    pub(crate) logger: L,
    /// The model's own.
    categories: Categories,
    enabled: AtomicU32,
    /// The instance is gone, and with it perhaps the importer's environment.
    is_closed: AtomicBool,
}

/// Where a message belongs.
pub(crate) struct Place {
    /// Bit of a category of the model; 0: none.
    pub(crate) own: u32,
    /// Bit of the category of FMI that fits its kind.
    pub(crate) standard: u32,
    /// Name of its category.
    pub(crate) category: &'static str,
}

impl<L> Log<L> {
    /// With the bits `enabled` on.
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

    /// The bits of a category; None if it is neither declared by each FMU nor one of the model's.
    pub(crate) fn bits(&self, name: &str) -> Option<u32> {
        let declared = CATEGORIES.iter().find(|(known, ..)| *known == name);
        match (declared, number(self.categories, name)) {
            (Some((_, bits, _)), _) => Some(*bits),
            (None, STANDARD) => None,
            (None, k) => Some(1 << (FIRST + k)),
        }
    }

    /// What the model's messages of one level are worth formatting for, where those without a category of its own have the bit `standard`.
    pub(crate) fn wanted(&self, standard: u32) -> u32 {
        let enabled = self.enabled();
        enabled >> FIRST | u32::from(enabled & standard != 0) << STANDARD
    }

    /// Nothing is sent any more.
    pub(crate) fn close(&self) {
        self.is_closed.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.is_closed.load(Ordering::Relaxed)
    }

    /// Where a message belongs.
    pub(crate) fn place(&self, message: &Message) -> Place {
        let (standard, category) = match message.kind {
            Kind::Event | Kind::Model(Level::Info, _) => (EVENT, "logEvents"),
            Kind::Warning | Kind::Model(Level::Warning, _) => (WARNING, "logStatusWarning"),
            Kind::Discarded => (DISCARDED, "logStatusDiscard"),
            Kind::Refused => (REFUSED, "logStatusError"),
        };
        if let Kind::Model(_, name) = message.kind
            && let k = number(self.categories, name)
            && k != STANDARD
        {
            let own = 1 << (FIRST + k);
            return Place {
                own,
                standard,
                category: name,
            };
        }
        Place {
            own: 0,
            standard,
            category,
        }
    }
}

/// A C string; a NUL inside the text becomes U+FFFD.
pub(crate) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).expect("no NUL is left")
}
