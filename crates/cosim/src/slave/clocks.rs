//! When the clocks of an instance of FMI 3.0 tick, and which variables belong to them.
//!
//! Clocked variables may be set and read while a clock of theirs is active only, that is at its
//! ticks, in Event Mode. Between ticks an instance remembers what they were given and had.

use anyhow::{Result, bail};
use fmu_description::{ClockInterval, ClockTiming, Description, Kind, Variable};
use serde::{Deserialize, Serialize};

use crate::batch::{Batch, Layout};

/// The clocks that time alone makes tick, and the clocked variables, of an FMU.
#[derive(Debug, Default)]
pub struct Plan {
    /// Names, references and timing.
    pub clocks: Vec<(String, u32, ClockTiming)>,
    /// Inputs, set at a tick.
    pub given: Vec<Batch>,
    /// Outputs and local variables, read at a tick.
    pub computed: Vec<Batch>,
}

impl Plan {
    /// Of a description that has its variables by element.
    pub fn new(description: &Description, layout: &Layout) -> Self {
        let mut plan = Self::default();
        for (k, v) in description.variables.iter().enumerate() {
            let batch = || Batch::new(description, layout, vec![k]);
            match timing(v) {
                Some(timing) => plan.clocks.push((v.name.clone(), v.reference, timing)),
                None if v.clocks.is_empty() || v.kind == Kind::Clock => {}
                None if v.is_input() => plan.given.push(batch()),
                None if v.is_computed() => plan.computed.push(batch()),
                None => {}
            }
        }
        plan
    }
}

/// Timing of a clock whose ticks the importer knows in advance.
fn timing(v: &Variable) -> Option<ClockTiming> {
    v.timing.filter(|_| v.is_input() && !is_triggered(v))
}

/// An input clock that ticks at no time that is known in advance.
pub fn is_triggered(v: &Variable) -> bool {
    let is_triggered = |t: &ClockTiming| t.interval == ClockInterval::Triggered;
    v.kind == Kind::Clock && v.is_input() && v.timing.as_ref().is_none_or(is_triggered)
}

/// What an FMU answers when it is asked for the interval of a clock.
pub enum Interval {
    /// `fmi3IntervalNotYetKnown`.
    Unknown,
    /// `fmi3IntervalUnchanged`, s.
    Unchanged(f64),
    /// `fmi3IntervalChanged`, s.
    Changed(f64),
}

/// A clock of an instance.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Name.
    pub name: String,
    /// Value reference.
    pub reference: u32,
    /// Where the FMU is asked for intervals.
    pub asks: bool,
    timing: ClockTiming,
    /// Ticks are counted from here, s; of a periodic clock the first one is here.
    origin: f64,
    ticks: u32,
    /// Time of the next tick, s; infinite where it is not known.
    pub next: f64,
}

/// What changes of a clock in a run: period, s, origin, ticks and next tick.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Ticking(Option<f64>, f64, u32, f64);

impl Clock {
    /// A clock in Initialization Mode, before anything is known of it.
    pub fn new((name, reference, timing): &(String, u32, ClockTiming)) -> Self {
        let mut clock = Self {
            name: name.clone(),
            reference: *reference,
            asks: false,
            timing: *timing,
            origin: f64::NAN,
            ticks: 0,
            next: f64::INFINITY,
        };
        clock.timing.period = timing.period.filter(|_| clock.is_periodic());
        let is_constant = timing.interval == ClockInterval::Constant;
        clock.asks = !is_constant && clock.timing.period.is_none();
        clock
    }

    /// What changes of it.
    pub fn ticking(&self) -> Ticking {
        Ticking(self.timing.period, self.origin, self.ticks, self.next)
    }

    /// As if this were what it came to.
    pub fn go_on(&mut self, saved: Ticking) {
        let Ticking(period, ..) = saved;
        (self.timing.period, self.origin, self.ticks, self.next) =
            (period, saved.1, saved.2, saved.3);
    }

    /// Whether its ticks are a period apart.
    pub fn is_periodic(&self) -> bool {
        let aperiodic = [ClockInterval::Changing, ClockInterval::Countdown];
        !aperiodic.contains(&self.timing.interval)
    }

    /// The run starts at `start`, s. An FMU that was asked told the `interval` and, of a periodic
    /// clock, the `shift`, s.
    pub fn begin(
        &mut self,
        start: f64,
        interval: Option<Interval>,
        shift: Option<f64>,
    ) -> Result<()> {
        let told = match interval {
            Some(Interval::Changed(s) | Interval::Unchanged(s)) => Some(s),
            Some(Interval::Unknown) | None => None,
        };
        self.ticks = 0;
        if self.is_periodic() {
            self.timing.period = told.or(self.timing.period);
            self.origin = start + shift.unwrap_or(self.timing.shift);
            self.next = self.origin;
        } else {
            self.next = told.map_or(f64::INFINITY, |s| start + s);
        }
        self.check()
    }

    /// It ticks now.
    pub fn tick(&mut self) {
        self.ticks += 1;
        self.next = match self.timing.period {
            Some(period) => self.origin + f64::from(self.ticks) * period,
            None => f64::INFINITY,
        };
    }

    /// What the FMU tells of it after an event at `now`, s.
    pub fn told(&mut self, now: f64, interval: &Interval) -> Result<()> {
        let Interval::Changed(interval) = *interval else {
            return Ok(());
        };
        if self.is_periodic() {
            (self.timing.period, self.origin, self.ticks) = (Some(interval), now, 1);
        }
        self.next = now + interval;
        self.check()
    }

    fn check(&self) -> Result<()> {
        let period = self.timing.period.filter(|s| s.is_finite() && *s > 0.0);
        if self.is_periodic() && period.is_none() || self.next.is_nan() {
            let told = self
                .timing
                .period
                .map_or("none".into(), |s| format!("{s} s"));
            bail!("its clock `{}` has the interval {told}", self.name);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(interval: ClockInterval, period: Option<f64>) -> Clock {
        let timing = ClockTiming {
            interval,
            period,
            shift: 0.25,
        };
        Clock::new(&("c".into(), 7, timing))
    }

    fn next(clock: &mut Clock, count: usize) -> Vec<f64> {
        (0..count).map(|_| (clock.next, clock.tick()).0).collect()
    }

    #[test]
    fn a_periodic_clock_counts_from_its_first_tick() {
        let mut own = clock(ClockInterval::Constant, Some(0.1));
        own.begin(2.0, None, None).unwrap();
        let expected = [2.25, 2.25 + 0.1, 2.25 + 0.2, 2.25 + 3.0 * 0.1];
        assert_eq!((own.asks, next(&mut own, 4)), (false, expected.to_vec()));
        let mut asked = clock(ClockInterval::Tunable, None);
        asked
            .begin(2.0, Some(Interval::Changed(0.5)), Some(1.0))
            .unwrap();
        assert_eq!((asked.asks, next(&mut asked, 2)), (true, vec![3.0, 3.5]));
        // A new interval counts from the event that brings it.
        asked.told(3.75, &Interval::Unchanged(0.5)).unwrap();
        assert_eq!(asked.next, 4.0);
        asked.told(3.75, &Interval::Changed(2.0)).unwrap();
        assert_eq!(next(&mut asked, 2), [5.75, 7.75]);
        for wrong in [0.0, f64::NAN, -1.0] {
            let mut clock = clock(ClockInterval::Fixed, None);
            let error = clock.begin(0.0, Some(Interval::Changed(wrong)), Some(0.0));
            assert!(
                error
                    .unwrap_err()
                    .to_string()
                    .contains("its clock `c` has the interval")
            );
        }
    }

    #[test]
    fn an_aperiodic_clock_ticks_when_the_fmu_says() {
        let mut clock = clock(ClockInterval::Countdown, None);
        clock.begin(2.0, Some(Interval::Unknown), None).unwrap();
        assert_eq!(clock.next, f64::INFINITY);
        clock.told(3.0, &Interval::Changed(0.0)).unwrap();
        assert_eq!(next(&mut clock, 2), [3.0, f64::INFINITY]);
        clock.told(3.0, &Interval::Unknown).unwrap();
        assert_eq!(clock.next, f64::INFINITY);
    }
}
