//! [`Log`], for models: their own messages, queued during a call and sent to the importer after it.

use super::message::{Kind, Level, Message};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::panic::Location;

/// Messages of a model to the importer's log. A model that sends any keeps a `Log` in its state and
/// returns it from [`Model::log`](crate::Model::log).
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
/// A message that the importer has not enabled is not formatted. Of the messages from one line of
/// the program, the first ten are sent, then the 100th, the 1000th and so on. None are saved.
#[derive(Clone, Debug, Default)]
pub struct Log {
    queue: Vec<Message>,
    /// Lines of the program that have sent messages, and their number.
    locations: Vec<(&'static Location<'static>, u64)>,
    filter: LogFilter,
    categories: Categories,
}

/// Names and descriptions of a model's own categories.
pub(crate) type Categories = &'static [(&'static str, &'static str)];

/// Number of the standard category for a message's level.
pub(crate) const STANDARD: usize = 31;
/// Most categories of a model.
pub(crate) const MOST_CATEGORIES: usize = 28;
/// Number of messages of one line that are all sent.
const FIRST: u64 = 10;

/// The enabled categories of a model's messages, by level: bit k for category k.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogFilter {
    pub(crate) info: u32,
    pub(crate) warning: u32,
}

impl Default for LogFilter {
    /// Everything: disabled messages are left out later.
    fn default() -> Self {
        Self {
            info: u32::MAX,
            warning: u32::MAX,
        }
    }
}

impl Log {
    /// Logs information. `category` is one of
    /// [`Info::log_categories`](crate::Info::log_categories), or empty for the standard category.
    #[track_caller]
    pub fn info(&mut self, category: &'static str, text: fmt::Arguments<'_>) {
        self.push(Level::Info, category, text);
    }

    /// Logs a warning; the call still succeeds.
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
            text += " (from now on only the 100th, the 1000th and so on are sent)";
        } else if count > FIRST {
            text += &format!(" (the {count}th of these messages)");
        }
        let kind = Kind::Model(level, category);
        self.queue.push(Message { kind, text });
    }

    /// Counts a message from a line of the program.
    fn count(&mut self, location: &'static Location<'static>) -> u64 {
        match (self.locations.iter_mut()).find(|(known, _)| *known == location) {
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

    /// To be called before a call of the model.
    #[inline]
    pub(crate) fn prepare(&mut self, filter: LogFilter, categories: Categories) {
        self.filter = filter;
        self.categories = categories;
    }

    /// Moves the queued messages to `messages`, after a call of the model.
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

/// Serializes nothing: messages are sent when the call that made them is over.
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
