//! Event Mode and the clocks that tick in it.

use anyhow::{Result, bail};

use super::{Instance, Mode, PASSES};
use crate::answer::{Answer, Ended, call};
use crate::clocks::Interval;

impl Instance {
    /// What the FMU says of the interval of a clock.
    fn interval(&self, reference: u32) -> Result<Interval> {
        let (mut interval, mut qualifier, vr) = (f64::NAN, 0, [reference]);
        let (told, how) = (&raw mut interval, &raw mut qualifier);
        // SAFETY: one reference, and room for one interval and one qualifier.
        unsafe {
            let (i, vr) = (self.instance, vr.as_ptr());
            call!(self.api, fmi3GetIntervalDecimal(i, vr, 1, told, how))?;
        }
        Ok(match qualifier {
            0 => Interval::Unknown,
            1 => Interval::Unchanged(interval),
            _ => Interval::Changed(interval),
        })
    }

    /// When the clocks tick for the first time; in Initialization Mode.
    pub(super) fn begin_clocks(&self) -> Result<()> {
        let (api, i, start) = (&self.api, self.instance, self.known.time.get());
        let mut clocks = self.known.clocks.borrow_mut();
        for (clock, ticking) in self.plan.clocks.iter().zip(clocks.iter_mut()) {
            let (mut interval, mut shift, vr) = (None, None, [clock.reference]);
            if clock.asks() {
                interval = Some(self.interval(clock.reference)?);
            }
            if clock.asks() && clock.is_periodic() {
                let told = shift.insert(f64::NAN);
                // SAFETY: one reference and room for one value.
                unsafe { call!(api, fmi3GetShiftDecimal(i, vr.as_ptr(), 1, told))? };
            }
            clock.begin(ticking, start, interval, shift)?;
        }
        Ok(())
    }

    /// In Event Mode: the clocks that are due by `until`, s, tick; their inputs are set.
    fn activate(&self, until: f64) -> Result<()> {
        let (api, i) = (&self.api, self.instance);
        let mut clocks = self.known.clocks.borrow_mut();
        let all = self.plan.clocks.iter().zip(clocks.iter_mut());
        for (clock, ticking) in all.filter(|(_, ticking)| ticking.next <= until) {
            let (vr, on) = ([clock.reference], [true]);
            // SAFETY: one reference and one value.
            unsafe { call!(api, fmi3SetClock(i, vr.as_ptr(), 1, on.as_ptr()))? };
            ticking.tick();
            self.known.active.borrow_mut().push(clock.reference);
        }
        let mut open = self.plan.given.iter().filter(|batch| self.is_open(batch));
        open.try_for_each(|batch| self.set_remembered(batch))
    }

    pub(super) fn enter_events(&self) -> Result<()> {
        if !self.has_events || self.known.mode.replace(Mode::Event) == Mode::Event {
            return Ok(());
        }
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3EnterEventMode(self.instance)) }
    }

    /// What clocked variables have at the tick is remembered before it is over. A clock that ticks
    /// again at the same time is active afterwards.
    pub(super) fn update_events(&self) -> Result<bool> {
        if self.known.mode.get() != Mode::Event {
            return Ok(false);
        }
        if !self.known.active.borrow().is_empty() {
            let mut computed = self.plan.computed.iter();
            computed.try_for_each(|batch| match self.is_open(batch) {
                true => self.remember(batch),
                false => Ok(()),
            })?;
        }
        let [mut again, mut ends, mut nominals, mut values, mut has_next] = [false; 5];
        let mut next = 0.0;
        // SAFETY: the instance is alive; places for the results.
        unsafe {
            let (api, i, again, ends) = (&self.api, self.instance, &mut again, &mut ends);
            let (n, v) = (&mut nominals, &mut values);
            let (has_next, next) = (&mut has_next, &mut next);
            call!(
                api,
                fmi3UpdateDiscreteStates(i, again, ends, n, v, has_next, next)
            )?;
        }
        self.known.active.borrow_mut().clear();
        let time = self.known.time.get();
        if ends {
            let call = "fmi3UpdateDiscreteStates";
            bail!(Ended { call, time });
        }
        let is_ahead = has_next && next > time;
        let announced = if is_ahead { next } else { f64::INFINITY };
        self.known.announced.set(announced);
        let mut is_due = false;
        let mut clocks = self.known.clocks.borrow_mut();
        let all = self.plan.clocks.iter().zip(clocks.iter_mut());
        for (clock, ticking) in all.filter(|(clock, _)| clock.asks()) {
            clock.told(ticking, time, &self.interval(clock.reference)?)?;
            is_due |= ticking.next <= time;
        }
        drop(clocks);
        if is_due {
            self.activate(time)?;
        }
        Ok(again || is_due)
    }

    pub(super) fn leave_events(&self) -> Result<()> {
        if self.known.mode.get() != Mode::Event {
            return Ok(());
        }
        self.known.mode.set(Mode::Step);
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3EnterStepMode(self.instance)) }
    }

    pub(super) fn settle(&self) -> Result<()> {
        for _ in 0..PASSES {
            if !self.update_events()? {
                return self.leave_events();
            }
        }
        bail!("discrete states still change after {PASSES} passes of Event Mode")
    }

    pub(super) fn next_event(&self) -> f64 {
        let clocks = self.known.clocks.borrow();
        let ticks = clocks.iter().map(|clock| clock.next);
        ticks.fold(self.known.announced.get(), f64::min)
    }

    pub(super) fn tick(&self, t: f64, tolerance: f64) -> Result<()> {
        let clocks = self.known.clocks.borrow();
        let mut all = self.plan.clocks.iter().zip(clocks.iter());
        if let Some((clock, late)) = all.find(|(_, ticking)| ticking.next < t - tolerance) {
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
