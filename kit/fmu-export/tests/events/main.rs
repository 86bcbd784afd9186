//! Events are the same in both interfaces and both versions of FMI: one model, driven as importers do,
//! by C name. And events that accumulate.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

mod ball;
mod model;
mod relay;
mod solved;
#[path = "../ways/mod.rs"]
mod ways;

use fmu_export::check;
use model::{MOST, Sampler};
use std::ffi::c_int;
use ways::{C, Instance, Way};

unsafe extern "C-unwind" {
    fn fmi2GetDerivatives(_: C, _: *mut f64, _: usize) -> c_int;
    fn fmi3GetContinuousStateDerivatives(_: C, _: *mut f64, _: usize) -> c_int;
}

/// The value references of vectors are those of their first elements.
const W: u32 = 0;
const X: u32 = 1;
const TIMES: u32 = 2;
const CLOCK: u32 = TIMES + 3 * MOST as u32;

struct Fmu(Instance);

impl Fmu {
    fn new(way: Way) -> Self {
        Self(Instance::new::<Sampler>(way, false))
    }

    fn set(&self, value: f64) {
        assert_eq!(self.0.set(W, value), 0);
    }

    fn get<const N: usize>(&self, vr: u32) -> [f64; N] {
        self.0.get(vr).unwrap()
    }

    /// Updates the discrete states; returns the time of the next event, infinite if there is none.
    fn update(&self) -> f64 {
        loop {
            let (again, next) = self.0.update();
            if !again {
                return next.unwrap_or(f64::INFINITY);
            }
        }
    }

    /// Model Exchange from `t` to `end`, where the next event is at `next`; the rate is constant
    /// between events, so that Euler's method and straight lines are exact.
    fn integrate(&self, mut t: f64, end: f64, mut next: f64) -> f64 {
        loop {
            self.0.enter_continuous_time();
            let until = end.min(next);
            let x = self.0.state();
            let rate = self
                .0
                .read(fmi2GetDerivatives, fmi3GetContinuousStateDerivatives);
            let before = self.0.indicator();
            self.0.set_time(until, x + rate * (until - t));
            let after = self.0.indicator();
            let is_crossed = (before > 0.0) != (after > 0.0);
            let from = t;
            t = until;
            if is_crossed {
                t = from + (until - from) * before / (before - after);
                while {
                    self.0.set_time(t, x + rate * (t - from));
                    (self.0.indicator() > 0.0) == (before > 0.0)
                } {
                    t += f64::EPSILON * t;
                }
            }
            assert_eq!(
                self.get(CLOCK),
                [t, 2.0 * t],
                "outputs know the time that is set"
            );
            if !is_crossed && t == end {
                return next;
            }
            self.0.enter_events();
            next = self.update();
        }
    }

    /// A communication step; whether it says that events have to be handled.
    fn step(&self, t: f64, h: f64) -> bool {
        let ([has_event, terminates, is_early], _) = self.0.step(t, h);
        assert_eq!((terminates, is_early), (false, false));
        has_event
    }

    /// The events so far: times, kinds and values.
    fn events(&self) -> Vec<[f64; 3]> {
        let size = MOST as u32;
        let [times, kinds, values] =
            [TIMES, TIMES + size, TIMES + 2 * size].map(|vr| self.get::<MOST>(vr));
        let all = (0..MOST).map(|k| [times[k], kinds[k], values[k]]);
        all.take_while(|event| event[1] > 0.0).collect()
    }
}

/// What the model is given at a communication point.
fn input(t: f64) -> f64 {
    1.0 + (20.0 * t).round()
}

/// The events of a run with 20 steps of 50 ms, and what was seen on the way.
fn run(way: Way) -> (Vec<[f64; 3]>, Vec<f64>) {
    let fmu = Fmu::new(way);
    fmu.0.enter_initialization();
    fmu.set(input(0.0));
    fmu.0.exit_initialization();
    let has_updates = !matches!(way, Way::Steps2 | Way::Steps3);
    let (mut next, mut seen) = (f64::NAN, Vec::new());
    if has_updates {
        next = fmu.update();
        seen.push(next);
    }
    assert_eq!(fmu.get(CLOCK), [0.0; 2]);
    assert_eq!(
        fmu.events().len(),
        1,
        "{way:?}: the first sample is taken at the start"
    );
    let h = 0.05;
    for k in 0..20 {
        let (t, end) = (f64::from(k) * h, f64::from(k + 1) * h);
        match way {
            Way::Exchange2 | Way::Exchange3 => next = fmu.integrate(t, end, next),
            Way::Events3 => {
                fmu.0.enter_steps();
                let (before, due) = (fmu.events().len(), (next - end).abs() < 1e-12);
                let has_event = fmu.step(t, end - t);
                assert_eq!(
                    has_event,
                    due || fmu.events().len() > before,
                    "{end}: eventHandlingNeeded"
                );
            }
            _ => {
                fmu.step(t, end - t);
            }
        }
        seen.push(fmu.get::<1>(X)[0]);
        assert_eq!(fmu.get(CLOCK), [end, 2.0 * end], "{way:?}");
        if has_updates {
            fmu.0.enter_events();
        }
        if has_updates || k < 19 {
            fmu.set(input(end));
        }
        if has_updates {
            next = fmu.update();
            seen.push(next);
        }
    }
    if !has_updates {
        // The event at the stop time belongs to a further step.
        let before = fmu.events().len();
        fmu.set(input(1.0));
        fmu.step(1.0, 1e-6);
        assert_eq!(fmu.events().len(), before + 1);
    }
    (fmu.events(), seen)
}

/// Oracle: x' = 1, then 2 after the first level and so on; samples every 100 ms and every 130 ms take the
/// input of their time, at a communication point that which is set there.
#[test]
fn all_ways_have_the_same_events() {
    assert_eq!(check::<Sampler>(), [""; 0]);
    let mut expected: Vec<_> = (0..=10)
        .map(|k| [0.1 * f64::from(k), 1.0, input(0.1 * f64::from(k))])
        .collect();
    expected.extend((1..8).map(|k| {
        let t = 0.13 * f64::from(k);
        [t, 2.0, input((t / 0.05).floor() * 0.05)]
    }));
    let mut t = 0.0;
    for k in 1..=11 {
        t += 0.33 / f64::from(k);
        expected.extend((t < 1.0).then_some([t, 3.0, 0.33 * f64::from(k)]));
    }
    expected.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let runs = Way::ALL.map(run);
    for (way, (events, _)) in Way::ALL.iter().zip(&runs) {
        assert_eq!(events.len(), expected.len(), "{way:?}: {events:?}");
        for (found, exact) in events.iter().zip(&expected) {
            let error = (0..3)
                .map(|k| (found[k] - exact[k]).abs())
                .fold(0.0, f64::max);
            assert!(error < 1e-11, "{way:?}: {found:?} {exact:?}");
        }
    }
    let near = |a: &[f64], b: &[f64]| {
        a.len() == b.len()
            && a.iter()
                .zip(b)
                .all(|(a, b)| a == b || (a - b).abs() < 1e-11)
    };
    assert!(
        near(&runs[0].1, &runs[1].1) && near(&runs[0].1, &runs[4].1),
        "states and next events"
    );
    assert!(near(&runs[2].1, &runs[3].1));
}

/// A sample that is due at a communication point takes the input that is set there, although the
/// importer's time differs from the model's by rounding: 3·0.1 is more than 0.25 + 0.05. Sixteen
/// rounded additions of numbers up to 0.8 err by at most 16·2⁻⁵⁴: less than a relative 1e-12.
#[test]
fn rounded_times_change_no_sample() {
    for (way, adds_up) in [Way::Steps2, Way::Steps3, Way::Events3]
        .map(|way| [(way, false), (way, true)])
        .concat()
    {
        let fmu = Fmu::new(way);
        fmu.0.enter_initialization();
        fmu.set(input(0.0));
        fmu.0.exit_initialization();
        let (h, mut t, mut ahead) = (0.05, 0.0, 0);
        for k in 0..16 {
            if way == Way::Events3 {
                fmu.update();
                fmu.0.enter_steps();
            }
            fmu.step(t, h);
            t = match adds_up {
                true => t + h,
                false => f64::from(k + 1) * h,
            };
            if way == Way::Events3 {
                fmu.0.enter_events();
            }
            fmu.set(input(t));
            ahead += i32::from(k % 2 == 1 && 0.1 * f64::from((k + 1) / 2) > f64::from(k) * h + h);
        }
        assert!(ahead > 0, "no time is rounded");
        if way == Way::Events3 {
            fmu.update();
        } else {
            fmu.step(t, h / 2.0);
        }
        let mut samples = fmu.events();
        samples.retain(|event| event[1] == 1.0);
        let values = Vec::from_iter(samples.iter().map(|event| event[2]));
        let expected = Vec::from_iter((0..9).map(|k| input(0.1 * f64::from(k))));
        assert_eq!(values, expected, "{way:?}, {adds_up}: {samples:?}");
    }
}
