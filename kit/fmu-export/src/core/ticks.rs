//! The clocks of an instance, for `ticking` and `fmi3`: which are active, and their intervals.
//!
//! The importer activates clocks in Event Mode; what they compute is computed when it is read, with
//! the inputs that are set then, and kept when the discrete states are updated.

use super::clock_state::{Qualifier, Ticks, wrong_interval};
use super::fault::{Fault, refuse};
use super::instance::Instance;
use super::model::Timing;
use super::phase::Phase;
use crate::Model;

impl<M: Model> Instance<M> {
    /// The clocks of a model that has some.
    pub(super) fn ticks(&mut self) -> &mut Ticks<M> {
        self.state.ticks.as_mut().expect("the model has clocks")
    }

    /// The position of a clock by its number.
    pub(crate) fn clock(&self, number: u32) -> Result<usize, Fault> {
        let (span, first, _) = self.layout.block(number)?;
        match M::CLOCKS.iter().position(|c| c.row.name == span.row.name) {
            Some(k) => Ok(k),
            None => {
                let name = self.name(span.row, first);
                let kind = span.row.kind(self.names);
                let has = if M::CLOCKS.is_empty() {
                    ", and this FMU has none"
                } else {
                    ""
                };
                refuse!("`{name}` is {kind}; it must be a Clock{has}")
            }
        }
    }

    /// The position of an input clock, which can be activated.
    pub(crate) fn input_clock(&self, number: u32) -> Result<usize, Fault> {
        let k = self.clock(number)?;
        let name = M::CLOCKS[k].row.name;
        match M::CLOCKS[k].is_input() {
            true => Ok(k),
            false => refuse!("`{name}` is a Clock output; only input clocks can be activated"),
        }
    }

    /// Activates or deactivates an input clock in Event Mode.
    pub(crate) fn set_clock(&mut self, number: u32, is_active: bool) -> Result<(), Fault> {
        let k = self.input_clock(number)?;
        let ticks = self.ticks();
        ticks.is_pending |= ticks.each[k].is_active != is_active;
        ticks.each[k].is_active = is_active;
        self.invalidate();
        Ok(())
    }

    /// From Event Mode to `phase`; refused while an input clock is active, since only an update keeps
    /// what it has computed.
    pub(crate) fn leave_events(&mut self, phase: Phase) -> Result<(), Fault> {
        if !M::CLOCKS.is_empty() {
            let mut all = M::CLOCKS.iter().zip(&self.ticks().each);
            if let Some((clock, _)) = all.find(|(clock, own)| own.is_active && clock.is_input()) {
                let name = clock.row.name;
                return refuse!(
                    "clock `{name}` is active; fmi3UpdateDiscreteStates must come before"
                );
            }
            self.model()?;
            let ticks = self.ticks();
            ticks.before = None;
            for own in &mut ticks.each {
                (own.is_active, own.is_begun) = (false, false);
            }
        }
        self.enter(phase)
    }

    /// Whether a clock is active; in Scheduled Execution this is told once.
    pub(crate) fn get_clock(&mut self, number: u32) -> Result<bool, Fault> {
        let k = self.clock(number)?;
        self.model()?;
        let is_scheduled = self.state.phase == Phase::Scheduled;
        let is_active = &mut self.ticks().each[k].is_active;
        let found = *is_active;
        *is_active &= !is_scheduled;
        Ok(found)
    }

    /// Refuses clocked variables while none of their clocks is active.
    #[cold]
    pub(crate) fn check_clocked(
        &self,
        number: &dyn Fn(usize) -> Option<u32>,
        to: &str,
    ) -> Result<(), Fault> {
        let Some(ticks) = &self.state.ticks else {
            return Ok(());
        };
        let phase = self.state.phase;
        if !phase.is_running() || phase == Phase::Scheduled || self.ticks_itself {
            return Ok(());
        }
        for number in (0..).map_while(number) {
            let Ok((i, row)) = self.layout.find_any(number) else {
                continue;
            };
            let is_active = |name: &&str| {
                let all = M::CLOCKS.iter().zip(&ticks.each);
                all.into_iter()
                    .any(|(c, state)| c.row.name == *name && state.is_active)
            };
            if !row.clocks.is_empty() && !row.clocks.iter().any(is_active) {
                let (name, clocks) = (self.name(row, i), row.clocks.join("`, `"));
                return refuse!(
                    "`{name}` belongs to the clock `{clocks}`, which is not active; it can be {to} in Event Mode at a tick"
                );
            }
        }
        Ok(())
    }

    /// The present interval of a clock, s.
    pub(crate) fn interval(&mut self, number: u32) -> Result<(f64, Qualifier), Fault> {
        let k = self.clock(number)?;
        if M::CLOCKS[k].is_triggered() {
            let name = M::CLOCKS[k].row.name;
            return refuse!(
                "clock `{name}` is triggered; only a clock that follows time has an interval"
            );
        }
        self.refresh(k)?;
        let clock = &mut self.ticks().each[k];
        let found = (clock.interval, clock.qualifier);
        if clock.qualifier == Qualifier::Changed {
            clock.qualifier = Qualifier::Unchanged;
        }
        Ok(found)
    }

    /// Computes an interval that depends on parameters, or on the initial state.
    pub(super) fn refresh(&mut self, k: usize) -> Result<(), Fault> {
        let clock = &M::CLOCKS[k];
        let is_initial = self.state.phase == Phase::Initialization;
        self.model()?;
        let state = &mut self.state;
        let (Some(model), Some(ticks)) = (&mut state.model, &mut state.ticks) else {
            unreachable!("made above");
        };
        let own = &mut ticks.each[k];
        let interval = match clock.timing {
            Timing::Calculated(period) if is_initial => period(&state.parameters),
            Timing::Tunable(period) => period(&state.parameters),
            Timing::Changing(next) if is_initial => next(model, &state.parameters),
            Timing::Countdown(take) if is_initial => match take(model) {
                Some(interval) => interval,
                None => return Ok(()),
            },
            _ => return Ok(()),
        };
        if !clock.allows(interval) {
            return Err(wrong_interval(clock, interval).into());
        }
        if own.interval != interval {
            let next = own.next;
            own.start(interval, own.last);
            if own.last.is_nan() {
                own.next = next; // the first tick is at its shift
            } else if own.next < state.time {
                (own.origin, own.count, own.next) = (state.time, 0, state.time);
            } else {
                (own.origin, own.count) = (own.last, 1);
            }
        }
        Ok(())
    }

    /// Takes over the importer's interval of a fixed clock, s.
    pub(crate) fn set_interval(&mut self, number: u32, interval: f64) -> Result<(), Fault> {
        let k = self.clock(number)?;
        let clock = &M::CLOCKS[k];
        let name = clock.row.name;
        if !matches!(clock.timing, Timing::Fixed(_)) {
            return refuse!(
                "the interval of clock `{name}` is the FMU's own; only that of a fixed clock with intervalDecimal can be set"
            );
        }
        if self.state.phase != Phase::Initialization {
            return refuse!(
                "the interval of clock `{name}` can be set in Initialization Mode only"
            );
        }
        if !clock.allows(interval) {
            return Err(wrong_interval(clock, interval).into());
        }
        self.ticks().each[k].start(interval, 0.0);
        Ok(())
    }

    /// The delay of the first tick of a periodic clock, s.
    pub(crate) fn shift(&self, number: u32) -> Result<f64, Fault> {
        let clock = &M::CLOCKS[self.clock(number)?];
        match clock.is_periodic() {
            true => Ok(clock.shift),
            false => refuse!(
                "clock `{}` is not periodic; only a periodic clock has a shift",
                clock.row.name
            ),
        }
    }

    /// At the end of initialization: finds the first ticks.
    pub(crate) fn start_ticks(&mut self) -> Result<(), Fault> {
        for (k, clock) in M::CLOCKS.iter().enumerate() {
            self.refresh(k)?;
            let start = self.state.start;
            let own = &mut self.ticks().each[k];
            (own.origin, own.count) = (start + clock.shift, 0);
            own.next = match clock.timing {
                _ if clock.is_periodic() => own.origin,
                _ if clock.is_triggered() => f64::INFINITY,
                _ if own.interval.is_nan() => f64::INFINITY,
                _ => start + own.interval,
            };
        }
        Ok(())
    }
}
