//! Messages of an instance. They are queued while a call runs, as plain text; the border sends them
//! when it has let go of the instance, because the receiver may call back.

/// How much a message of a model matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Level {
    /// Good to know; sent if the importer asked for debug messages.
    Info,
    /// Something is not quite right, though the call succeeds; sent unless the importer switched
    /// warnings off.
    Warning,
}

/// What a message is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Initialization, reset, restored states.
    Event,
    /// The call succeeded, but something is not quite right.
    Warning,
    /// [`Fault::Discarded`](super::fault::Fault::Discarded).
    Discarded,
    /// [`Fault::Refused`](super::fault::Fault::Refused), or a panic.
    Refused,
    /// From the model, with the name of one of its categories.
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
