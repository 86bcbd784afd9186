//! What an event of a model leads to.

/// What an event leads to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Event {
    /// It must be looked at once more before time goes on.
    pub again: bool,
    /// The next time event, s; None: none is known.
    pub next: Option<f64>,
    /// The model wants the simulation to end.
    pub terminate: bool,
}

impl Event {
    /// Nothing follows.
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
