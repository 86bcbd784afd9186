//! The result of event handling, which a model returns and Model Exchange and solvers read, and the
//! tick of a clock, which a model gets.

use super::error::ModelError;
use super::message::shown;

/// A tick of a clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Its time, s.
    pub time: f64,
    /// The period of a periodic clock; else the time since the last tick, or since the start, s.
    pub interval: f64,
}

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

    /// Both events, of two parts of a model: the earlier next one, and what either asks for.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        let next = match (self.next, other.next) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, None) => a,
            (None, b) => b,
        };
        Self {
            again: self.again || other.again,
            next,
            terminate: self.terminate || other.terminate,
        }
    }
}

/// Most iterations of one event.
pub(super) const MOST_ITERATIONS: u32 = 10_000;

/// Lets the model handle an event at `t`, s, until no further iteration is needed.
pub(crate) fn handle(
    t: f64,
    mut iterate: impl FnMut() -> Result<Event, ModelError>,
) -> Result<Event, ModelError> {
    for _ in 0..MOST_ITERATIONS {
        let event = iterate()?;
        event.check(t)?;
        if !event.again {
            return Ok(event);
        }
    }
    let t = shown(t);
    Err(ModelError::new(format!(
        "t = {t} s: an event does not end after {MOST_ITERATIONS} iterations"
    )))
}

impl Event {
    /// When the model has to handle the next time event, s; −infinite: at once.
    pub(crate) fn due(&self) -> f64 {
        match self.again || self.terminate {
            true => f64::NEG_INFINITY,
            false => self.next.unwrap_or(f64::INFINITY),
        }
    }

    /// Refuses a next time event that is not after this one at `t`, s.
    pub(crate) fn check(&self, t: f64) -> Result<(), ModelError> {
        match self.next {
            Some(next) if !(next.is_finite() && next > t) => Err(ModelError::new(format!(
                "the model's next time event, at {next} s, must be finite and after {t} s"
            ))),
            _ => Ok(()),
        }
    }
}
