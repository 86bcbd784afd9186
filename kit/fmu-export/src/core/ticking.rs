//! What clocks compute at their ticks, for `fmi3` and `fmi2`: in Event Mode, in steps in which the
//! instance ticks its clocks itself, and in Scheduled Execution.

use super::clock_state::Qualifier;
use super::event::MOST_ITERATIONS;
use super::fault::{Fault, refuse};
use super::instance::{Instance, collect_log, collect_messages, set_log_filter};
use super::message::shown;
use super::model::Timing;
use super::model_exchange::EventOutcome;
use super::step::CompletedStep;
use crate::{Event, Model, ModelError};

impl<M: Model> Instance<M> {
    /// Computes what the active clocks compute, from the model before the event.
    #[cold]
    pub(crate) fn run_ticks(&mut self) -> Result<(), ModelError> {
        let state = &mut self.state;
        let (Some(model), Some(ticks)) = (&mut state.model, &mut state.ticks) else {
            return Ok(());
        };
        if !ticks.is_pending {
            return Ok(());
        }
        match &ticks.before {
            Some(before) => model.clone_from(before),
            None => ticks.before = Some(model.clone()),
        }
        self.evaluation = None;
        let u = match &state.held_input {
            Some(held) => &held.value,
            None => &state.input.value,
        };
        set_log_filter(self.log_filter, model);
        for (clock, own) in M::CLOCKS.iter().zip(&ticks.each) {
            if !(own.is_active && clock.is_input()) {
                continue;
            }
            let tick = own.tick(clock, state.time, state.start);
            if let Err(error) = (clock.on_tick)(model, &state.parameters, u, tick) {
                collect_log(&mut self.messages, model);
                model.clone_from(ticks.before.as_ref().expect("made above"));
                let (t, name) = (shown(state.time), clock.row.name);
                return Err(ModelError::new(format!(
                    "t = {t} s, clock `{name}`: {error}"
                )));
            }
        }
        collect_messages(&mut self.messages, model);
        for (clock, own) in M::CLOCKS.iter().zip(&mut ticks.each) {
            match clock.timing {
                Timing::Output(take) if !clock.ticks_later => {
                    own.is_active = take(model) | own.is_begun;
                }
                _ => {}
            }
        }
        ticks.is_pending = false;
        Ok(())
    }

    /// After an event: deactivates the clocks, and finds when they tick next. Returns whether an
    /// output clock has become active.
    fn end_ticks(&mut self) -> Result<bool, Fault> {
        let state = &mut self.state;
        let (Some(model), Some(ticks)) = (&mut state.model, &mut state.ticks) else {
            return Ok(false);
        };
        let (t, mut has_output) = (state.time, false);
        ticks.before = None;
        for (clock, own) in M::CLOCKS.iter().zip(&mut ticks.each) {
            let has_ticked = std::mem::take(&mut own.is_active);
            has_output |= own.follow(clock, model, &state.parameters, t, has_ticked)?;
        }
        Ok(has_output)
    }

    /// In Event Mode: lets clocks and then the model's equations handle the event.
    pub(crate) fn update_discrete_states(&mut self) -> Result<EventOutcome, Fault> {
        match M::CLOCKS.is_empty() {
            true => self.handle_event(),
            false => self.or_restore(Self::handle_event_with_ticks),
        }
    }

    fn handle_event_with_ticks(&mut self) -> Result<EventOutcome, Fault> {
        let has_equations = M::MODEL_EXCHANGE.or(M::EVENTS).is_some();
        if self.ticks_itself {
            self.refresh_all()?;
            self.activate_due();
        }
        let has_ticked = self
            .state
            .ticks
            .as_ref()
            .is_some_and(|t| t.before.is_some() || t.is_pending);
        self.model()?;
        let mut outcome = EventOutcome {
            event: Event::NONE,
            is_moved: false,
        };
        if has_equations {
            outcome = self.handle_event()?;
        }
        outcome.is_moved |= has_ticked && self.layout.states > 0;
        outcome.event.again |= self.end_ticks()?;
        self.invalidate();
        if self.ticks_itself {
            let next = self.ticks().next();
            outcome.event.again |= next <= self.state.time;
            if next.is_finite() && !outcome.event.again {
                let own = outcome.event.next.unwrap_or(f64::INFINITY);
                outcome.event.next = Some(own.min(next));
            }
        }
        Ok(outcome)
    }

    /// Computes the intervals that follow parameters, which may have been tuned.
    fn refresh_all(&mut self) -> Result<(), Fault> {
        (0..M::CLOCKS.len()).try_for_each(|k| self.refresh(k))
    }

    /// Activates the clocks that are due; returns whether there are any.
    fn activate_due(&mut self) -> bool {
        let t = self.state.time;
        let ticks = self.ticks();
        for clock in &mut ticks.each {
            let near = 8.0 * f64::EPSILON * t.abs() + 1e-9 * clock.interval.max(0.0);
            clock.is_active |= clock.next <= t + near;
        }
        ticks.mark();
        self.invalidate();
        self.ticks().is_pending
    }

    /// Where the importer ticks no clocks: ticks those that are due at the present time, also those
    /// that an event starts which is due now.
    pub(crate) fn tick_due(&mut self) -> Result<(), Fault> {
        self.end_ticks()?;
        self.refresh_all()?;
        let mut has_event = M::EVENTS.is_some() && self.state.event <= self.state.time;
        for _ in 0..MOST_ITERATIONS {
            if !(self.activate_due() | std::mem::take(&mut has_event)) {
                return Ok(());
            }
            self.model()?;
            self.end_ticks()?;
            if M::EVENTS.is_some() {
                self.first_event()?;
                self.end_ticks()?;
            }
            self.invalidate();
        }
        let t = shown(self.state.time);
        refuse!("t = {t} s: a clock ticks more than {MOST_ITERATIONS} times at once")
    }

    /// A step in which the instance ticks its clocks itself; on an error it is as before.
    #[cold]
    #[inline(never)]
    pub(super) fn do_step_with_ticks(&mut self, t: f64, h: f64) -> Result<CompletedStep, Fault> {
        let from_now = self.check_step(t, h)?;
        let start = self.state.time;
        let done = self.or_restore(|instance| instance.tick_to(start, from_now, t + h));
        done.map_err(|fault| match fault {
            Fault::Refused(text) => Fault::Discarded(text), // a shorter step may be possible
            fault => fault,
        })
    }

    /// Calls `f`; on an error the state is as before.
    pub(super) fn or_restore<T>(
        &mut self,
        f: impl FnOnce(&mut Self) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let mut backup = self.backup.take();
        match &mut backup {
            Some(backup) => backup.copy(&self.state),
            None => backup = Some(Box::new(self.state.clone())),
        }
        let first = self.workspace.first;
        let done = f(self);
        if let (Err(_), Some(backup)) = (&done, &backup) {
            self.state.copy(backup);
            self.state.first = first;
            self.adopt_state();
        }
        self.backup = backup;
        done
    }

    /// Steps to `end`, from tick to tick.
    fn tick_to(&mut self, start: f64, h: f64, end: f64) -> Result<CompletedStep, Fault> {
        let near = 1e-9 * h + 8.0 * f64::EPSILON * end.abs();
        loop {
            self.tick_due()?;
            let (now, next) = (self.state.time, self.ticks().next());
            let until = if next < end - near { next } else { end };
            let mut step = self.do_plain_step(now, until - now)?;
            if step.is_whole {
                self.state.time = until;
                step.time = until;
            }
            let is_end = step.is_whole && until == end;
            if is_end || step.terminate || M::EVENTS.is_none() && !step.is_whole {
                step.is_whole &= is_end;
                return Ok(step);
            }
            if self.state.time <= start {
                return refuse!("t = {} s: the step makes no progress", shown(start));
            }
        }
    }

    /// Scheduled Execution: computes what a clock computes, at `t`, s. Returns whether the importer
    /// must be told of other clocks.
    pub(crate) fn activate(&mut self, number: u32, t: f64) -> Result<bool, Fault> {
        let k = self.input_clock(number)?;
        let name = M::CLOCKS[k].row.name;
        let (start, last) = (self.state.start, self.ticks().each[k].last);
        if !(t.is_finite() && t >= start) || t <= last {
            let after = if last.is_nan() {
                format!("at least the start time = {start} s")
            } else {
                format!("after its last one, {last} s")
            };
            return refuse!("activationTime = {t} s of clock `{name}` must be finite and {after}");
        }
        self.or_restore(|instance| instance.tick_alone(k, t))
    }

    /// Computes what the clock with this position computes.
    fn tick_alone(&mut self, k: usize, t: f64) -> Result<bool, Fault> {
        let clock = &M::CLOCKS[k];
        let state = &mut self.state;
        let (Some(model), Some(ticks)) = (&mut state.model, &mut state.ticks) else {
            unreachable!("it is initialized");
        };
        state.time = state.time.max(t);
        set_log_filter(self.log_filter, model);
        let tick = ticks.each[k].tick(clock, t, state.start);
        if let Err(error) = (clock.on_tick)(model, &state.parameters, &state.input.value, tick) {
            collect_log(&mut self.messages, model);
            return refuse!("t = {} s, clock `{}`: {error}", shown(t), clock.row.name);
        }
        collect_messages(&mut self.messages, model);
        let mut has_news = false;
        for (j, (clock, own)) in M::CLOCKS.iter().zip(&mut ticks.each).enumerate() {
            let was = (own.is_active, own.interval, own.qualifier);
            let is_told = own.follow(clock, model, &state.parameters, t, j == k)?;
            own.is_active = was.0 | is_told;
            let is_countdown = matches!(clock.timing, Timing::Countdown(_));
            has_news |= is_told || is_countdown && own.qualifier == Qualifier::Changed;
        }
        self.invalidate();
        Ok(has_news)
    }
}
