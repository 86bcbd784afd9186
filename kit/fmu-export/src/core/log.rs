//! What a model tells: messages of its own, queued during a call, which the border sends when the
//! call is over.

use super::message::{Kind, Level, Message};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::panic::Location;

/// Messages of a model to the importer's log. A model that has any keeps one in its state and gives
/// it to [`Model::log`](crate::Model::log).
///
/// ```
/// # use fmu_export::Log; use serde::{Serialize, Deserialize};
/// #[derive(Clone, Serialize, Deserialize)]
/// struct Oven { temperature: f64, log: Log }
///
/// # impl Oven { fn f(&mut self) {
/// self.log.warning("heat", format_args!("temperature = {} K must be at most 500 K", self.temperature));
/// # } }
/// ```
///
/// A message that nobody wants to hear is not even formatted. Of the messages from one line of the
/// program, the first ten are sent, then the 100th, the 1000th and so on. A saved state holds none.
#[derive(Clone, Debug, Default)]
pub struct Log {
    queue: Vec<Message>,
    /// Lines of the program that have sent messages, and how many.
    locations: Vec<(&'static Location<'static>, u64)>,
    filter: LogFilter,
    categories: Categories,
}

/// Names and descriptions of a model's own categories.
pub(crate) type Categories = &'static [(&'static str, &'static str)];

/// Number of the category of FMI that fits the level.
pub(crate) const STANDARD: usize = 31;
/// How many categories a model may have.
pub(crate) const MOST_CATEGORIES: usize = 28;
/// How many messages of one line are sent one by one.
const FIRST: u64 = 10;

/// What the importer wants to hear, by level: bit k for category k.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogFilter {
    pub(crate) info: u32,
    pub(crate) warning: u32,
}

impl Default for LogFilter {
    /// Everything: what is not wanted is left out later.
    fn default() -> Self {
        Self {
            info: u32::MAX,
            warning: u32::MAX,
        }
    }
}

impl Log {
    /// Tells something. `category` is one of [`Info::log_categories`](crate::Info::log_categories),
    /// or empty for that of FMI which fits the level.
    #[track_caller]
    pub fn info(&mut self, category: &'static str, text: fmt::Arguments<'_>) {
        self.push(Level::Info, category, text);
    }

    /// Warns; the call succeeds all the same.
    #[track_caller]
    pub fn warning(&mut self, category: &'static str, text: fmt::Arguments<'_>) {
        self.push(Level::Warning, category, text);
    }

    #[track_caller]
    fn push(&mut self, level: Level, category: &'static str, text: fmt::Arguments<'_>) {
        let filter = match level {
            Level::Info => self.filter.info,
            Level::Warning => self.filter.warning,
        };
        if filter & 1 << number(self.categories, category) == 0 {
            return;
        }
        let count = self.count(Location::caller());
        if count > FIRST && !is_power_of_ten(count) {
            return;
        }
        let mut text = text.to_string();
        if count == FIRST {
            text += " (more of the kind only at the 100th, the 1000th and so on)";
        } else if count > FIRST {
            text += &format!(" (the {count}th of its kind)");
        }
        let kind = Kind::Model(level, category);
        self.queue.push(Message { kind, text });
    }

    /// Counts a message from a line of the program.
    fn count(&mut self, location: &'static Location<'static>) -> u64 {
        match self
            .locations
            .iter_mut()
            .find(|(known, _)| *known == location)
        {
            Some((_, count)) => {
                *count += 1;
                *count
            }
            None => {
                self.locations.push((location, 1));
                1
            }
        }
    }

    /// Before a call of the model.
    #[inline]
    pub(crate) fn prepare(&mut self, filter: LogFilter, categories: Categories) {
        self.filter = filter;
        self.categories = categories;
    }

    /// After a call of the model.
    #[inline]
    pub(crate) fn empty_into(&mut self, messages: &mut Vec<Message>) {
        if !self.queue.is_empty() {
            messages.append(&mut self.queue);
        }
    }
}

/// Number of a model's category.
pub(crate) fn number(categories: Categories, name: &str) -> usize {
    (categories.iter().position(|(known, _)| *known == name)).unwrap_or(STANDARD)
}

fn is_power_of_ten(n: u64) -> bool {
    10_u64.checked_pow(n.ilog10()) == Some(n)
}

/// Nothing: messages are sent when the call that made them is over.
impl Serialize for Log {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        ().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Log {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        <()>::deserialize(deserializer)?;
        Ok(Self::default())
    }
}
