//! Ticks of an output clock that an event and an input clock cause, in Event Mode: none is lost,
//! whatever is set and read in the same instant.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

#[path = "../ways/mod.rs"]
#[expect(dead_code, reason = "for several tests")]
mod ways;

use fmu_export::prelude::*;
use std::ffi::c_int;
use ways::{C, Instance, Way, attribute};

#[derive(Input)]
pub struct Input {
    /// What is received
    #[fmu(unit = "1", clock = rx)]
    received: f64,
    /// A change is an event
    level: i32,
    /// Not clocked
    #[fmu(unit = "1")]
    u: f64,
}

/// A node that sends what it has received, if that is above 0, and at each change of the level
#[derive(State)]
#[fmu(input = Input, model_exchange)]
pub struct Node {
    /// A state
    #[fmu(unit = "1")]
    x: f64,
    /// What is sent
    #[fmu(unit = "1", clock = tx)]
    sent: f64,
    /// Ticks of rx
    #[fmu(discrete)]
    ticks: i32,
    #[fmu(skip)]
    seen: i32,
    #[fmu(skip)]
    sends: bool,
}

impl Node {
    fn rx(&mut self, _p: &(), u: &Input, _tick: Tick) -> Result<(), ModelError> {
        self.ticks += 1;
        (self.sent, self.sends) = (u.received, u.received > 0.0);
        Ok(())
    }
}

impl Ode for Node {
    const CLOCKS: &'static [Clock<Self>] = &[
        Clock::triggered("rx", "Something is there", Self::rx),
        Clock::output("tx", "Something is sent", |x: &mut Self| {
            std::mem::take(&mut x.sends)
        }),
    ];
    const INDICATORS: &'static [Variable<Self>] =
        &[Variable::indicator("never", "Never").unit("1")];

    fn indicators(&self, _p: &(), _u: &Input, _t: f64, z: &mut [f64]) {
        z[0] = 1.0;
    }

    fn derivative(&self, _p: &(), _u: &Input, _t: f64, dx: &mut Self) {
        dx.x = 1.0;
    }

    fn event(&mut self, _p: &(), u: &Input, _t: f64) -> Event {
        if self.seen != u.level {
            (self.seen, self.sent, self.sends) = (u.level, f64::from(u.level), true);
            self.x = self.x.min(self.sent);
        }
        Event::NONE
    }
}

fmu_export::export_fmu!(Node);

#[rustfmt::skip]
unsafe extern "C-unwind" {
    fn fmi3GetClock(c: C, vr: *const u32, n: usize, values: *mut bool) -> c_int;
    fn fmi3SetClock(c: C, vr: *const u32, n: usize, values: *const bool) -> c_int;
    fn fmi3SetInt32(c: C, vr: *const u32, n: usize, values: *const i32, n_values: usize) -> c_int;
    fn fmi3GetInt32(c: C, vr: *const u32, n: usize, values: *mut i32, n_values: usize) -> c_int;
    fn fmi3EnterStepMode(c: C) -> c_int;
    fn fmi3UpdateDiscreteStates(c: C, again: *mut bool, terminate: *mut bool, nominals: *mut bool, values: *mut bool, has_next: *mut bool, next: *mut f64) -> c_int;
    fn fmi3EnterContinuousTimeMode(c: C) -> c_int;
}

struct Fmu {
    at: Instance,
    xml: String,
}

impl Fmu {
    fn vr(&self, name: &str) -> u32 {
        let vr = attribute(&self.xml, &format!(" name=\"{name}\""), "valueReference");
        vr.unwrap().parse().unwrap()
    }

    fn set_clock(&self, on: bool) {
        assert_eq!(
            unsafe { fmi3SetClock(self.at.c, &self.vr("rx"), 1, &on) },
            0
        );
    }

    fn set_level(&self, level: i32) {
        let status = unsafe { fmi3SetInt32(self.at.c, &self.vr("level"), 1, &level, 1) };
        assert_eq!(status, 0);
    }

    fn set(&self, name: &str, value: f64) {
        assert_eq!(self.at.set(self.vr(name), value), 0);
    }

    /// Whether tx is active, and what is sent then.
    fn sent(&self) -> Option<f64> {
        let mut on = false;
        assert_eq!(
            unsafe { fmi3GetClock(self.at.c, &self.vr("tx"), 1, &mut on) },
            0
        );
        let sent = self.at.get::<1>(self.vr("sent"));
        assert_eq!(sent.is_ok(), on, "readable at ticks alone");
        sent.ok().map(|[value]| value)
    }

    fn ticks(&self) -> i32 {
        let mut value = -1;
        let status = unsafe { fmi3GetInt32(self.at.c, &self.vr("ticks"), 1, &mut value, 1) };
        assert_eq!(status, 0);
        value
    }

    fn leave(&self) -> c_int {
        unsafe {
            match self.at.way {
                Way::Exchange3 => fmi3EnterContinuousTimeMode(self.at.c),
                _ => fmi3EnterStepMode(self.at.c),
            }
        }
    }
}

fn each(test: impl Fn(Fmu)) {
    for way in [Way::Events3, Way::Exchange3] {
        let at = Instance::new::<Node>(way, false);
        at.enter_initialization();
        at.exit_initialization();
        assert!(!at.update().0);
        test(Fmu {
            at,
            xml: way.description::<Node>(),
        });
    }
}

/// The event's tick begins with the next instant, and lasts until the next update.
#[test]
fn a_tick_of_an_event_survives_what_is_set() {
    each(|fmu| {
        fmu.set_level(4);
        assert_eq!(fmu.sent(), None);
        assert!(fmu.at.update().0, "once more");
        fmu.set("u", 2.0);
        assert_eq!(fmu.sent(), Some(4.0));
        fmu.set("u", 3.0);
        assert_eq!(fmu.sent(), Some(4.0));
        assert!(!fmu.at.update().0);
        assert_eq!(fmu.sent(), None);
        assert_eq!(fmu.leave(), 0);
    });
}

/// A tick of rx in the same instant: with and without a tick of its own, and taken back.
#[test]
fn a_tick_of_an_event_and_one_of_a_clock_come_together() {
    each(|fmu| {
        for (received, sent) in [(7.0, 7.0), (-1.0, -1.0)] {
            let before = fmu.ticks();
            fmu.set_level(before + 5);
            assert!(fmu.at.update().0);
            fmu.set_clock(true);
            fmu.set("received", received);
            assert_eq!((fmu.sent(), fmu.ticks()), (Some(sent), before + 1));
            fmu.set_clock(false);
            assert_eq!(
                (fmu.sent(), fmu.ticks()),
                (Some(f64::from(before + 5)), before)
            );
            fmu.set_clock(true);
            assert_eq!(fmu.sent(), Some(sent));
            assert!(!fmu.at.update().0);
            assert_eq!((fmu.sent(), fmu.ticks()), (None, before + 1));
        }
    });
}

/// The level changes in the instant in which rx ticks: first the tick of rx, then that of the
/// event.
#[test]
fn an_event_in_the_same_call_ticks_afterwards() {
    each(|fmu| {
        fmu.set_clock(true);
        fmu.set("received", 2.0);
        fmu.set_level(9);
        assert_eq!(fmu.sent(), Some(2.0));
        assert!(fmu.at.update().0);
        assert_eq!((fmu.sent(), fmu.ticks()), (Some(9.0), 1));
        assert!(!fmu.at.update().0);
        assert_eq!(fmu.sent(), None);
    });
}

/// What an active clock has computed is kept by an update alone.
#[test]
fn event_mode_is_not_left_with_active_clocks() {
    each(|fmu| {
        fmu.set_clock(true);
        fmu.set("received", 2.0);
        assert_eq!(fmu.ticks(), 1);
        assert_eq!(fmu.leave(), 3);
        assert_eq!((fmu.sent(), fmu.ticks()), (Some(2.0), 1));
        fmu.set_clock(false);
        assert_eq!(fmu.leave(), 0);
        match fmu.at.way {
            Way::Exchange3 => {}
            _ => assert_eq!(fmu.at.step(0.0, 0.5).0, [false; 3]),
        }
        fmu.at.enter_events();
        assert_eq!((fmu.sent(), fmu.ticks()), (None, 0));
        fmu.set_clock(true);
        assert_eq!(fmu.ticks(), 1);
        fmu.set_clock(false);
        let x = fmu.at.get::<1>(fmu.vr("x")).unwrap()[0];
        let expected = if fmu.at.way == Way::Exchange3 {
            0.0
        } else {
            0.5
        };
        assert!((x - expected).abs() < 1e-12, "{x}");
    });
}

/// An event that moves a state says so, without a tick of an input clock.
#[test]
fn a_state_that_an_event_moves_is_told() {
    each(|fmu| {
        for (level, is_moved) in [(3, false), (-2, true)] {
            fmu.set_level(level);
            let mut flags = [false; 5];
            let [again, terminate, nominals, values, has_next] = flags.each_mut();
            let status = unsafe {
                fmi3UpdateDiscreteStates(
                    fmu.at.c, again, terminate, nominals, values, has_next, &mut 0.0,
                )
            };
            assert_eq!((status, flags), (0, [true, false, false, is_moved, false]));
            assert!(!fmu.at.update().0);
        }
    });
}
