//! When the clocks of an instance of FMI 3.0 tick, and which variables belong to them.
//!
//! Clocked variables may be set and read while a clock of theirs is active only, that is at its
//! ticks, in Event Mode. Between ticks an instance remembers what they were given and had.

use anyhow::{Result, bail};
use fmi_description::{ClockInterval, ClockTiming, Description, Kind, Variable};
use serde::{Deserialize, Serialize};

use crate::batch::{Batch, Layout};

/// The clocks that time alone makes tick, and the clocked variables, of an FMU.
#[derive(Debug, Default)]
pub struct Plan {
    /// Clocks.
    pub clocks: Vec<Clock>,
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
                Some(timing) => plan.clocks.push(Clock {
                    name: v.name.clone(),
                    reference: v.reference,
                    timing,
                }),
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

/// A clock whose ticks the importer knows in advance.
#[derive(Debug)]
pub struct Clock {
    /// Name.
    pub name: String,
    /// Value reference.
    pub reference: u32,
    timing: ClockTiming,
}

/// When a clock of an instance ticks, as far as is known.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Ticking {
    /// s; none of an aperiodic clock.
    period: Option<f64>,
    /// Ticks are counted from here, s; of a periodic clock the first one is here.
    origin: f64,
    ticks: u32,
    /// Time of the next tick, s; infinite where it is not known.
    pub next: f64,
}

impl Clock {
    /// Whether its ticks are a period apart.
    pub fn is_periodic(&self) -> bool {
        let aperiodic = [ClockInterval::Changing, ClockInterval::Countdown];
        !aperiodic.contains(&self.timing.interval)
    }

    fn period(&self) -> Option<f64> {
        self.timing.period.filter(|_| self.is_periodic())
    }

    /// Where the FMU is asked for intervals.
    pub fn asks(&self) -> bool {
        self.timing.interval != ClockInterval::Constant && self.period().is_none()
    }

    /// In Initialization Mode, before anything is known of it.
    pub fn ticking(&self) -> Ticking {
        Ticking {
            period: self.period(),
            origin: f64::NAN,
            ticks: 0,
            next: f64::INFINITY,
        }
    }

    /// The run starts at `start`, s. An FMU that was asked told the `interval` and, of a periodic
    /// clock, the `shift`, s.
    pub fn begin(
        &self,
        ticking: &mut Ticking,
        start: f64,
        interval: Option<Interval>,
        shift: Option<f64>,
    ) -> Result<()> {
        let told = match interval {
            Some(Interval::Changed(s) | Interval::Unchanged(s)) => Some(s),
            Some(Interval::Unknown) | None => None,
        };
        ticking.ticks = 0;
        if self.is_periodic() {
            ticking.period = told.or(ticking.period);
            ticking.origin = start + shift.unwrap_or(self.timing.shift);
            ticking.next = ticking.origin;
        } else {
            ticking.next = told.map_or(f64::INFINITY, |s| start + s);
        }
        self.check(ticking)
    }

    /// What the FMU tells of it after an event at `now`, s.
    pub fn told(&self, ticking: &mut Ticking, now: f64, interval: &Interval) -> Result<()> {
        let Interval::Changed(interval) = *interval else {
            return Ok(());
        };
        if self.is_periodic() {
            (ticking.period, ticking.origin, ticking.ticks) = (Some(interval), now, 1);
        }
        ticking.next = now + interval;
        self.check(ticking)
    }

    fn check(&self, Ticking { period, next, .. }: &Ticking) -> Result<()> {
        let is_sound = period.is_some_and(|s| s.is_finite() && s > 0.0);
        if self.is_periodic() && !is_sound || next.is_nan() {
            let told = period.map_or("none".into(), |s| format!("{s} s"));
            bail!("its clock `{}` has the interval {told}", self.name);
        }
        Ok(())
    }
}

impl Ticking {
    /// It ticks now.
    pub fn tick(&mut self) {
        self.ticks += 1;
        self.next = match self.period {
            Some(period) => self.origin + f64::from(self.ticks) * period,
            None => f64::INFINITY,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock, and when it ticks.
    fn clock(interval: ClockInterval, period: Option<f64>) -> (Clock, Ticking) {
        let timing = ClockTiming {
            interval,
            period,
            shift: 0.25,
        };
        let clock = Clock {
            name: "c".into(),
            reference: 7,
            timing,
        };
        let ticking = clock.ticking();
        (clock, ticking)
    }

    fn next(ticking: &mut Ticking, count: usize) -> Vec<f64> {
        (0..count)
            .map(|_| (ticking.next, ticking.tick()).0)
            .collect()
    }

    #[test]
    fn a_periodic_clock_counts_from_its_first_tick() {
        let (own, mut ticks) = clock(ClockInterval::Constant, Some(0.1));
        own.begin(&mut ticks, 2.0, None, None).unwrap();
        let expected = [2.25, 2.25 + 0.1, 2.25 + 0.2, 2.25 + 3.0 * 0.1];
        assert_eq!(
            (own.asks(), next(&mut ticks, 4)),
            (false, expected.to_vec())
        );
        let (asked, mut ticks) = clock(ClockInterval::Tunable, None);
        let interval = Some(Interval::Changed(0.5));
        asked.begin(&mut ticks, 2.0, interval, Some(1.0)).unwrap();
        assert_eq!((asked.asks(), next(&mut ticks, 2)), (true, vec![3.0, 3.5]));
        // A new interval counts from the event that brings it.
        asked
            .told(&mut ticks, 3.75, &Interval::Unchanged(0.5))
            .unwrap();
        assert_eq!(ticks.next, 4.0);
        asked
            .told(&mut ticks, 3.75, &Interval::Changed(2.0))
            .unwrap();
        assert_eq!(next(&mut ticks, 2), [5.75, 7.75]);
        for wrong in [0.0, f64::NAN, -1.0] {
            let (clock, mut ticks) = clock(ClockInterval::Fixed, None);
            let interval = Some(Interval::Changed(wrong));
            let error = clock.begin(&mut ticks, 0.0, interval, Some(0.0));
            let error = error.unwrap_err().to_string();
            assert!(error.contains("its clock `c` has the interval"), "{error}");
        }
    }

    #[test]
    fn an_aperiodic_clock_ticks_when_the_fmu_says() {
        let (clock, mut ticks) = clock(ClockInterval::Countdown, None);
        let unknown = Some(Interval::Unknown);
        clock.begin(&mut ticks, 2.0, unknown, None).unwrap();
        assert_eq!(ticks.next, f64::INFINITY);
        clock
            .told(&mut ticks, 3.0, &Interval::Changed(0.0))
            .unwrap();
        assert_eq!(next(&mut ticks, 2), [3.0, f64::INFINITY]);
        clock.told(&mut ticks, 3.0, &Interval::Unknown).unwrap();
        assert_eq!(ticks.next, f64::INFINITY);
    }
}
