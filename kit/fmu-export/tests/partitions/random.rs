//! Random calls of the functions for clocks, in any order, in Event Mode and in Scheduled Execution:
//! nothing crashes, a call is done or refused as the standard says, and what is read is always what
//! a counter of its own says. `CLOCK_CALLS` is how many (default 20 000 of each), `CLOCK_SEED` the
//! seed.

use super::*;
use crate::xorshift::Random;

#[rustfmt::skip]
unsafe extern "C-unwind" {
    fn fmi3EnterEventMode(c: C) -> c_int;
    fn fmi3SetIntervalDecimal(c: C, vr: *const u32, n: usize, values: *const f64) -> c_int;
    fn fmi3GetShiftDecimal(c: C, vr: *const u32, n: usize, values: *mut f64) -> c_int;
    fn fmi3SetShiftDecimal(c: C, vr: *const u32, n: usize, values: *const f64) -> c_int;
    fn fmi3GetIntervalFraction(c: C, vr: *const u32, n: usize, a: *mut u64, b: *mut u64, q: *mut c_int) -> c_int;
    fn fmi3SetIntervalFraction(c: C, vr: *const u32, n: usize, a: *const u64, b: *const u64) -> c_int;
    fn fmi3EvaluateDiscreteStates(c: C) -> c_int;
    fn fmi3GetFMUState(c: C, state: *mut C) -> c_int;
    fn fmi3SetFMUState(c: C, state: C) -> c_int;
    fn fmi3FreeFMUState(c: C, state: *mut C) -> c_int;
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Instantiated,
    Initialization,
    Event,
    Step,
    /// Step Mode after a set, and before the next step.
    AfterSet,
    Activation,
    Terminated,
}

/// The model and its clocks, as the standard has them.
#[derive(Clone, Copy, Debug)]
struct Known {
    mode: Mode,
    time: f64,
    /// Times of the last partitions.
    last: [f64; 3],
    active: [bool; 3],
    /// The output clock, in Scheduled Execution.
    told: bool,
    /// Ticks of the three, of all, sum, output.
    values: [i32; 6],
    input: i32,
    /// The qualifier of the countdown's interval.
    qualifier: c_int,
}

const NEW: Known = Known {
    mode: Mode::Instantiated,
    time: 0.0,
    last: [-1.0; 3],
    active: [false; 3],
    told: false,
    values: [0; 6],
    input: 0,
    qualifier: 0,
};
const READ: [u32; 6] = [2001, 2002, 2003, 2004, 2005, 2007];

impl Known {
    /// After a tick of a clock.
    fn tick(&mut self, k: usize) {
        self.values[k] += 1;
        self.values[3] += 1;
        match k {
            1 => self.values[4] += self.input,
            2 => self.values[5] = 1000,
            _ => {}
        }
    }

    /// With what the active clocks compute.
    fn computed(&self) -> Self {
        let mut new = *self;
        (0..3).filter(|k| self.active[*k]).for_each(|k| new.tick(k));
        new
    }

    fn is_output_active(&self) -> bool {
        match self.mode {
            Mode::Activation => self.told,
            _ => self.active.contains(&true) && self.computed().values[3] % 5 == 0,
        }
    }

    fn update(&mut self, at: f64) {
        let active = self.active;
        *self = self.computed();
        self.active = [false; 3];
        self.follow(active[0], active[2], at);
    }

    /// The countdown is over when its clock has ticked; the first clock starts it at 4 s.
    fn follow(&mut self, first: bool, third: bool, at: f64) {
        if third {
            self.qualifier = 0;
        }
        if first && at as i32 == 4 {
            self.qualifier = 2;
        }
    }

    fn can_read(&self, k: usize) -> bool {
        let clocks = [&[0][..], &[1], &[], &[0, 1, 2], &[1], &[2]][k];
        match self.mode {
            Mode::Instantiated | Mode::AfterSet => false,
            Mode::Initialization | Mode::Activation | Mode::Terminated => true,
            _ => clocks.is_empty() || clocks.iter().any(|clock| self.active[*clock]),
        }
    }
}

struct Subject {
    c: C,
    known: Known,
    is_scheduled: bool,
    saved: Vec<(C, Known)>,
    r: Random,
}

impl Subject {
    /// A random call: its name, its status, and whether it must have been done.
    fn call(&mut self) -> (&'static str, c_int, bool) {
        use Mode::*;
        let (c, r, known) = (self.c, &mut self.r, &mut self.known);
        let mode = known.mode;
        let vr = r.of(&[1001, 1001, 1002, 1002, 1003, 1003, 1005, 2001, 9999]);
        let input = IN.iter().position(|clock| *clock == vr);
        let is_clock = input.is_some() || vr == OUT;
        let n = usize::from(r.below(16) > 0);
        let is_null = n == 0 || r.below(32) == 0;
        let sound = n == 0 || !is_null;
        let reads_interval = matches!(mode, Initialization | Event | Activation);
        let (mut number, mut counter, mut qualifier) = (f64::NAN, 0_u64, -1);
        unsafe {
            match r.below(40) {
                0 | 1 => {
                    let status = fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0);
                    if status == 0 {
                        known.mode = Initialization;
                    }
                    ("fmi3EnterInitializationMode", status, mode == Instantiated)
                }
                2 | 3 => {
                    let status = fmi3ExitInitializationMode(c);
                    if status == 0 {
                        known.mode = if self.is_scheduled { Activation } else { Event };
                    }
                    ("fmi3ExitInitializationMode", status, mode == Initialization)
                }
                4 if r.below(16) == 0 => {
                    let status = fmi3Reset(c);
                    if status == 0 {
                        *known = NEW;
                    }
                    ("fmi3Reset", status, true)
                }
                4 if r.below(16) == 0 => {
                    let status = fmi3Terminate(c);
                    if status == 0 {
                        known.mode = Terminated;
                    }
                    let is_right = matches!(mode, Event | Step | AfterSet | Activation);
                    ("fmi3Terminate", status, is_right)
                }
                5 | 6 => {
                    let status = fmi3EnterStepMode(c);
                    if status == 0 {
                        known.mode = Step;
                    }
                    let is_ticking = known.active.contains(&true);
                    ("fmi3EnterStepMode", status, mode == Event && !is_ticking)
                }
                7..10 => {
                    let status = fmi3EnterEventMode(c);
                    if status == 0 {
                        known.mode = Event;
                    }
                    let is_right = matches!(mode, Step | AfterSet);
                    ("fmi3EnterEventMode", status, is_right)
                }
                10 | 11 => {
                    let mut flags = [false; 3];
                    let [a, b, d] = flags.each_mut();
                    let status = fmi3DoStep(c, known.time, 0.5, true, a, b, d, &mut number);
                    if status == 0 {
                        known.time += 0.5;
                        known.mode = Step;
                    }
                    ("fmi3DoStep", status, matches!(mode, Step | AfterSet))
                }
                12..15 => {
                    let status = update_states(c);
                    if status == 0 {
                        known.update(known.time);
                    }
                    ("fmi3UpdateDiscreteStates", status, mode == Event)
                }
                15 => {
                    let status = fmi3EvaluateDiscreteStates(c);
                    ("fmi3EvaluateDiscreteStates", status, mode == Event)
                }
                16..20 => {
                    let on = r.below(4) > 0;
                    let to = if is_null { ptr::null() } else { &raw const on };
                    let status = fmi3SetClock(c, if n == 0 { ptr::null() } else { &vr }, n, to);
                    if let (0, 1, Some(k)) = (status, n, input) {
                        known.active[k] = on;
                    }
                    let is_right = sound && mode == Event && (n == 0 || input.is_some());
                    ("fmi3SetClock", status, is_right)
                }
                20..23 => {
                    let mut on = false;
                    let to = if is_null {
                        ptr::null_mut()
                    } else {
                        &raw mut on
                    };
                    let status = fmi3GetClock(c, &vr, n, to);
                    if status == 0 && n == 1 {
                        let expected = match input {
                            Some(k) => known.active[k],
                            None => known.is_output_active(),
                        };
                        assert_eq!(on, expected, "{vr} {known:?}");
                        known.told &= vr != OUT;
                    }
                    let is_right = sound && matches!(mode, Event | Activation);
                    ("fmi3GetClock", status, is_right && (n == 0 || is_clock))
                }
                23 | 24 => {
                    let to = if is_null {
                        ptr::null_mut()
                    } else {
                        &raw mut number
                    };
                    let status = fmi3GetIntervalDecimal(c, &vr, n, to, &mut qualifier);
                    if status == 0 && n == 1 {
                        let expected = if vr == 1001 {
                            (2, 1.0)
                        } else {
                            (known.qualifier, 0.0)
                        };
                        let was_asked = vr == 1001 && qualifier == 1;
                        assert!(qualifier == expected.0 || was_asked, "{vr} {known:?}");
                        assert!(qualifier == 0 || number == expected.1, "{number} {known:?}");
                        if vr == 1003 {
                            known.qualifier = known.qualifier.min(1);
                        }
                    }
                    let has_interval = n == 0 || matches!(vr, 1001 | 1003);
                    let is_right = sound && reads_interval && has_interval;
                    ("fmi3GetIntervalDecimal", status, is_right)
                }
                25 => {
                    let to = if is_null {
                        ptr::null_mut()
                    } else {
                        &raw mut number
                    };
                    let status = fmi3GetShiftDecimal(c, &vr, n, to);
                    assert!(status != 0 || n == 0 || number == 0.0, "{number}");
                    let is_right = sound && mode == Initialization && (n == 0 || vr == 1001);
                    ("fmi3GetShiftDecimal", status, is_right)
                }
                26 => (
                    "fmi3SetIntervalDecimal",
                    fmi3SetIntervalDecimal(c, &vr, 1, &0.5),
                    false,
                ),
                27 => (
                    "fmi3SetShiftDecimal",
                    fmi3SetShiftDecimal(c, &vr, 1, &0.5),
                    false,
                ),
                28 => {
                    let status = fmi3GetIntervalFraction(
                        c,
                        &vr,
                        1,
                        &mut counter,
                        &mut counter,
                        &mut qualifier,
                    );
                    ("fmi3GetIntervalFraction", status, false)
                }
                29 => {
                    let status = fmi3SetIntervalFraction(c, &vr, 1, &counter, &1);
                    ("fmi3SetIntervalFraction", status, false)
                }
                30 | 31 => {
                    let value = r.below(7) as i32;
                    let status = fmi3SetInt32(c, &2006, 1, &value, 1);
                    let is_right = match mode {
                        Instantiated | Initialization | Activation => true,
                        Event => known.active[1],
                        _ => false,
                    };
                    if status == 0 {
                        known.input = value;
                        known.mode = if mode == Step { AfterSet } else { mode };
                    }
                    ("fmi3SetInt32", status, is_right)
                }
                32..35 => {
                    let k = r.below(6);
                    let mut value = -1;
                    let status = fmi3GetInt32(c, &READ[k], 1, &mut value, 1);
                    if status == 0 {
                        assert_eq!(value, known.computed().values[k], "{} {known:?}", READ[k]);
                    }
                    let is_right = known.can_read(k);
                    ("fmi3GetInt32", status, is_right)
                }
                35 => {
                    let mut state = ptr::null_mut();
                    let status = fmi3GetFMUState(c, &mut state);
                    self.saved.push((state, *known));
                    if self.saved.len() > 4 {
                        let (mut old, _) = self.saved.swap_remove(r.below(4));
                        assert_eq!(fmi3FreeFMUState(c, &mut old), 0);
                    }
                    ("fmi3GetFMUState", status, true)
                }
                36 if !self.saved.is_empty() => {
                    let (state, of_it) = r.of(&self.saved);
                    let status = fmi3SetFMUState(c, state);
                    *known = of_it;
                    ("fmi3SetFMUState", status, true)
                }
                _ => {
                    let last = input.map_or(known.time, |k| known.last[k]);
                    let t = r.of(&[last + 0.25, last + 0.25, last + 1.0, last, -2.0, f64::NAN]);
                    let status = fmi3ActivateModelPartition(c, vr, t);
                    if let (0, Some(k)) = (status, input) {
                        known.tick(k);
                        (known.last[k], known.time) = (t, known.time.max(t));
                        known.told |= known.values[3] % 5 == 0;
                        known.follow(k == 0, k == 2, t);
                    }
                    let is_later = input.is_some_and(|k| t > known.last[k] || status == 0);
                    let is_right = mode == Activation && is_later && t >= 0.0;
                    ("fmi3ActivateModelPartition", status, is_right)
                }
            }
        }
    }
}

#[test]
fn random_calls_in_any_order() {
    let number = |name: &str, default| std::env::var(name).map_or(default, |n| n.parse().unwrap());
    let (calls, seed) = (number("CLOCK_CALLS", 20_000), number("CLOCK_SEED", 1));
    for is_scheduled in [false, true] {
        let fmu = match is_scheduled {
            true => Fmu::scheduled_new(Some(lock), Some(unlock), None),
            false => Fmu::in_event_mode(),
        };
        let mut subject = Subject {
            c: fmu.0,
            known: NEW,
            is_scheduled,
            saved: Vec::new(),
            r: Random(seed),
        };
        let mut done = 0;
        for k in 0..calls {
            let before = subject.known;
            let (name, status, is_right) = subject.call();
            let made = || format!("call {k} of seed {seed}: {name} gave {status}, {before:?}");
            assert_eq!(status == 0, is_right, "{}: {}", made(), last_message());
            assert!(status == 0 || status == 3, "{}", made());
            done += u64::from(status == 0);
            if k % 1000 == 0 {
                MESSAGES.lock().unwrap().clear();
            }
        }
        assert!(5 * done > calls, "{done} of {calls} done");
        for (mut state, _) in std::mem::take(&mut subject.saved) {
            assert_eq!(unsafe { fmi3FreeFMUState(fmu.0, &mut state) }, 0);
        }
    }
}
