//! Events are the same in both interfaces and both versions of FMI: one model, driven as importers do,
//! by C name. And events that accumulate.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

mod ball;
mod model;
mod relay;

use fmu_export::ffi::{CallbackFunctions, EventInfo, Str};
use fmu_export::{check, model_description, model_description3};
use model::{MOST, Sampler};
use std::ffi::{CString, c_int, c_void};
use std::ptr;

type C = *mut c_void;

macro_rules! functions {
    ($($name:ident($($type:ty),*) -> $result:ty;)*) => {
        unsafe extern "C-unwind" { $(fn $name($(_: $type),*) -> $result;)* }
    };
}

#[rustfmt::skip]
functions! {
    fmi2Instantiate(Str, c_int, Str, Str, *const CallbackFunctions, c_int, c_int) -> C; fmi2FreeInstance(C) -> ();
    fmi2EnterInitializationMode(C) -> c_int; fmi2ExitInitializationMode(C) -> c_int; fmi2DoStep(C, f64, f64, c_int) -> c_int;
    fmi2SetReal(C, *const u32, usize, *const f64) -> c_int; fmi2GetReal(C, *const u32, usize, *mut f64) -> c_int;
    fmi2EnterEventMode(C) -> c_int; fmi2NewDiscreteStates(C, *mut EventInfo) -> c_int; fmi2EnterContinuousTimeMode(C) -> c_int;
    fmi2SetTime(C, f64) -> c_int; fmi2SetContinuousStates(C, *const f64, usize) -> c_int;
    fmi2GetDerivatives(C, *mut f64, usize) -> c_int; fmi2GetEventIndicators(C, *mut f64, usize) -> c_int;
    fmi2GetContinuousStates(C, *mut f64, usize) -> c_int;
    fmi3InstantiateModelExchange(Str, Str, Str, bool, bool, C, C) -> C; fmi3FreeInstance(C) -> ();
    fmi3InstantiateCoSimulation(Str, Str, Str, bool, bool, bool, bool, *const u32, usize, C, C, C) -> C;
    fmi3EnterInitializationMode(C, bool, f64, f64, bool, f64) -> c_int; fmi3ExitInitializationMode(C) -> c_int;
    fmi3DoStep(C, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int; fmi3EnterStepMode(C) -> c_int;
    fmi3SetFloat64(C, *const u32, usize, *const f64, usize) -> c_int; fmi3GetFloat64(C, *const u32, usize, *mut f64, usize) -> c_int;
    fmi3EnterEventMode(C) -> c_int; fmi3UpdateDiscreteStates(C, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
    fmi3EnterContinuousTimeMode(C) -> c_int; fmi3SetTime(C, f64) -> c_int; fmi3SetContinuousStates(C, *const f64, usize) -> c_int;
    fmi3GetContinuousStateDerivatives(C, *mut f64, usize) -> c_int; fmi3GetEventIndicators(C, *mut f64, usize) -> c_int;
    fmi3GetContinuousStates(C, *mut f64, usize) -> c_int;
}

/// The value references of vectors are those of their first elements.
const W: u32 = 0;
const X: u32 = 1;
const TIMES: u32 = 2;

/// How an instance is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Exchange2,
    Exchange3,
    Steps2,
    Steps3,
    /// Steps of FMI 3.0 with Event Mode.
    Events3,
}

const WAYS: [Way; 5] = [
    Way::Exchange2,
    Way::Exchange3,
    Way::Steps2,
    Way::Steps3,
    Way::Events3,
];

struct Fmu {
    c: C,
    way: Way,
}

fn attribute(xml: &str, name: &str) -> CString {
    let (_, rest) = xml.split_once(&format!("{name}=\"")).unwrap();
    CString::new(rest.split_once('"').unwrap().0).unwrap()
}

impl Fmu {
    fn new(way: Way) -> Self {
        let (name, none) = (c"sampler".as_ptr(), ptr::null_mut());
        let guid = attribute(&model_description::<Sampler>().unwrap(), "guid");
        let token = attribute(
            &model_description3::<Sampler>().unwrap(),
            "instantiationToken",
        );
        let functions = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: none,
        };
        let c = unsafe {
            match way {
                Way::Exchange2 | Way::Steps2 => {
                    let kind = c_int::from(way == Way::Steps2);
                    fmi2Instantiate(name, kind, guid.as_ptr(), ptr::null(), &functions, 0, 0)
                }
                Way::Exchange3 => fmi3InstantiateModelExchange(
                    name,
                    token.as_ptr(),
                    ptr::null(),
                    false,
                    false,
                    none,
                    none,
                ),
                _ => {
                    let has_event_mode = way == Way::Events3;
                    let text = token.as_ptr();
                    fmi3InstantiateCoSimulation(
                        name,
                        text,
                        ptr::null(),
                        false,
                        false,
                        has_event_mode,
                        false,
                        ptr::null(),
                        0,
                        none,
                        none,
                        none,
                    )
                }
            }
        };
        assert!(!c.is_null());
        Self { c, way }
    }

    fn is_2(&self) -> bool {
        matches!(self.way, Way::Exchange2 | Way::Steps2)
    }

    fn call(
        &self,
        two: unsafe extern "C-unwind" fn(C) -> c_int,
        three: unsafe extern "C-unwind" fn(C) -> c_int,
    ) {
        assert_eq!(
            unsafe {
                if self.is_2() {
                    two(self.c)
                } else {
                    three(self.c)
                }
            },
            0
        );
    }

    fn set(&self, value: f64) {
        let status = unsafe {
            match self.is_2() {
                true => fmi2SetReal(self.c, &W, 1, &value),
                false => fmi3SetFloat64(self.c, &W, 1, &value, 1),
            }
        };
        assert_eq!(status, 0);
    }

    fn get<const N: usize>(&self, vr: u32) -> [f64; N] {
        let (mut values, numbers) = ([f64::NAN; N], Vec::from_iter((vr..).take(N)));
        let to = values.as_mut_ptr();
        let status = unsafe {
            match self.is_2() {
                true => fmi2GetReal(self.c, numbers.as_ptr(), N, to),
                false => fmi3GetFloat64(self.c, &vr, 1, to, N),
            }
        };
        assert_eq!(status, 0);
        values
    }

    fn read(
        &self,
        two: unsafe extern "C-unwind" fn(C, *mut f64, usize) -> c_int,
        three: unsafe extern "C-unwind" fn(C, *mut f64, usize) -> c_int,
    ) -> f64 {
        let mut value = f64::NAN;
        let f = if self.is_2() { two } else { three };
        assert_eq!(unsafe { f(self.c, &mut value, 1) }, 0);
        value
    }

    /// Updates the discrete states; returns the time of the next event, infinite if there is none.
    fn update(&self) -> f64 {
        loop {
            let (again, next) = unsafe {
                if self.is_2() {
                    let mut info = EventInfo::default();
                    assert_eq!(fmi2NewDiscreteStates(self.c, &mut info), 0);
                    let has_next = info.next_event_time_defined != 0;
                    (
                        info.new_discrete_states_needed != 0,
                        has_next.then_some(info.next_event_time),
                    )
                } else {
                    let (mut flags, mut next) = ([false; 5], f64::NAN);
                    let [a, b, c, d, e] = flags.each_mut();
                    assert_eq!(
                        fmi3UpdateDiscreteStates(self.c, a, b, c, d, e, &mut next),
                        0
                    );
                    (flags[0], flags[4].then_some(next))
                }
            };
            if !again {
                return next.unwrap_or(f64::INFINITY);
            }
        }
    }

    fn set_time(&self, t: f64, x: f64) {
        unsafe {
            match self.is_2() {
                true => assert_eq!(
                    (
                        fmi2SetTime(self.c, t),
                        fmi2SetContinuousStates(self.c, &x, 1)
                    ),
                    (0, 0)
                ),
                false => assert_eq!(
                    (
                        fmi3SetTime(self.c, t),
                        fmi3SetContinuousStates(self.c, &x, 1)
                    ),
                    (0, 0)
                ),
            }
        }
    }

    /// Model Exchange from `t` to `end`, where the next event is at `next`; the rate is constant
    /// between events, so that Euler's method and straight lines are exact.
    fn integrate(&self, mut t: f64, end: f64, mut next: f64) -> f64 {
        loop {
            self.call(fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode);
            let until = end.min(next);
            let x = self.read(fmi2GetContinuousStates, fmi3GetContinuousStates);
            let rate = self.read(fmi2GetDerivatives, fmi3GetContinuousStateDerivatives);
            let before = self.read(fmi2GetEventIndicators, fmi3GetEventIndicators);
            self.set_time(until, x + rate * (until - t));
            let after = self.read(fmi2GetEventIndicators, fmi3GetEventIndicators);
            let is_crossed = (before > 0.0) != (after > 0.0);
            let from = t;
            t = until;
            if is_crossed {
                t = from + (until - from) * before / (before - after);
                while {
                    self.set_time(t, x + rate * (t - from));
                    (self.read(fmi2GetEventIndicators, fmi3GetEventIndicators) > 0.0)
                        == (before > 0.0)
                } {
                    t += f64::EPSILON * t;
                }
            }
            if !is_crossed && t == end {
                return next;
            }
            self.call(fmi2EnterEventMode, fmi3EnterEventMode);
            next = self.update();
        }
    }

    /// A communication step; whether it says that events have to be handled.
    fn step(&self, t: f64, h: f64) -> bool {
        let (mut flags, mut last) = ([false; 3], 0.0);
        let [event, terminate, early] = flags.each_mut();
        let status = unsafe {
            match self.is_2() {
                true => fmi2DoStep(self.c, t, h, 1),
                false => fmi3DoStep(self.c, t, h, true, event, terminate, early, &mut last),
            }
        };
        assert_eq!((status, flags[1], flags[2]), (0, false, false));
        flags[0]
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

impl Drop for Fmu {
    fn drop(&mut self) {
        unsafe {
            if self.is_2() {
                fmi2FreeInstance(self.c)
            } else {
                fmi3FreeInstance(self.c)
            }
        }
    }
}

/// What the model is given at a communication point.
fn input(t: f64) -> f64 {
    1.0 + (20.0 * t).round()
}

/// The events of a run with 20 steps of 50 ms, and what was seen on the way.
fn run(way: Way) -> (Vec<[f64; 3]>, Vec<f64>) {
    let fmu = Fmu::new(way);
    unsafe {
        match fmu.is_2() {
            true => assert_eq!(fmi2EnterInitializationMode(fmu.c), 0),
            false => assert_eq!(
                fmi3EnterInitializationMode(fmu.c, false, 0.0, 0.0, false, 0.0),
                0
            ),
        }
    }
    fmu.set(input(0.0));
    fmu.call(fmi2ExitInitializationMode, fmi3ExitInitializationMode);
    let has_updates = !matches!(way, Way::Steps2 | Way::Steps3);
    let (mut next, mut seen) = (f64::NAN, Vec::new());
    if has_updates {
        next = fmu.update();
        seen.push(next);
    }
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
                unsafe { assert_eq!(fmi3EnterStepMode(fmu.c), 0) };
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
        if has_updates {
            fmu.call(fmi2EnterEventMode, fmi3EnterEventMode);
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
    let runs = WAYS.map(run);
    for (way, (events, _)) in WAYS.iter().zip(&runs) {
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
