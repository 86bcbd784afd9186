//! Messages of an instance, from the FMI functions and the model's log. They are queued as text in
//! a call and sent when the instance is no longer in use: the importer's logger may call back.

/// Severity of a model's message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Level {
    /// Information; sent if the importer has enabled logging.
    Info,
    /// A problem that does not make the call fail; sent unless the importer has disabled warnings.
    Warning,
}

/// What a message is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Initialization, reset, restored states.
    Event,
    /// A problem, although the call succeeded.
    Warning,
    /// [`Fault::Discarded`](super::fault::Fault::Discarded).
    Discarded,
    /// [`Fault::Refused`](super::fault::Fault::Refused), or a panic.
    Refused,
    /// A message of the model, in one of its categories.
    Model(Level, &'static str),
}

/// One message.
#[derive(Clone, Debug)]
pub(crate) struct Message {
    pub(crate) kind: Kind,
    pub(crate) text: String,
}

impl Message {
    #[cold]
    pub(crate) fn new(kind: Kind, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { kind, text }
    }
}

/// A time as messages show it, s: without the rest of a rounding error, where that is below a
/// billionth of itself.
pub(crate) fn shown(t: f64) -> f64 {
    let rounded = (t * 1e9).round() / 1e9;
    let is_rest = (rounded - t).abs() <= 1e-9 * t.abs();
    if is_rest { rounded } else { t }
}
