//! A model with a countdown clock alone, where nobody ticks it: as time events of Model Exchange,
//! and in steps.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

#[path = "../ways/mod.rs"]
#[expect(dead_code, reason = "for several tests")]
mod ways;

use fmu_export::prelude::*;
use std::ffi::c_int;
use ways::{C, Instance, Way, attribute};

#[derive(Input)]
pub struct Input {
    /// A change starts the countdown of as many seconds
    #[fmu(unit = "s")]
    u: f64,
}

/// Counts its ticks; what starts at 0.5 s has two at once, and one of less than 0 s fails
#[derive(State)]
#[fmu(input = Input, model_exchange)]
pub struct Countdown {
    /// A state
    #[fmu(unit = "1")]
    x: f64,
    /// Number of ticks
    #[fmu(unit = "1", discrete)]
    count: f64,
    /// Time of the last tick
    #[fmu(unit = "s", discrete)]
    last: f64,
    #[fmu(skip)]
    seen: f64,
    #[fmu(skip)]
    delay: Option<f64>,
}

impl Countdown {
    fn tick(&mut self, _p: &(), u: &Input, tick: Tick) -> Result<(), ModelError> {
        (self.count, self.last) = (self.count + 1.0, tick.time);
        if u.u == 0.5 && self.count == 1.0 {
            self.delay = Some(0.0);
        }
        match u.u < 0.0 {
            true => Err(ModelError::new("no time is negative")),
            false => Ok(()),
        }
    }
}

impl Ode for Countdown {
    const CLOCKS: &'static [Clock<Self>] = &[Clock::countdown(
        "alarm",
        "After a change",
        |x| x.delay.take(),
        Self::tick,
    )];
    const INDICATORS: &'static [Variable<Self>] =
        &[Variable::indicator("never", "Never").unit("1")];

    fn indicators(&self, _p: &(), _u: &Input, _t: f64, z: &mut [f64]) {
        z[0] = 1.0;
    }

    fn derivative(&self, _p: &(), _u: &Input, _t: f64, dx: &mut Self) {
        dx.x = 1.0;
    }

    fn event(&mut self, _p: &(), u: &Input, _t: f64) -> Event {
        if self.seen != u.u {
            (self.seen, self.delay) = (u.u, Some(u.u.abs()));
        }
        Event::NONE
    }
}

fmu_export::export_fmu!(Countdown);

#[rustfmt::skip]
unsafe extern "C-unwind" {
    fn fmi2DoStep(c: C, t: f64, h: f64, no_set: c_int) -> c_int;
    fn fmi3DoStep(c: C, t: f64, h: f64, no_set: bool, event: *mut bool, terminate: *mut bool, early: *mut bool, last: *mut f64) -> c_int;
}

fn get(fmu: &Instance, name: &str) -> f64 {
    fmu.get::<1>(vr(fmu, name)).unwrap()[0]
}

fn vr(fmu: &Instance, name: &str) -> u32 {
    let xml = fmu.way.description::<Countdown>();
    let vr = attribute(&xml, &format!(" name=\"{name}\""), "valueReference");
    vr.unwrap().parse().unwrap()
}

fn started(way: Way) -> Instance {
    let fmu = Instance::new::<Countdown>(way, false);
    fmu.enter_initialization();
    fmu.exit_initialization();
    fmu
}

/// At 0.75 s there was one tick; the state is the solver's.
fn ticked_once(fmu: &Instance, at: f64) {
    let [count, last, x] = ["count", "last", "x"].map(|name| get(fmu, name));
    assert_eq!((count, last), (1.0, at), "{:?}", fmu.way);
    assert!((x - 0.75).abs() < 1e-9, "{x}");
}

#[test]
fn ticks_are_time_events_of_model_exchange() {
    let fmu = started(Way::Exchange2);
    assert_eq!(fmu.update(), (false, None));
    assert_eq!(fmu.set(vr(&fmu, "u"), 0.5), 0);
    assert_eq!(fmu.update(), (false, Some(0.5)));
    fmu.enter_continuous_time();
    fmu.set_time(0.5, 0.5);
    fmu.enter_events();
    assert!(fmu.update().0, "it ticks once more");
    assert_eq!(fmu.update(), (false, None));
    assert_eq!([get(&fmu, "count"), get(&fmu, "last")], [2.0, 0.5]);
}

/// An input that was set between steps starts the countdown at the start of the step.
#[test]
fn a_step_ticks_what_starts_with_it() {
    for way in [Way::Steps2, Way::Steps3] {
        let fmu = started(way);
        fmu.step(0.0, 0.25);
        assert_eq!(fmu.set(vr(&fmu, "u"), 0.125), 0);
        fmu.step(0.25, 0.5);
        ticked_once(&fmu, 0.375);
    }
}

/// A step in which a tick fails leaves the instance as it was.
#[test]
fn a_tick_that_fails_undoes_the_step() {
    for way in [Way::Steps2, Way::Steps3] {
        let fmu = started(way);
        fmu.step(0.0, 0.25);
        assert_eq!(fmu.set(vr(&fmu, "u"), -0.125), 0);
        let (mut flags, mut last) = ([false; 3], 0.0);
        let [a, b, c] = flags.each_mut();
        let status = unsafe {
            match way.is_2() {
                true => fmi2DoStep(fmu.c, 0.25, 0.5, 1),
                false => fmi3DoStep(fmu.c, 0.25, 0.5, true, a, b, c, &mut last),
            }
        };
        assert_eq!(status, 2, "{way:?}");
        assert_eq!(fmu.set(vr(&fmu, "u"), 0.0625), 0);
        fmu.step(0.25, 0.5);
        ticked_once(&fmu, 0.3125);
    }
}
