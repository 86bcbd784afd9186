//! The state of an instance's clocks, for `state`, `ticks` and `ticking`: which are active, and when
//! they tick.

use super::error::ModelError;
use super::event::Tick;
use super::model::{Clock, Model, Timing};
use serde::{Deserialize, Serialize};

/// The clocks of an instance.
#[derive(Clone, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct Ticks<M: Model> {
    /// By [`Model::CLOCKS`].
    pub(crate) each: Vec<ClockState>,
    /// The model before the ticks of the present event.
    pub(super) before: Option<M>,
    /// What active clocks compute has not been computed since something was set.
    pub(super) is_pending: bool,
}

/// The state of a clock.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct ClockState {
    pub(super) is_active: bool,
    /// An output clock that ticks since the last update, whatever is computed in this instant.
    pub(super) is_begun: bool,
    pub(super) qualifier: Qualifier,
    /// s; NaN if not known.
    pub(super) interval: f64,
    /// Time of the last tick, s; NaN before the first.
    pub(super) last: f64,
    /// The time from which a periodic clock counts its ticks, s, and their number.
    pub(super) origin: f64,
    pub(super) count: u32,
    /// Time of the next tick, s.
    pub(super) next: f64,
}

/// `fmi3IntervalQualifier`.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) enum Qualifier {
    Unknown = 0,
    Unchanged = 1,
    Changed = 2,
}

impl<M: Model> Ticks<M> {
    /// Before the initialization; None for a model without clocks.
    pub(crate) fn new() -> Option<Box<Self>> {
        let state = |clock: &Clock<M>| ClockState {
            is_active: false,
            is_begun: false,
            qualifier: clock
                .interval()
                .map_or(Qualifier::Unknown, |_| Qualifier::Changed),
            interval: clock.interval().unwrap_or(f64::NAN),
            last: f64::NAN,
            origin: f64::NAN,
            count: 0,
            next: f64::INFINITY,
        };
        let ticks = || Self {
            each: M::CLOCKS.iter().map(state).collect(),
            before: None,
            is_pending: false,
        };
        (!M::CLOCKS.is_empty()).then(|| Box::new(ticks()))
    }

    /// Time of the next tick that the instance itself makes, s.
    pub(super) fn next(&self) -> f64 {
        self.each
            .iter()
            .map(|clock| clock.next)
            .fold(f64::INFINITY, f64::min)
    }

    /// What active clocks compute has to be computed anew.
    #[inline]
    pub(crate) fn mark(&mut self) {
        let mut all = M::CLOCKS.iter().zip(&self.each);
        self.is_pending |= all.any(|(clock, own)| own.is_active && clock.is_input());
    }
}

impl ClockState {
    /// Takes over an interval, s, from `now` on.
    pub(super) fn start(&mut self, interval: f64, now: f64) {
        (self.interval, self.qualifier) = (interval, Qualifier::Changed);
        self.next = now + interval;
    }
}

pub(super) fn wrong_interval<M: Model>(clock: &Clock<M>, interval: f64) -> ModelError {
    let least = if clock.is_periodic() {
        "above"
    } else {
        "at least"
    };
    let name = clock.row.name;
    ModelError::new(format!(
        "the interval of clock `{name}` = {interval} s must be finite and {least} 0"
    ))
}

impl ClockState {
    /// The tick of a clock at `t`, s, in a run from `start` on.
    pub(super) fn tick<M: Model>(&self, clock: &Clock<M>, t: f64, start: f64) -> Tick {
        let since = if self.last.is_nan() { start } else { self.last };
        let interval = match clock.is_periodic() {
            true => self.interval,
            false => t - since,
        };
        Tick { time: t, interval }
    }

    /// After an event or a tick at `t`, s: finds the next tick, and returns whether an output clock
    /// has become active.
    pub(super) fn follow<M: Model>(
        &mut self,
        clock: &Clock<M>,
        model: &mut M,
        p: &M::Parameters,
        t: f64,
        has_ticked: bool,
    ) -> Result<bool, ModelError> {
        let has_ticked = has_ticked && clock.is_input();
        if has_ticked {
            self.last = t;
        }
        let interval = match clock.timing {
            Timing::Output(take) => {
                self.is_begun = take(model);
                self.is_active = self.is_begun;
                return Ok(self.is_active);
            }
            Timing::Changing(next) if has_ticked => Some(next(model, p)),
            Timing::Countdown(take) => {
                if has_ticked {
                    (self.qualifier, self.next) = (Qualifier::Unknown, f64::INFINITY);
                }
                take(model)
            }
            _ if has_ticked && clock.is_periodic() => {
                self.count += 1;
                self.next = self.origin + f64::from(self.count) * self.interval;
                None
            }
            _ => None,
        };
        match interval {
            Some(interval) if !clock.allows(interval) => Err(wrong_interval(clock, interval)),
            Some(interval) => {
                self.start(interval, t);
                Ok(false)
            }
            None => Ok(false),
        }
    }
}

/// Clocks in saved states. The code for them is left out of models without clocks.
pub(super) mod saved {
    use super::{Model, Ticks};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    type Saved<M> = Option<Box<Ticks<M>>>;

    pub(crate) fn serialize<M: Model, S: Serializer>(
        of: &Saved<M>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        match M::CLOCKS.is_empty() {
            true => None::<()>.serialize(to),
            false => of.serialize(to),
        }
    }

    pub(crate) fn deserialize<'a, M: Model, D: Deserializer<'a>>(
        from: D,
    ) -> Result<Saved<M>, D::Error> {
        match M::CLOCKS.is_empty() {
            true => Option::<()>::deserialize(from).map(|_| None),
            false => Option::deserialize(from),
        }
    }
}
