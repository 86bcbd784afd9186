//! Event Mode of an instance of FMI 3.0, for `fmi3`: entering and leaving it, updates of discrete
//! states, and the clocks that tick in it.

use anyhow::{Result, bail};

use super::{Fmi3Instance, Mode};
use crate::answer::{Answer, Ended};
use crate::clocks::Interval;
use crate::fmi_instance::MAX_PASSES;
use crate::raw::Update;

impl Fmi3Instance {
    /// Asks the FMU for the interval of a clock.
    fn interval(&self, reference: u32) -> Result<Interval> {
        let (mut interval, mut qualifier) = (f64::NAN, 0);
        let status = (self.raw).get_interval(reference, &mut interval, Some(&mut qualifier));
        Answer::check(status, "fmi3GetIntervalDecimal")?;
        Ok(match qualifier {
            0 => Interval::Unknown,
            1 => Interval::Unchanged(interval),
            _ => Interval::Changed(interval),
        })
    }

    /// Finds in Initialization Mode when each clock ticks first.
    pub(super) fn start_clocks(&self) -> Result<()> {
        let start = self.tracked.time.get();
        let mut clocks = self.tracked.clocks.borrow_mut();
        for (clock, ticks) in self.plan.clocks.iter().zip(clocks.iter_mut()) {
            let (mut interval, mut shift) = (None, None);
            if clock.asks_fmu() {
                interval = Some(self.interval(clock.reference)?);
            }
            if clock.asks_fmu() && clock.is_periodic() {
                let shift = shift.insert(f64::NAN);
                let status = self.raw.get_shift(clock.reference, shift);
                Answer::check(status, "fmi3GetShiftDecimal")?;
            }
            clock.start(ticks, start, interval, shift)?;
        }
        Ok(())
    }

    /// In Event Mode: activates the clocks that are due by `until`, s, and sets their inputs.
    fn activate(&self, until: f64) -> Result<()> {
        let mut clocks = self.tracked.clocks.borrow_mut();
        let all = self.plan.clocks.iter().zip(clocks.iter_mut());
        for (clock, ticks) in all.filter(|(_, ticks)| ticks.next <= until) {
            self.set_clock(clock.reference, ticks.next)?;
            ticks.tick();
        }
        self.set_clocked()
    }

    /// Activates a clock, or the model partition of Scheduled Execution at `t`, s.
    fn set_clock(&self, reference: u32, t: f64) -> Result<()> {
        self.tracked.active.borrow_mut().push(reference);
        match self.plan.is_scheduled {
            true => self.compute_partition(reference, t),
            false => Answer::check(self.raw.set_clock(reference, true), "fmi3SetClock"),
        }
    }

    /// Computes the model partition of an active clock at `t`, s, for which its inputs are set.
    fn compute_partition(&self, reference: u32, t: f64) -> Result<()> {
        self.set_clocked()?;
        let status = self.raw.activate_model_partition(reference, t);
        Answer::check(status, "fmi3ActivateModelPartition")
    }

    /// Sets the inputs of active clocks to what the memory holds.
    fn set_clocked(&self) -> Result<()> {
        let mut inputs = self.plan.inputs.iter();
        inputs.try_for_each(|batch| self.set_if_accessible(batch))
    }

    /// Asks the connected output clocks that are not known to be active, each until it ticks: an
    /// FMU may tell of a tick only once. Returns whether one of them ticks.
    fn ask_clocks(&self) -> Result<bool> {
        let mut active = self.tracked.active.borrow_mut();
        let known = active.len();
        for reference in self.listened.borrow().iter() {
            let mut ticks = false;
            if !active.contains(reference) {
                let status = self.raw.get_clock(*reference, &mut ticks);
                Answer::check(status, "fmi3GetClock")?;
            }
            if ticks {
                active.push(*reference);
            }
        }
        Ok(active.len() > known)
    }

    /// Whether output clocks tick, 1 or 0; from now on they are asked in Event Mode.
    pub(super) fn get_clocks(&self, references: &[u32], values: &mut [f64]) -> Result<()> {
        let mut listened = self.listened.borrow_mut();
        for reference in references {
            if !listened.contains(reference) {
                listened.push(*reference);
            }
        }
        drop(listened);
        if self.tracked.mode.get() == Mode::Event {
            self.ask_clocks()?;
        }
        let active = self.tracked.active.borrow();
        for (value, reference) in values.iter_mut().zip(references) {
            *value = f64::from(u8::from(active.contains(reference)));
        }
        Ok(())
    }

    /// Activates input clocks whose value is not 0, in Event Mode, and sets their inputs. The inputs of
    /// model partitions may come after their ticks: [`Self::update_events`] computes them.
    pub(super) fn set_clocks(&self, references: &[u32], values: &[f64]) -> Result<()> {
        for (reference, _) in references.iter().zip(values).filter(|(_, on)| **on != 0.0) {
            if !self.tracked.active.borrow().contains(reference) {
                self.enter_events()?;
                if self.plan.is_scheduled {
                    self.tracked.active.borrow_mut().push(*reference);
                    self.waiting.borrow_mut().push(*reference);
                } else {
                    self.set_clock(*reference, self.tracked.time.get())?;
                }
            }
        }
        self.set_clocked()
    }

    /// The answer to [`crate::fmi_instance::Call::InEvents`].
    pub(super) fn in_events(&self) -> f64 {
        let has_event = self.has_event.get() || !self.tracked.active.borrow().is_empty();
        match self.tracked.mode.get() {
            Mode::Event => 1.0 + f64::from(u8::from(has_event)),
            _ => 0.0,
        }
    }

    pub(super) fn enter_events(&self) -> Result<()> {
        let is_there = self.tracked.mode.get() == Mode::Event;
        if !self.has_events || is_there {
            return Ok(());
        }
        self.tracked.mode.set(Mode::Event);
        if self.plan.is_scheduled {
            return Ok(());
        }
        Answer::check(self.raw.enter_event_mode(), "fmi3EnterEventMode")
    }

    /// Updates discrete states once in Event Mode; returns whether another update is needed, also
    /// because connected output clocks tick, which must be passed on before. Clocked outputs are read
    /// into the memory before, while their clock is active. A clock that ticks again at the same time
    /// is active afterwards.
    pub(super) fn update_events(&self) -> Result<bool> {
        if self.tracked.mode.get() != Mode::Event {
            return Ok(false);
        }
        for reference in self.waiting.borrow_mut().drain(..) {
            self.compute_partition(reference, self.tracked.time.get())?;
        }
        if self.ask_clocks()? {
            return Ok(true);
        }
        if !self.tracked.active.borrow().is_empty() {
            let computed = self.plan.computed.iter();
            for batch in computed.filter(|batch| self.is_accessible(batch)) {
                self.read_to_memory(batch)?;
            }
        }
        let (call, mut update) = ("fmi3UpdateDiscreteStates", Update::default());
        if !self.plan.is_scheduled {
            Answer::check(self.raw.update_discrete_states(&mut update), call)?;
        }
        self.tracked.active.borrow_mut().clear();
        self.has_event.set(false);
        let time = self.tracked.time.get();
        if update.terminates {
            bail!(Ended { call, time });
        }
        // Who integrates looks at it itself.
        let is_ahead = self.is_exchange || update.next > time;
        let announced = if is_ahead { update.next } else { f64::INFINITY };
        self.tracked.announced.set(announced);
        let mut is_due = false;
        let mut clocks = self.tracked.clocks.borrow_mut();
        let all = self.plan.clocks.iter().zip(clocks.iter_mut());
        for (clock, ticks) in all.filter(|(clock, _)| clock.asks_fmu()) {
            clock.update(ticks, time, &self.interval(clock.reference)?)?;
            is_due |= ticks.next <= time;
        }
        drop(clocks);
        if is_due {
            self.activate(time)?;
        }
        Ok(self.ask_clocks()? || update.again || is_due)
    }

    pub(super) fn leave_events(&self) -> Result<()> {
        if self.tracked.mode.get() != Mode::Event {
            return Ok(());
        }
        self.tracked.mode.set(Mode::Step);
        if self.plan.is_scheduled {
            return Ok(());
        }
        match self.is_exchange {
            true => {
                let status = self.raw.enter_continuous_time_mode();
                Answer::check(status, "fmi3EnterContinuousTimeMode")
            }
            false => Answer::check(self.raw.enter_step_mode(), "fmi3EnterStepMode"),
        }
    }

    /// Updates discrete states until no further update is needed, then leaves Event Mode. A tick of
    /// a connected output clock is an error: nobody passes it on here.
    pub(super) fn settle(&self) -> Result<()> {
        for _ in 0..MAX_PASSES {
            self.ask_clocks()?;
            let (active, mut outputs) = (self.tracked.active.borrow(), self.plan.outputs.iter());
            if let Some((name, _)) = outputs.find(|(_, reference)| active.contains(reference)) {
                bail!("its connected clock `{name}` ticks between two communication points");
            }
            drop(active);
            if !self.update_events()? {
                return self.leave_events();
            }
        }
        bail!("discrete states still change after {MAX_PASSES} passes of Event Mode")
    }

    /// Time of the next tick or announced event, s. Who integrates handles announced events itself.
    pub(super) fn next_event(&self) -> f64 {
        let clocks = self.tracked.clocks.borrow();
        let ticks = clocks.iter().map(|clock| clock.next);
        let announced = match self.is_exchange {
            true => f64::INFINITY,
            false => self.tracked.announced.get(),
        };
        ticks.fold(announced, f64::min)
    }

    /// Enters Event Mode at `t`, s, and activates the clocks that tick then.
    pub(super) fn tick(&self, t: f64, tolerance: f64) -> Result<()> {
        let clocks = self.tracked.clocks.borrow();
        let mut all = self.plan.clocks.iter().zip(clocks.iter());
        if let Some((clock, late)) = all.find(|(_, ticks)| ticks.next < t - tolerance) {
            bail!(
                "its clock `{}` ticks at {} s, between two communication points",
                clock.name,
                late.next
            );
        }
        drop(clocks);
        self.enter_events()?;
        self.activate(t + tolerance)
    }
}
