//! The constructors of a [`Clock`], with which a model says when a part of it is computed. Clocks
//! are variables of FMI 3.0, which the importer ticks; in FMI 2.0 `ticking` does.

use super::causality::Causality;
use super::model::{Clock, Model, OnTick, Timing, Variable};
use super::storage::Storage;

impl<M: Model> Clock<M> {
    /// Ticks every `period` s, from the start on.
    pub const fn constant(
        name: &'static str,
        description: &'static str,
        period: f64,
        on_tick: OnTick<M>,
    ) -> Self {
        Self::new(name, description, Timing::Constant(period), on_tick)
    }

    /// Ticks every `period` s, for which the importer may choose another value before the start.
    pub const fn fixed(
        name: &'static str,
        description: &'static str,
        period: f64,
        on_tick: OnTick<M>,
    ) -> Self {
        Self::new(name, description, Timing::Fixed(period), on_tick)
    }

    /// Its period, s, is calculated from parameters that are fixed after the initialization.
    pub const fn calculated(
        name: &'static str,
        description: &'static str,
        period: fn(&M::Parameters) -> f64,
        on_tick: OnTick<M>,
    ) -> Self {
        Self::new(name, description, Timing::Calculated(period), on_tick)
    }

    /// Its period, s, is calculated from parameters that may be tuned.
    pub const fn tunable(
        name: &'static str,
        description: &'static str,
        period: fn(&M::Parameters) -> f64,
        on_tick: OnTick<M>,
    ) -> Self {
        Self::new(name, description, Timing::Tunable(period), on_tick)
    }

    /// At the start and at each tick, `next` tells the time until the next tick, s.
    pub const fn changing(
        name: &'static str,
        description: &'static str,
        next: fn(&M, &M::Parameters) -> f64,
        on_tick: OnTick<M>,
    ) -> Self {
        Self::new(name, description, Timing::Changing(next), on_tick)
    }

    /// Ticks once, some time after the model has started it: `take` hands that time out, s, and
    /// forgets it, as `|x| x.delay.take()` does for an `Option<f64>`. It is called after each event
    /// and tick.
    pub const fn countdown(
        name: &'static str,
        description: &'static str,
        take: fn(&mut M) -> Option<f64>,
        on_tick: OnTick<M>,
    ) -> Self {
        Self::new(name, description, Timing::Countdown(take), on_tick)
    }

    /// Ticks when the importer says so, because of a clock of another FMU; of FMI 3.0 only.
    pub const fn triggered(
        name: &'static str,
        description: &'static str,
        on_tick: OnTick<M>,
    ) -> Self {
        Self::new(name, description, Timing::Triggered, on_tick)
    }

    /// An output that ticks when the model says so: `take` tells whether it does, and forgets it,
    /// as `|x: &mut Self| take(&mut x.has_switched)` does. It is called after each event and tick.
    /// Of FMI 3.0 only.
    pub const fn output(
        name: &'static str,
        description: &'static str,
        take: fn(&mut M) -> bool,
    ) -> Self {
        Self::new(name, description, Timing::Output(take), |_, _, _, _| Ok(()))
    }

    const fn new(
        name: &'static str,
        description: &'static str,
        timing: Timing<M>,
        on_tick: OnTick<M>,
    ) -> Self {
        let causality = match timing {
            Timing::Output(_) => Causality::Output,
            _ => Causality::Input,
        };
        Self {
            row: Variable::row(name, description, causality, Storage::Clock, true),
            timing,
            shift: 0.0,
            ticks_later: false,
            on_tick,
        }
    }

    /// The delay of the first tick of a periodic clock, s.
    pub const fn shift(mut self, shift: f64) -> Self {
        self.shift = shift;
        self
    }

    /// An output clock that never ticks together with the clock whose function has caused it, but in
    /// the next instant of the same Event Mode: its variables depend on no input at once.
    pub const fn in_next_instant(mut self) -> Self {
        self.ticks_later = true;
        self
    }

    /// The value reference, where it is not the next one.
    pub const fn at(mut self, reference: u32) -> Self {
        self.row = self.row.at(reference);
        self
    }

    /// Further clocks that it belongs to: it ticks only when one of them does.
    pub const fn clocks(mut self, clocks: &'static [&'static str]) -> Self {
        self.row = self.row.clocks(clocks);
        self
    }

    pub(crate) fn is_input(&self) -> bool {
        !matches!(self.timing, Timing::Output(_))
    }

    pub(crate) fn is_periodic(&self) -> bool {
        use Timing::{Calculated, Constant, Fixed, Tunable};
        matches!(
            self.timing,
            Constant(_) | Fixed(_) | Calculated(_) | Tunable(_)
        )
    }

    /// Whether no time determines its ticks.
    pub(crate) fn is_triggered(&self) -> bool {
        matches!(self.timing, Timing::Triggered | Timing::Output(_))
    }

    /// `intervalVariability` of FMI 3.0.
    pub(crate) fn variability(&self) -> &'static str {
        match self.timing {
            Timing::Constant(_) => "constant",
            Timing::Fixed(_) | Timing::Calculated(_) => "fixed",
            Timing::Tunable(_) => "tunable",
            Timing::Changing(_) => "changing",
            Timing::Countdown(_) => "countdown",
            Timing::Triggered | Timing::Output(_) => "triggered",
        }
    }

    /// The interval of the description, s.
    pub(crate) fn interval(&self) -> Option<f64> {
        match self.timing {
            Timing::Constant(period) | Timing::Fixed(period) => Some(period),
            _ => None,
        }
    }

    /// Whether an interval, s, can be its own.
    pub(crate) fn allows(&self, interval: f64) -> bool {
        interval.is_finite() && (interval > 0.0 || interval == 0.0 && !self.is_periodic())
    }
}

/// Whether the model, of which `scratch` becomes a copy, has started a clock that the importer does
/// not know of; and whether one of those may tick where a step ends early: not one that ticks in the
/// next instant.
pub(crate) fn has_started<M: Model>(model: &M, scratch: &mut M) -> (bool, bool) {
    scratch.clone_from(model);
    let mut started = (false, false);
    for clock in M::CLOCKS {
        let is_started = match clock.timing {
            Timing::Countdown(take) => take(scratch).is_some(),
            Timing::Output(take) => take(scratch),
            _ => false,
        };
        started.0 |= is_started;
        started.1 |= is_started && !clock.ticks_later;
    }
    started
}
