//! The result of event handling, which a model returns and Model Exchange and solvers read.

/// The result of [`Continuous::event`](crate::Continuous::event).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Event {
    /// The event must be handled once more before time advances.
    pub again: bool,
    /// The time of the next time event, s; None if none is known.
    pub next: Option<f64>,
    /// The model asks to end the simulation.
    pub terminate: bool,
}

impl Event {
    /// Nothing to do: time may advance.
    pub const NONE: Self = Self {
        again: false,
        next: None,
        terminate: false,
    };

    /// The next time event is at `t`, s.
    pub const fn at(t: f64) -> Self {
        Self {
            next: Some(t),
            ..Self::NONE
        }
    }
}
