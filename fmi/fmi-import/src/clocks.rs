//! The clocks of an FMU of FMI 3.0, when they tick, and which variables belong to them; the master
//! makes this plan of each FMU, and `fmi3` follows it.
//!
//! Clocked variables may be set and read only while a clock of theirs is active, that is at its
//! ticks in Event Mode. Between ticks the instance's memory has their values.

use anyhow::{Result, bail};
use fmi_description::{Causality, ClockInterval, ClockTiming, Description, Kind, Variable};
use serde::{Deserialize, Serialize};

use crate::batch::{Batch, Layout};

/// The time-based input clocks of an FMU, and its clocked variables.
#[derive(Debug, Default)]
pub struct ClockPlan {
    /// Clocks whose ticks the importer knows in advance.
    pub clocks: Vec<Clock>,
    /// Names and references of output clocks.
    pub(crate) outputs: Vec<(String, u32)>,
    /// Number of triggered input clocks.
    triggered: usize,
    /// Clocked inputs, set at a tick.
    pub(crate) inputs: Vec<Batch>,
    /// Clocked outputs and local variables, read at a tick.
    pub(crate) computed: Vec<Batch>,
}

impl ClockPlan {
    /// From a description that has its variables [by element](Description::by_element).
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
                None if v.kind == Kind::Clock && v.causality == Causality::Output => {
                    plan.outputs.push((v.name.clone(), v.reference));
                }
                None if is_triggered(v) => plan.triggered += 1,
                None if v.clocks.is_empty() || v.kind == Kind::Clock => {}
                None if v.is_input() => plan.inputs.push(batch()),
                None if v.is_computed() => plan.computed.push(batch()),
                None => {}
            }
        }
        plan
    }

    /// How many clocks there are.
    pub fn count(&self) -> usize {
        self.clocks.len() + self.outputs.len() + self.triggered
    }
}

/// Timing of a clock whose ticks the importer knows in advance.
fn timing(v: &Variable) -> Option<ClockTiming> {
    v.timing.filter(|_| v.is_input() && !is_triggered(v))
}

/// Whether this is an input clock whose ticks no time determines.
pub fn is_triggered(v: &Variable) -> bool {
    let is_triggered = |t: &ClockTiming| t.interval == ClockInterval::Triggered;
    v.kind == Kind::Clock && v.is_input() && v.timing.as_ref().is_none_or(is_triggered)
}

/// The interval of a clock as the FMU reports it.
pub enum Interval {
    Unknown,
    /// s.
    Unchanged(f64),
    /// s.
    Changed(f64),
}

/// A clock whose ticks the importer knows in advance.
#[derive(Debug)]
pub struct Clock {
    pub name: String,
    pub reference: u32,
    timing: ClockTiming,
}

/// When a clock of one instance ticks, as far as is known.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct TickTimes {
    /// s; None for an aperiodic clock.
    period: Option<f64>,
    /// Time from which the ticks of a periodic clock are counted, s.
    origin: f64,
    count: u32,
    /// Time of the next tick, s; infinite while it is not known.
    pub next: f64,
}

impl Clock {
    /// Whether it ticks periodically.
    pub fn is_periodic(&self) -> bool {
        let aperiodic = [ClockInterval::Changing, ClockInterval::Countdown];
        !aperiodic.contains(&self.timing.interval)
    }

    fn period(&self) -> Option<f64> {
        self.timing.period.filter(|_| self.is_periodic())
    }

    /// Whether the FMU must be asked for its interval.
    pub fn asks_fmu(&self) -> bool {
        self.timing.interval != ClockInterval::Constant && self.period().is_none()
    }

    /// Its tick times before initialization: none is known.
    pub fn initial_ticks(&self) -> TickTimes {
        TickTimes {
            period: self.period(),
            origin: f64::NAN,
            count: 0,
            next: f64::INFINITY,
        }
    }

    /// Sets the first tick of a run that starts at `start`, s. `interval` and, for a periodic
    /// clock, `shift`, s, are what the FMU reported if it was asked.
    pub fn start(
        &self,
        ticks: &mut TickTimes,
        start: f64,
        interval: Option<Interval>,
        shift: Option<f64>,
    ) -> Result<()> {
        let told = match interval {
            Some(Interval::Changed(s) | Interval::Unchanged(s)) => Some(s),
            Some(Interval::Unknown) | None => None,
        };
        ticks.count = 0;
        if self.is_periodic() {
            ticks.period = told.or(ticks.period);
            ticks.origin = start + shift.unwrap_or(self.timing.shift);
            ticks.next = ticks.origin;
        } else {
            ticks.next = told.map_or(f64::INFINITY, |s| start + s);
        }
        self.check(told.or(ticks.period), ticks.next)
    }

    /// Takes over the interval that the FMU reports after an event at `now`, s.
    pub fn update(&self, ticks: &mut TickTimes, now: f64, interval: &Interval) -> Result<()> {
        let Interval::Changed(interval) = *interval else {
            return Ok(());
        };
        if self.is_periodic() {
            (ticks.period, ticks.origin, ticks.count) = (Some(interval), now, 1);
        }
        ticks.next = now + interval;
        self.check(Some(interval), ticks.next)
    }

    /// Checks the interval, and the time of the next tick, both s.
    fn check(&self, interval: Option<f64>, next: f64) -> Result<()> {
        let is_sound = match interval {
            Some(s) if self.is_periodic() => s.is_finite() && s > 0.0,
            Some(s) => s >= 0.0,
            None => !self.is_periodic(),
        };
        if !is_sound || next.is_nan() {
            let interval = interval.map_or("none".into(), |s| format!("{s} s"));
            bail!(
                "its clock `{}` has the interval {interval}, and ticks next at {next} s",
                self.name
            );
        }
        Ok(())
    }
}

impl TickTimes {
    /// Moves on to the tick after the present one.
    pub fn tick(&mut self) {
        self.count += 1;
        self.next = match self.period {
            Some(period) => self.origin + f64::from(self.count) * period,
            None => f64::INFINITY,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock, and when it ticks.
    fn clock(interval: ClockInterval, period: Option<f64>) -> (Clock, TickTimes) {
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
        let ticks = clock.initial_ticks();
        (clock, ticks)
    }

    fn next(ticks: &mut TickTimes, count: usize) -> Vec<f64> {
        (0..count).map(|_| (ticks.next, ticks.tick()).0).collect()
    }

    #[test]
    fn a_periodic_clock_counts_from_its_first_tick() {
        let (own, mut ticks) = clock(ClockInterval::Constant, Some(0.1));
        own.start(&mut ticks, 2.0, None, None).unwrap();
        let expected = [2.25, 2.25 + 0.1, 2.25 + 0.2, 2.25 + 3.0 * 0.1];
        assert_eq!(
            (own.asks_fmu(), next(&mut ticks, 4)),
            (false, expected.to_vec())
        );
        let (asked, mut ticks) = clock(ClockInterval::Tunable, None);
        let interval = Some(Interval::Changed(0.5));
        asked.start(&mut ticks, 2.0, interval, Some(1.0)).unwrap();
        assert_eq!(
            (asked.asks_fmu(), next(&mut ticks, 2)),
            (true, vec![3.0, 3.5])
        );
        // A new interval counts from the event that brings it.
        asked
            .update(&mut ticks, 3.75, &Interval::Unchanged(0.5))
            .unwrap();
        assert_eq!(ticks.next, 4.0);
        asked
            .update(&mut ticks, 3.75, &Interval::Changed(2.0))
            .unwrap();
        assert_eq!(next(&mut ticks, 2), [5.75, 7.75]);
        for wrong in [0.0, f64::NAN, -1.0] {
            let (clock, mut ticks) = clock(ClockInterval::Fixed, None);
            let interval = Some(Interval::Changed(wrong));
            let error = clock.start(&mut ticks, 0.0, interval, Some(0.0));
            let error = error.unwrap_err().to_string();
            assert!(error.contains("its clock `c` has the interval"), "{error}");
        }
    }

    #[test]
    fn an_aperiodic_clock_ticks_when_the_fmu_says() {
        let (clock, mut ticks) = clock(ClockInterval::Countdown, None);
        let unknown = Some(Interval::Unknown);
        clock.start(&mut ticks, 2.0, unknown, None).unwrap();
        assert_eq!(ticks.next, f64::INFINITY);
        clock
            .update(&mut ticks, 3.0, &Interval::Changed(0.0))
            .unwrap();
        assert_eq!(next(&mut ticks, 2), [3.0, f64::INFINITY]);
        clock.update(&mut ticks, 3.0, &Interval::Unknown).unwrap();
        assert_eq!(ticks.next, f64::INFINITY);
        for (interval, next) in [(f64::NAN, "NaN"), (-1.0, "2")] {
            let told = Interval::Changed(interval);
            let text =
                format!("its clock `c` has the interval {interval} s, and ticks next at {next} s");
            let error = clock.update(&mut ticks, 3.0, &told).unwrap_err();
            assert_eq!(error.to_string(), text);
            let error = clock.start(&mut ticks, 3.0, Some(told), None);
            assert_eq!(error.unwrap_err().to_string(), text);
        }
        let (periodic, mut ticks) = self::clock(ClockInterval::Constant, Some(0.5));
        let error = periodic.start(&mut ticks, 3.0, None, Some(f64::NAN));
        let text = "its clock `c` has the interval 0.5 s, and ticks next at NaN s";
        assert_eq!(error.unwrap_err().to_string(), text);
    }
}
